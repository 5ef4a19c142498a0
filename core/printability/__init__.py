"""What of the object will not print or not show: thin features, a small foot, flat slopes with contrast on them."""

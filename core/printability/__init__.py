"""Parts of the object that will not print well or not show: thin features, a small foot, contrast on flat slopes."""

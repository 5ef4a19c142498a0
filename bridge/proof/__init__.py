"""The soft proof: the object as it will print, in the viewport, while it is painted."""

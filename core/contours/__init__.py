"""From outlines to contours: smooth, evenly spaced lines half a line inside the surface, and the room around them."""

"""What will be seen of the pattern: seams, tracelines, slopes, and how to turn the object."""

"""What is found before the print, shown on the object: overlays, orientations, faults of the mesh."""

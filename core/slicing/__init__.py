"""From triangles to the clean, textured outlines of every layer."""

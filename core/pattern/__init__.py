"""From outlines to waved outlines: filtering, sampling, tone to shape, tessellation, and how well it fits."""

"""From tone to shape: modulation, solid regions, and the waved outlines of the outer wall."""

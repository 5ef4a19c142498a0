"""The strands of a print as Blender Curves: the preview with its colors, which of it is shown, prints from files."""

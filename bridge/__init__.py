"""The only code that reads or writes Blender data."""

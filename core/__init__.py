"""Dual-colour slicing without Blender: numpy, shapely and Pillow only, never bpy."""

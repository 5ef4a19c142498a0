"""Dual-color slicing without Blender: numpy, shapely and Pillow only, never bpy."""

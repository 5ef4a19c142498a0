"""The only code that reads or writes Blender data."""

import bpy  # noqa: F401  outside Blender this has to come before bmesh and mathutils, which it brings along

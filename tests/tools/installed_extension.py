"""Run by tests/tools/test_package.py in a process of its own: install a package, use it, take it out again.

python installed_extension.py PACKAGE.zip
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import bpy  # isort: split

import addon_utils  # bpy makes it importable

MODULE = "bl_ext.user_default.dualcolor"


def traces() -> list[str]:
    """Everything in Blender that bears the extension's name."""
    names = [name for name in dir(bpy.types) if "dualcolor" in name.lower()]
    for kind in (bpy.types.Object, bpy.types.Scene, bpy.types.WindowManager, bpy.types.Material, bpy.types.Mesh):
        names += [f"{kind.__name__}.{name}" for name in dir(kind) if "dualcolor" in name.lower()]
    for menu in (bpy.types.TOPBAR_MT_file_export, bpy.types.TOPBAR_MT_file_import, bpy.types.VIEW3D_MT_add):
        drawn = getattr(menu.draw, "_draw_funcs", [])
        names += [f"{menu.__name__}:{draw.__name__}" for draw in drawn if "dualcolor" in draw.__module__]
    return sorted(names)


def main() -> None:
    """Print what was found as JSON on the last line."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    found = {"before": traces()}
    bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
    found["installed"] = traces()
    bpy.ops.mesh.primitive_cylinder_add(radius=0.005, depth=0.006)
    bpy.ops.dualcolor.generate()
    gcode = Path(sys.argv[1]).with_suffix(".gcode")
    bpy.ops.dualcolor.export_gcode(filepath=str(gcode))
    found["bytes"] = gcode.stat().st_size
    addon_utils.disable(MODULE)
    found["disabled"] = traces()
    addon_utils.enable(MODULE)
    found["again"] = traces()
    print(json.dumps(found))


main()

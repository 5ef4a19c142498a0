"""Where the user's own presets are kept."""

from __future__ import annotations

from pathlib import Path

import bpy

_ROOT = __package__.rpartition(".")[0]


def user_presets() -> Path:
    """The user's folder of presets, with one folder for each kind in it; it need not exist yet.

    It is the extension's own folder for its user's files, which survives updates; for the program without an
    installed extension it lies among Blender's settings.
    """
    try:
        return Path(bpy.utils.extension_path_user(_ROOT, path="presets"))
    except ValueError:
        return Path(bpy.utils.user_resource("CONFIG", path=f"{_ROOT}/presets"))

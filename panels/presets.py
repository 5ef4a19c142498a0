"""Presets at the top of the sidebar: one menu for each kind, and what can be done with all settings."""

from __future__ import annotations

from typing import Any

import bpy

from ..bridge import preset_folder
from ..bridge.properties import values_of
from ..bridge.strands.preview import source_of
from ..core.errors import SettingsError
from ..core.settings.presets import KINDS, PRESETS, Preset, agrees, preset_files, read_preset
from ..operators.presets import (
    DUALCOLOR_OT_apply_preset,
    DUALCOLOR_OT_export_settings,
    DUALCOLOR_OT_import_settings,
    DUALCOLOR_OT_remove_preset,
    DUALCOLOR_OT_reset_settings,
    DUALCOLOR_OT_save_preset,
)
from .rows import fitting
from .tab import ObjectPanel

_MENU_SHARE = 0.55  # of the sidebar's width
# Presets by file and time of change: a panel is drawn at every move of the mouse.
_read: dict[tuple[str, int], Preset | None] = {}


def presets_of(kind: str) -> dict[str, Preset | None]:
    """The presets of a kind by name, the user's own last; None where a file is broken."""
    found = {}
    for name, path in preset_files(preset_folder.user_presets(), (kind,)).items():
        key = str(path), path.stat().st_mtime_ns
        if key not in _read:
            try:
                _read[key] = read_preset(path)
            except SettingsError:
                _read[key] = None
        found[name] = _read[key]
    return found


def chosen_presets(kind: str, values: dict[str, Any]) -> list[str]:
    """Names of the presets of a kind whose settings are among these."""
    return [name for name, preset in presets_of(kind).items() if preset and agrees(preset, values)]


def is_own(kind: str, name: str) -> bool:
    """Whether a preset is one of the user's own."""
    return not (PRESETS / kind / f"{name}.json").exists()


class DUALCOLOR_PT_presets(ObjectPanel, bpy.types.Panel):
    """What is printed with what, chosen by name."""

    bl_label = "Presets"
    bl_parent_id = "DUALCOLOR_PT_main"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        """The menu of what concerns all settings, at the right end of the heading."""
        self.layout.menu(DUALCOLOR_MT_settings.__name__, text="", icon="DOWNARROW_HLT")

    def draw(self, context: bpy.types.Context) -> None:
        """A row a kind: the chosen preset, save, remove."""
        values = values_of(source_of(context.object).dualcolor)
        column = self.layout.column()
        for kind in KINDS:
            chosen = chosen_presets(kind, values)
            own = [name for name in chosen if is_own(kind, name)]
            labels = [preset.label for name, preset in presets_of(kind).items() if preset and name in (own or chosen)]
            row = column.split(factor=0.25)
            row.label(text=kind.title())
            row = row.row(align=True)
            short = f"{labels[0]} + {len(labels) - 1} more" if len(labels) > 1 else "".join(labels)
            text = fitting(context, " + ".join(labels), short, _MENU_SHARE)
            row.menu(f"DUALCOLOR_MT_{kind}_presets", text=text or "Custom", translate=not text)
            row.operator(DUALCOLOR_OT_save_preset.bl_idname, text="", icon="ADD").kind = kind
            if own:
                button = row.operator(DUALCOLOR_OT_remove_preset.bl_idname, text="", icon="REMOVE")
                button.kind, button.name = kind, own[0]


class DUALCOLOR_MT_settings(bpy.types.Menu):
    """What can be done with all settings of an object."""

    bl_label = "All Settings"

    def draw(self, _context: bpy.types.Context) -> None:
        """Reset, import, export."""
        self.layout.operator(DUALCOLOR_OT_reset_settings.bl_idname, icon="LOOP_BACK")
        self.layout.separator()
        self.layout.operator(DUALCOLOR_OT_import_settings.bl_idname, icon="IMPORT")
        self.layout.operator(DUALCOLOR_OT_export_settings.bl_idname, icon="EXPORT")


def _preset_menu(kind: str) -> type[bpy.types.Menu]:
    def draw(self: bpy.types.Menu, context: bpy.types.Context) -> None:
        chosen = chosen_presets(kind, values_of(source_of(context.object).dualcolor))
        found = presets_of(kind)
        first_own = next((name for name in found if is_own(kind, name)), "")
        for name, preset in found.items():
            if name == first_own:
                self.layout.separator()
            icon = "CHECKMARK" if name in chosen else "NONE" if preset else "ERROR"
            text = preset.label if preset else name
            self.layout.operator(DUALCOLOR_OT_apply_preset.bl_idname, text=text, icon=icon, translate=False).name = name

    return type(
        f"DUALCOLOR_MT_{kind}_presets",
        (bpy.types.Menu,),
        {
            "__doc__": f"Presets of the kind {kind}.",
            "__module__": __name__,
            "bl_label": f"{kind.title()} Presets",
            "draw": draw,
        },
    )


MENUS = (DUALCOLOR_MT_settings, *map(_preset_menu, KINDS))

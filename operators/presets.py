"""Presets and settings of an object: apply, save, remove, reset, export, import."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy_extras.io_utils import ImportHelper

from ..bridge import preset_folder
from ..bridge.properties import from_settings, to_settings, values_of
from ..bridge.strands.preview import source_of
from ..core.errors import PrintError
from ..core.files import write_file
from ..core.settings import PrintSettings
from ..core.settings.presets import (
    KINDS,
    preset_files,
    preset_values,
    read_preset,
    read_settings,
    remove_preset,
    save_preset,
    settings_json,
)
from .file_choice import FileChoice
from .polls import has_own_settings, has_printable
from .refusal import refused

_KIND_ITEMS = [(kind, kind.title(), "") for kind in KINDS]


class _SettingsOperator:
    """What operators on an object's settings have in common: `apply` does it and returns a sentence on what it did."""

    outcome = "INFO"
    """How the sentence is reported."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object that can be printed is needed."""
        return has_printable(cls, context)

    def apply(self, group: bpy.types.PropertyGroup) -> str:
        """Do it.

        Raises:
            PrintError: to be reported to the user; nothing has been changed.
        """
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Do it and report."""
        try:
            message = self.apply(source_of(context.object).dualcolor)
        except PrintError as problem:
            return refused(self, problem)
        self.report({self.outcome}, message)
        return {"FINISHED"}


class _ChangesSettings(_SettingsOperator):
    """What operators that give an object other settings have in common."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object whose settings are kept in this file is needed."""
        return has_own_settings(cls, context)

    def change(self, group: bpy.types.PropertyGroup, values: dict[str, Any], message: str) -> str:
        """Give an object some settings, validated with its others; the message, with what was left out.

        What this version does not know is, as in files of another one; if that is all there is, they are no settings.

        Raises:
            SettingsError: one does not fit, or none is known.
        """
        former = values_of(group)
        known = {name: value for name, value in values.items() if name in former}
        from_settings(group, PrintSettings().changed({**former, **(known or values)}))
        unknown = ", ".join(name for name in values if name not in known)
        if not unknown:
            return message
        self.outcome = "WARNING"
        return f"{message}; left out, because this version has no such setting: {unknown}"


class DUALCOLOR_OT_apply_preset(_ChangesSettings, bpy.types.Operator):
    """Take over the settings of this preset"""

    bl_idname = "dualcolor.apply_preset"
    bl_label = "Apply Preset"
    bl_options = {"UNDO"}  # noqa: RUF012  (Blender reads the class)
    name: bpy.props.StringProperty(name="Name", description="Of the preset", options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        """What the preset is for, as the tooltip of its entry."""
        path = preset_files(preset_folder.user_presets()).get(properties.name)
        try:
            return (read_preset(path).description if path else "") or cls.__doc__
        except PrintError as problem:
            return str(problem)

    def apply(self, group: bpy.types.PropertyGroup) -> str:
        """Change the settings that the preset names, no others."""
        return self.change(group, preset_values([self.name], preset_folder.user_presets()), f"Preset {self.name}")


class DUALCOLOR_OT_save_preset(_SettingsOperator, bpy.types.Operator):
    """Keep the object's settings of this kind as a preset of your own, for all files"""

    bl_idname = "dualcolor.save_preset"
    bl_label = "Save Preset"
    kind: bpy.props.EnumProperty(name="Kind", items=_KIND_ITEMS, default="quality", options={"HIDDEN"})
    name: bpy.props.StringProperty(
        name="Name", description="Of the new preset", default="My preset", options={"SKIP_SAVE"}
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Ask for the name."""
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, _context: bpy.types.Context) -> None:
        """The name, and what becomes of a preset that has it."""
        self.layout.prop(self, "name")
        own = preset_folder.user_presets()
        taken = preset_files(own, (self.kind,)).get(self.name.strip())
        if taken and own in taken.parents:
            self.layout.label(text="Replaces your preset of that name", icon="ERROR")

    def apply(self, group: bpy.types.PropertyGroup) -> str:
        """Write the preset's file."""
        path = save_preset(preset_folder.user_presets(), self.kind, self.name, to_settings(group))
        return f"Preset {path.stem} saved"


class DUALCOLOR_OT_remove_preset(_SettingsOperator, bpy.types.Operator):
    """Delete the chosen preset, one of your own"""

    bl_idname = "dualcolor.remove_preset"
    bl_label = "Remove Preset"
    kind: bpy.props.EnumProperty(name="Kind", items=_KIND_ITEMS, default="quality", options={"HIDDEN"})
    name: bpy.props.StringProperty(name="Name", options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask first: a deleted file cannot be brought back by undo."""
        title = f"Remove the preset {self.name}?"
        return context.window_manager.invoke_confirm(self, event, title=title, confirm_text="Remove")

    def apply(self, group: bpy.types.PropertyGroup) -> str:
        """Delete the preset's file; the object keeps its settings."""
        remove_preset(preset_folder.user_presets(), self.kind, self.name)
        return f"Preset {self.name} removed"


class DUALCOLOR_OT_reset_settings(_ChangesSettings, bpy.types.Operator):
    """Give the object the defaults of all settings"""

    bl_idname = "dualcolor.reset_settings"
    bl_label = "Reset to Defaults"
    bl_options = {"UNDO"}  # noqa: RUF012  (Blender reads the class)

    def apply(self, group: bpy.types.PropertyGroup) -> str:
        """Reset all settings; the picture stays."""
        from_settings(group, PrintSettings())
        return "All settings have their defaults"


class DUALCOLOR_OT_import_settings(_ChangesSettings, ImportHelper, bpy.types.Operator):
    """Read settings from a JSON file or from the header of a G-code file of this program"""

    bl_idname = "dualcolor.import_settings"
    bl_label = "Import Settings"
    bl_options = {"UNDO"}  # noqa: RUF012  (Blender reads the class)
    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default="*.json;*.gcode;*.gco;*.g", options={"HIDDEN"})

    def apply(self, group: bpy.types.PropertyGroup) -> str:
        """Change the settings that the file names, no others."""
        path = Path(bpy.path.abspath(self.filepath))
        values = read_settings(path)
        return self.change(group, values, f"{len(values)} settings from {path.name}")


class DUALCOLOR_OT_export_settings(_SettingsOperator, FileChoice, bpy.types.Operator):
    """Write all settings of the object as JSON"""

    bl_idname = "dualcolor.export_settings"
    bl_label = "Export Settings"
    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def apply(self, group: bpy.types.PropertyGroup) -> str:
        """Write the file."""
        path = Path(bpy.path.abspath(self.filepath))
        write_file(path, settings_json(to_settings(group)).encode())
        return f"{path.name} written"


OPERATORS = (
    DUALCOLOR_OT_apply_preset,
    DUALCOLOR_OT_save_preset,
    DUALCOLOR_OT_remove_preset,
    DUALCOLOR_OT_reset_settings,
    DUALCOLOR_OT_import_settings,
    DUALCOLOR_OT_export_settings,
)

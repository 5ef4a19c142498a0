"""The settings of an object as Blender properties, made from `PrintSettings` so that nothing is declared twice."""

from __future__ import annotations

import json
import re
from contextlib import suppress
from dataclasses import Field, fields
from typing import Any

import bpy

from ..core.errors import SettingsError
from ..core.settings import PrintSettings
from .input.seam_visibility import visibility_names
from .kept import kept_json
from .proof.soft_proof import follow_paint, follow_settings, is_proofed
from .strands.preview import is_print_shown, show_print
from .units import LENGTH_DIGITS

_REPORTED = ("bounds_mm", "layers", "time_s", "filament", "settings", "warnings")
_SPELLED = {"Xy": "XY", "Dont": "Don't", "Toolchange": "Tool Change"}
_TITLES = {declared.name: declared.name.replace("_", " ").title().split() for declared in fields(PrintSettings)}
_LABELS = {name: " ".join(_SPELLED.get(word, word) for word in words) for name, words in _TITLES.items()}
_NAMES = re.compile(rf"(?<!\")\b({'|'.join(name for name in _LABELS if '_' in name)})\b")
_WORD = re.compile(r"(?!xatlas)[a-z]+,? ")
_RELATIVE = "PATH_SUPPORTS_BLEND_RELATIVE"
_SEARCHED = {"seam_visibility": visibility_names}
OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}
"""An object of another file that is overridden in this one has settings of its own."""
FLOAT_DIGITS = 6
"""A FloatProperty is single precision: 0.2 comes back as 0.200000003, which six significant digits undo."""


def label_of(declared: Field[Any]) -> str:
    """A setting's name in title case; with its unit unless the field itself shows it."""
    title = _LABELS[declared.name]
    unit = declared.metadata["unit"]
    return f"{title} ({unit})" if unit not in ("", "mm", "%") else title


def with_labels(sentence: str) -> str:
    """A sentence of the core with settings as Blender shows them: "Brim Width" instead of "brim_width"."""
    return _NAMES.sub(lambda found: _LABELS[found[0]], sentence)


def as_shown(sentence: str) -> str:
    """A sentence of the core as Blender shows it: settings named as there, a capital in front unless it is a name."""
    shown = with_labels(sentence)
    named = not _WORD.match(shown) or any(shown.startswith(f"{obj.name} ") for obj in bpy.data.objects)
    return shown if named else shown[0].upper() + shown[1:]


def property_of(declared: Field[Any]) -> Any:
    """The Blender property of a setting: its type, default, limits, choices and description.

    Lengths have the unit of camera lenses, the only one that Blender shows in mm in every scene that has units.
    """
    limits, default = declared.metadata, declared.default
    common = {"name": label_of(declared), "default": default, "description": limits["description"]}
    common |= {"update": _settings_changed, "override": OVERRIDABLE}
    if limits["choices"]:
        items = [(choice, choice.replace("_", " ").title(), "") for choice in limits["choices"]]
        return bpy.props.EnumProperty(items=items, **common)
    if isinstance(default, bool):
        return bpy.props.BoolProperty(**common)
    if isinstance(default, int):
        return bpy.props.IntProperty(min=int(limits["low"]), max=int(limits["high"]), **common)
    if declared.name in _SEARCHED:
        return bpy.props.StringProperty(search=_SEARCHED[declared.name], search_options={"SUGGESTION"}, **common)
    if isinstance(default, str):
        return bpy.props.StringProperty(subtype="FILE_PATH", options={_RELATIVE}, **common)
    step = 1 if limits["high"] <= 10 else 100
    shown = {"step": step, "precision": 3 if step == 1 else 1}
    length = {"unit": "CAMERA", "precision": LENGTH_DIGITS}
    shown |= {"mm": length, "%": {"subtype": "PERCENTAGE"}}.get(limits["unit"], {})
    return bpy.props.FloatProperty(min=limits["low"], max=limits["high"], **shown, **common)


def values_of(group: bpy.types.PropertyGroup) -> dict[str, Any]:
    """All settings by name, not validated together; paths that begin with // are made absolute."""
    values = {declared.name: getattr(group, declared.name) for declared in fields(PrintSettings)}
    values["calibration_file"] = bpy.path.abspath(values["calibration_file"], library=group.id_data.library)
    return {
        name: float(f"{value:.{FLOAT_DIGITS}g}") if isinstance(value, float) else value
        for name, value in values.items()
    }


def to_settings(group: bpy.types.PropertyGroup) -> PrintSettings:
    """The settings that an object holds.

    Raises:
        SettingsError: two of them are at odds.
    """
    return PrintSettings(**values_of(group))


def from_settings(group: bpy.types.PropertyGroup, settings: PrintSettings) -> None:
    """Give an object all settings; those that it has already stay as they are, relative paths too."""
    former = values_of(group)
    for name, value in settings.as_dict().items():
        if former[name] != value:
            setattr(group, name, value)


def set_report(group: bpy.types.PropertyGroup, report: dict[str, Any]) -> None:
    """Store what a finished job reports, warnings included."""
    group.report = json.dumps(report)


def report_of(group: bpy.types.PropertyGroup) -> dict[str, Any]:
    """What the last job reported; empty before the first."""
    return kept_json(group.report, {}, _REPORTED)


def set_findings(group: bpy.types.PropertyGroup, counts: dict[str, int]) -> None:
    """Store what a check of the model has found; an empty dict is no check."""
    group.findings = json.dumps(counts) if counts else ""


def findings_of(group: bpy.types.PropertyGroup) -> dict[str, int]:
    """What the last check of the model has found, by kind; empty before the first."""
    return kept_json(group.findings, {})


def repaint_proof(obj: bpy.types.Object) -> None:
    """Make the soft proof of an object, if it has one, anew: of another picture, by other UVs, in other units."""
    with suppress(SettingsError):
        follow_paint(obj, to_settings(obj.dualcolor))


def _settings_changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    with suppress(SettingsError):  # two that are at odds while several are changed
        follow_settings(group.id_data, to_settings(group))


@bpy.app.handlers.persistent
def _undone(*_: object) -> None:
    """After undo and redo."""
    for obj in bpy.data.objects:
        if obj.is_editable and is_proofed(obj):
            with suppress(SettingsError):
                follow_settings(obj, to_settings(obj.dualcolor), undone=True)


def _image_changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    repaint_proof(group.id_data)


def _get_show_print(group: bpy.types.PropertyGroup) -> bool:
    return is_print_shown(group.id_data)


def _set_show_print(group: bpy.types.PropertyGroup, shown: bool) -> None:
    show_print(group.id_data, shown)
    if not shown:
        repaint_proof(group.id_data)  # which is seen again


_OWN = {
    "image": bpy.props.PointerProperty(
        type=bpy.types.Image,
        name="Image",
        override=OVERRIDABLE,
        description="Picture to print; without one the image of the material, then the active color attribute is used",
        update=_image_changed,
    ),
    "support_enforcers": bpy.props.PointerProperty(
        type=bpy.types.Collection,
        name="Enforcers",
        override=OVERRIDABLE,
        description="Overhangs inside the meshes of this collection get supports; the meshes are not printed",
    ),
    "support_blockers": bpy.props.PointerProperty(
        type=bpy.types.Collection,
        name="Blockers",
        override=OVERRIDABLE,
        description="Overhangs inside the meshes of this collection get no supports; the meshes are not printed",
    ),
    "report": bpy.props.StringProperty(
        name="Report", description="Figures of the last job, JSON", options={"HIDDEN"}, override=OVERRIDABLE
    ),
    "findings": bpy.props.StringProperty(
        name="Findings", description="What the last check found, JSON", options={"HIDDEN"}, override=OVERRIDABLE
    ),
    "show_bed": bpy.props.BoolProperty(
        name="Show Bed",
        override=OVERRIDABLE,
        description="Draw the printer's volume that both nozzles reach, and each nozzle's reach on the bed",
    ),
    "show_print": bpy.props.BoolProperty(
        name="Show Print",
        description="Show the strands of the predicted print in place of the model",
        get=_get_show_print,
        set=_set_show_print,
    ),
}

DualColorProperties = type(
    "DualColorProperties",
    (bpy.types.PropertyGroup,),
    {
        "__doc__": "Settings, picture and last report, stored with the object.",
        "__module__": __name__,
        "__annotations__": {declared.name: property_of(declared) for declared in fields(PrintSettings)} | _OWN,
    },
)


def register() -> None:
    """Give every object its settings."""
    bpy.utils.register_class(DualColorProperties)
    bpy.types.Object.dualcolor = bpy.props.PointerProperty(type=DualColorProperties, override=OVERRIDABLE)
    for handlers in (bpy.app.handlers.undo_post, bpy.app.handlers.redo_post):
        handlers.append(_undone)


def unregister() -> None:
    """Take them away."""
    for handlers in (bpy.app.handlers.undo_post, bpy.app.handlers.redo_post):
        handlers.remove(_undone)
    del bpy.types.Object.dualcolor
    bpy.utils.unregister_class(DualColorProperties)

"""Settings by name from files: presets, the program's and the user's own, saved settings, headers of G-code files."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from ..errors import OutputError, SettingsError
from ..files import MOST_JSON_BYTES, read_json, without_mark, write_file
from ..records import dataclass
from .header_text import read_back
from .print_settings import PrintSettings

PRESETS = Path(__file__).resolve().parent.parent.parent / "presets"
# The groups of settings that presets of each kind hold.
KINDS = {"printer": ("printer",), "filament": ("filament",), "quality": ("print",), "pattern": ("pattern", "texture")}
GCODE_SUFFIXES = (".gcode", ".gco", ".g")
# Windows takes the names in front for devices, whatever their suffix.
_NAME = re.compile(r"(?!(con|prn|aux|nul|com\d|lpt\d)(\.|$))\w[\w .+-]{0,59}", re.IGNORECASE)


@dataclass(frozen=True)
class Preset:
    """Some settings under a name.

    Attributes:
        label: as the sidebar shows it.
        description: what it is for, a sentence without a full stop.
        settings: by name, not validated yet.
    """

    label: str
    description: str
    settings: dict[str, Any]


def preset_files(own: Path | None = None, kinds: Sequence[str] = tuple(KINDS)) -> dict[str, Path]:
    """The presets' files by name: printers, filaments, qualities, patterns; of each kind the user's own last.

    Args:
        own: the user's folder, with one folder for each kind in it.
        kinds: of the presets that are looked for.
    """
    folders = [folder / kind for kind in kinds for folder in (PRESETS, own) if folder is not None]
    return {path.stem: path for folder in folders for path in sorted(folder.glob("*.json"))}


def read_preset(path: Path) -> Preset:
    """The preset in a file; one with the facts of a printer chooses that printer, whatever file it was copied from.

    Raises:
        SettingsError: it cannot be read or is no preset.
    """
    values = _object(path)
    settings = values.get("settings")
    if not isinstance(settings, dict):
        raise SettingsError(f"{path} is no preset", 'its settings are written as {"settings": {"layer_height": 0.2}}')
    if isinstance(values.get("printer"), dict):
        settings = {**settings, "printer": path.stem}
    label = str(values.get("label", path.stem))
    return Preset(label, str(values.get("description", "")), settings)


def preset_values(names: Sequence[str], own: Path | None = None) -> dict[str, Any]:
    """The settings of some presets; where two disagree, the later one counts.

    Args:
        names: of the presets.
        own: the user's folder.

    Raises:
        SettingsError: there is no preset of that name, or its file is broken.
    """
    files = preset_files(own)
    values: dict[str, Any] = {}
    for name in names:
        if name not in files:
            raise SettingsError(f"there is no preset named {name!r}", f"choose among {', '.join(files)}")
        values |= read_preset(files[name]).settings
    return values


def kind_settings(kind: str) -> tuple[str, ...]:
    """Names of the settings that a preset of this kind holds when the user saves it."""
    return tuple(declared.name for declared in fields(PrintSettings) if declared.metadata["group"] in KINDS[kind])


def agrees(preset: Preset, values: Mapping[str, Any]) -> bool:
    """Whether settings have all the values of a preset, up to single precision."""
    return bool(preset.settings) and all(
        name in values and _alike(values[name], value) for name, value in preset.settings.items()
    )


def save_preset(own: Path, kind: str, name: str, settings: PrintSettings) -> Path:
    """Save the settings of a kind in the user's folder; a preset of the user's with that name is replaced.

    Raises:
        SettingsError: the name is taken by another preset, or cannot be a file's name.
        OutputError: the file cannot be written.
    """
    name = name.strip()
    if not _NAME.fullmatch(name):
        raise SettingsError(f"{name!r} cannot be a preset's name", "use up to 60 letters, digits and blanks")
    path = own / kind / f"{name}.json"
    taken = {stem.lower(): file for stem, file in preset_files(own).items()}.get(name.lower(), path)
    if taken != path:
        raise SettingsError(f"there is a preset named {taken.stem} already", "choose another name")
    values = settings.as_dict()
    kept = {"label": name, "description": "", "settings": {key: values[key] for key in kind_settings(kind)}}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise OutputError(f"the folder {path.parent} cannot be made", problem.strerror or "") from None
    write_file(path, (json.dumps(kept, indent=2, allow_nan=False) + "\n").encode())
    return path


def remove_preset(own: Path, kind: str, name: str) -> None:
    """Delete one of the user's own presets.

    Raises:
        SettingsError: it is not one of them.
        OutputError: it cannot be deleted.
    """
    path = preset_files(own, (kind,)).get(name)
    if path is None or path.parent != own / kind:
        raise SettingsError(f"{name!r} is not one of your own presets", "only those can be removed")
    try:
        path.unlink()
    except OSError as problem:
        raise OutputError(f"{path} cannot be removed", problem.strerror or "") from None


def read_settings(path: Path) -> dict[str, Any]:
    """The settings in a JSON file, in a preset's file or in the header of a G-code file, not validated yet.

    Raises:
        SettingsError: the file cannot be read, is too large, or holds no settings.
    """
    if path.suffix.lower() in GCODE_SUFFIXES:
        return _header_values(path)
    values = _object(path)
    return read_preset(path).settings if "settings" in values else values


def settings_json(settings: PrintSettings) -> str:
    """All settings as the text of a JSON file that `read_settings` reads."""
    return json.dumps(settings.as_dict(), indent=2, allow_nan=False) + "\n"


def _alike(value: Any, other: Any) -> bool:
    """Whether two values are equal, numbers up to single precision."""
    numbers = [isinstance(each, (int, float)) and not isinstance(each, bool) for each in (value, other)]
    return math.isclose(value, other, rel_tol=1e-6) if all(numbers) else bool(value == other)


def _object(path: Path) -> dict[str, Any]:
    """The JSON object in a file; raises SettingsError."""
    try:
        if path.stat().st_size > MOST_JSON_BYTES:
            raise SettingsError(f"{path} is too large for a file of settings", "give the JSON file of the settings")
        values = read_json(path)
    except OSError as problem:
        raise SettingsError(f"{path} cannot be read", problem.strerror or "") from None
    except ValueError:
        raise SettingsError(f"{path} is not JSON", "delete it, or save it again") from None
    if not isinstance(values, dict):
        raise SettingsError(f"{path} holds no settings", 'write them as {"layer_height": 0.2}')
    return values


def _header_values(path: Path) -> dict[str, Any]:
    """The settings in the comments at the head of a G-code file; other comments are ignored."""
    known = {declared.name for declared in fields(PrintSettings)}
    values: dict[str, Any] = {}
    for line in _start_of(path).decode("ascii", "replace").splitlines():
        if not line.startswith(";"):
            break
        name, equals, value = line.lstrip("; ").partition("=")
        if equals and name.strip() in known:
            values[name.strip()] = read_back(value.strip())
    if not values:
        raise SettingsError(f"{path} has no settings in its header", "only files written by this program have them")
    return values


def _start_of(path: Path) -> bytes:
    """The beginning of a file, as much as a header may take; raises SettingsError."""
    try:
        with path.open("rb") as file:
            return without_mark(file.read(MOST_JSON_BYTES + 1))
    except OSError as problem:
        raise SettingsError(f"{path} cannot be read", problem.strerror or "") from None

"""Settings by name from files: the presets that come with the program, saved settings, headers of G-code files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from .errors import SettingsError
from .settings import PrintSettings

PRESETS = Path(__file__).resolve().parent.parent / "presets"
KINDS = ("printer", "filament", "quality")
# Settings take a few kB; a header is looked for no farther than this.
MOST_BYTES = 1 << 20
GCODE_SUFFIXES = (".gcode", ".gco", ".g")


def preset_files() -> dict[str, Path]:
    """The presets' files by name: printers, then filaments, then qualities."""
    return {path.stem: path for kind in KINDS for path in sorted((PRESETS / kind).glob("*.json"))}


def preset_descriptions() -> dict[str, str]:
    """What each preset is for, in a sentence without a full stop."""
    return {name: str(_object(path).get("description", "")) for name, path in preset_files().items()}


def preset_values(names: Sequence[str]) -> dict[str, Any]:
    """The settings of some presets; where two disagree, the later one counts.

    Raises:
        SettingsError: there is no preset of that name.
    """
    files = preset_files()
    values: dict[str, Any] = {}
    for name in names:
        if name not in files:
            raise SettingsError(f"there is no preset named {name!r}", f"choose among {', '.join(files)}")
        values |= _object(files[name])["settings"]
    return values


def read_settings(path: Path) -> dict[str, Any]:
    """The settings in a JSON file or in the header of a G-code file, not validated yet.

    Raises:
        SettingsError: the file cannot be read, is too large, or holds no settings.
    """
    if path.suffix.lower() in GCODE_SUFFIXES:
        return _header_values(path)
    return _object(path)


def settings_json(settings: PrintSettings) -> str:
    """All settings as the text of a JSON file that `read_settings` reads."""
    return json.dumps(settings.as_dict(), indent=2, allow_nan=False) + "\n"


def _object(path: Path) -> dict[str, Any]:
    text = _start_of(path)
    if len(text) > MOST_BYTES:
        raise SettingsError(f"{path} is too large for a file of settings", "give the JSON file of the settings")
    try:
        values = json.loads(text.decode("utf-8"))
    except (ValueError, RecursionError):
        raise SettingsError(f"{path} is not JSON") from None
    if not isinstance(values, dict):
        raise SettingsError(f"{path} holds no settings", 'write them as {"layer_height": 0.2}')
    return values


def _header_values(path: Path) -> dict[str, Any]:
    """What the comments at the head of a G-code file say about settings; other comments are passed over."""
    known = {declared.name for declared in fields(PrintSettings)}
    values: dict[str, Any] = {}
    for line in _start_of(path).decode("ascii", "replace").splitlines():
        if not line.startswith(";"):
            break
        name, equals, value = line.lstrip("; ").partition("=")
        if equals and name.strip() in known:
            values[name.strip()] = value.strip()
    if not values:
        raise SettingsError(f"{path} has no settings in its header", "only files written by this program have them")
    return values


def _start_of(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(MOST_BYTES + 1)
    except OSError as problem:
        raise SettingsError(f"{path} cannot be read", problem.strerror or "") from None

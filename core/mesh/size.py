"""Whether an object has a size that can be printed, and what to do where its unit is probably wrong."""

from __future__ import annotations

import numpy as np

from ..errors import MeshError
from ..model import FloatArray, TriangleMesh, bounds
from ..settings import PrintSettings

_REACH_TOLERANCE_MM = 1e-3
_LEAST_MM = 1.0  # what is shorter is refused
_USUAL_MM = 5.0  # an object is rarely shorter than this
_UNITS = {
    "inches": 25.4,
    "centimeters": 10.0,
    "meters": 1e3,
    "kilometers": 1e6,
}
"""Units that files are written in by mistake, and mm per unit, the likeliest first."""
_HEIGHT_HINT = "check its unit or choose its height (in Blender: Scale to Height; on the command line: --height-mm)"
_SMALLER = (1e-3, 1e-6)  # factors for what is too large, whose unit nobody could guess


def check_size(vertices: FloatArray, name: str, settings: PrintSettings) -> None:
    """Refuse objects beyond the printer's reach, or so small that their unit must be wrong."""
    low, high = bounds(vertices)
    size = high - low
    sizes = f"{' × '.join(_length(side) for side in size)} mm"
    printer = settings.printer_profile
    least, most = np.array(printer.reach_min), np.array(printer.reach_max)
    room = " × ".join(_length(side) for side in most - least)
    if (size > most - least + _REACH_TOLERANCE_MM).any():
        turned = (size[[1, 0, 2]] <= most - least + _REACH_TOLERANCE_MM).all()
        hint = "turn it by 90° about the vertical axis" if turned else _unit_hint(size, most - least)
        raise MeshError(f"{name} is {sizes}, larger than the {room} mm that can be printed", hint)
    if size.max() < _LEAST_MM:
        raise MeshError(f"{name} is only {sizes}", _unit_hint(size, most - least))
    if size[2] <= settings.first_layer_height / 2:
        raise MeshError(f"{name} is {_length(size[2])} mm high, less than half a layer", "give it some thickness")
    if low[2] < -_REACH_TOLERANCE_MM:
        raise MeshError(f"{name} reaches {_length(-low[2])} mm below the bed", "raise it or turn on center_on_bed")
    if (low < least - _REACH_TOLERANCE_MM).any() or (high > most + _REACH_TOLERANCE_MM).any():
        raise MeshError(f"{name} lies beyond the {room} mm that can be printed", "move it or turn on center_on_bed")


def size_warnings(mesh: TriangleMesh, name: str, settings: PrintSettings) -> list[str]:
    """A warning about an object that is printed although its unit is probably wrong."""
    if (hint := size_hint(mesh, settings)) is None:
        return []
    return [f"{name} is only {_length(float(np.ptp(mesh.bounds, axis=0).max()))} mm long; {hint}"]


def size_hint(mesh: TriangleMesh, settings: PrintSettings) -> str | None:
    """What to do about an object whose unit is probably wrong; None for one of a usual size."""
    size, printer = np.ptp(mesh.bounds, axis=0), settings.printer_profile
    if size.max() >= _USUAL_MM:
        return None
    return _unit_hint(size, np.subtract(printer.reach_max, printer.reach_min))


def _unit_hint(size: FloatArray, room: FloatArray) -> str:
    """What to do about a size (3,) in mm that is probably wrong: the unit in which it would be a usual one."""
    length = float(size.max())
    said = {factor: f"in {unit} it would be {{}} mm long, so scale it by {factor:g}" for unit, factor in _UNITS.items()}
    said |= {factor: f"scaled by {factor:g} it would be {{}} mm long" for factor in _SMALLER}
    fitting = [
        text.format(_length(length * factor))
        for factor, text in said.items()
        if length * factor >= _USUAL_MM and (size * factor <= room).all()
    ]
    return f"check its scale and unit: {fitting[0]}" if fitting else _HEIGHT_HINT


def _length(millimeters: float) -> str:
    """A length in three digits or so, whole millimeters where that is enough."""
    return f"{millimeters:.0f}" if 100 <= millimeters < 1e7 else f"{millimeters:.3g}"

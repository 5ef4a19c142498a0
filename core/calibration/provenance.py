"""What a measurement is valid for: the settings that shape the strands, the plastics and the renderer."""

from __future__ import annotations

from typing import Any

from ..records import dataclass
from ..settings import PrintSettings

_ALWAYS = ("pattern", "max_unsupported", "layer_height", "extrusion_width", "sag")
_WAVES = ("sampling", "wavelength", "wave_depth_max", "wave_depth_min")
_SET_BACK = ("offset_max", "offset_onset")
_OF_PATTERN = {"wave": _WAVES, "wave_offset": _WAVES + _SET_BACK, "offset": _SET_BACK}


@dataclass(frozen=True)
class Provenance:
    """Where readings come from.

    Attributes:
        settings: that the readings are valid for, by name.
        reflectance: of a flat sheet of each plastic, by "Black" and "White", linear.
        source: the program and version that made the picture, or "photograph".
    """

    settings: dict[str, Any]
    reflectance: dict[str, float]
    source: str

    def differences(self, settings: PrintSettings) -> list[str]:
        """The settings that differ from those of the readings, each as "name 0.2 instead of 0.25"."""
        wanted = tone_settings(settings)
        names = sorted(set(wanted) | set(self.settings), key=lambda name: (name not in _ALWAYS, name))
        return [
            f"{name} {wanted.get(name)} instead of {self.settings.get(name)}"
            for name in names
            if wanted.get(name) != self.settings.get(name)
        ]

    def distance(self, settings: PrintSettings) -> tuple[int, float]:
        """How far settings are from those of the readings: how many differ, and the sum of relative differences."""
        wanted = tone_settings(settings)
        shares = []
        for name in sorted(set(wanted) | set(self.settings)):
            ours, theirs = self.settings.get(name), wanted.get(name)
            if ours == theirs:
                continue
            if isinstance(ours, (int, float)) and isinstance(theirs, (int, float)):
                shares.append(abs(ours - theirs) / max(abs(ours), abs(theirs)))
            else:
                shares.append(1.0)
        return len(shares), sum(shares)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"settings": self.settings, "reflectance": self.reflectance, "source": self.source}

    @staticmethod
    def from_dict(values: dict[str, Any]) -> Provenance:
        """The inverse of `as_dict`.

        Raises:
            KeyError: something is missing.
            TypeError: something is of another kind.
            ValueError: something is not a number.
        """
        reflectance = {str(name): float(value) for name, value in values["reflectance"].items()}
        return Provenance(dict(values["settings"]), reflectance, str(values["source"]))


def tone_settings(settings: PrintSettings) -> dict[str, Any]:
    """The settings on which the response of a pattern depends, by name."""
    values = settings.as_dict()
    return {name: values[name] for name in _ALWAYS + _OF_PATTERN[settings.pattern]}

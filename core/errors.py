"""The errors a user can cause; everything else that is raised is a bug and keeps its traceback.

Each says what is wrong and what to do about it; `counted` helps with such sentences, and with those of warnings.
"""

from __future__ import annotations


class PrintError(Exception):
    """A job that cannot go on, with one sentence for the user.

    Attributes:
        message: what is wrong, one sentence without a full stop.
        hint: what to do about it, one sentence without a full stop, or "".
    """

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        return f"{self.message}: {self.hint}" if self.hint else self.message


class SettingsError(PrintError):
    """A setting that is unknown, of the wrong type or out of its limits."""


class MeshError(PrintError):
    """Geometry that cannot be sliced: empty, not finite, open or larger than the bed."""


class TextureError(PrintError):
    """A picture or UV map that is missing or unusable."""


class OutputError(PrintError):
    """A file that cannot be written."""


class CalibrationError(PrintError):
    """Readings or a tone table that are missing, broken or inconsistent."""


def counted(count: int, noun: str) -> str:
    """How many there are of what: "1 layer", "2 layers"; for nouns whose plural ends in s."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"

"""How a setting is declared, with all that panels and validation need, and how values are checked against it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import Field, field, fields, replace
from typing import Any, Self

from ..errors import SettingsError
from ..records import dataclass
from .suggestions import hint_for


def setting(
    default: Any,
    description: str,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str, ...] = (),
    group: str = "print",
) -> Any:
    """Declare a field of `PrintSettings` with all that the panels and the validation need to know.

    `low` and `high` are inclusive; `unit` is one of mm, mm/s, mm/s2, mm3, mm3/s, ms, °C, °, s, %, g/cm3, per kg or ""
    (a plain number).
    """
    metadata = {"description": description, "unit": unit, "low": low, "high": high, "choices": choices, "group": group}
    return field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Declared:
    """A record whose fields are declared by `setting`; their values are checked and converted when it is made.

    Raises:
        SettingsError: a value does not fit its declaration.
    """

    def __post_init__(self) -> None:
        for declared in fields(self):
            object.__setattr__(self, declared.name, checked(declared, getattr(self, declared.name)))

    def as_dict(self) -> dict[str, Any]:
        """All settings by name, JSON-ready."""
        return {declared.name: getattr(self, declared.name) for declared in fields(self)}

    def changed(self, values: Mapping[str, Any]) -> Self:
        """A copy with some settings changed; text such as "0.2" or "true" is understood.

        Raises:
            SettingsError: an unknown name or a value that does not fit.
        """
        known = {declared.name: declared for declared in fields(self)}
        for name in values:
            if name not in known:
                raise SettingsError(f"there is no setting named {' '.join(name.split()):.60}", hint_for(name, known))
        return replace(self, **{name: checked(known[name], value) for name, value in values.items()})


def checked(declared: Field[Any], value: Any) -> Any:
    """The value in the declared type and within its limits.

    Raises:
        SettingsError: it does not fit.
    """
    name, limits, kind = declared.name, declared.metadata, type(declared.default)
    try:
        value = _converted(kind, value)
    except (TypeError, ValueError, OverflowError):
        raise SettingsError(f"{name} = {value!r:.60} is not {_KIND_NAMES[kind]}") from None
    if limits["choices"] and value not in limits["choices"]:
        raise SettingsError(f"{name} = {value!r:.60} is not one of {', '.join(limits['choices'])}")
    if limits["low"] is not None and not limits["low"] <= value <= limits["high"]:
        unit = f" {limits['unit']}" if limits["unit"] else ""
        raise SettingsError(f"{name} = {value:g} is outside {limits['low']:g} to {limits['high']:g}{unit}")
    return value


_NEXT_TO_NOTHING = 1e-9  # smaller values become 0: no setting needs them, and dividing by them would overflow
_KIND_NAMES = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}
_TRUTH = {"true": True, "1": True, "yes": True, "on": True, "false": False, "0": False, "no": False, "off": False}


def _converted(kind: type, value: Any) -> Any:
    """The value as a str, bool, float or int; raises TypeError, ValueError or OverflowError where it is none."""
    if kind is str:
        if not isinstance(value, str):
            raise TypeError
        return value
    if kind is bool:
        if isinstance(value, str) and value.lower() in _TRUTH:
            return _TRUTH[value.lower()]
        if not isinstance(value, bool):
            raise TypeError
        return value
    if isinstance(value, bool):
        raise TypeError
    number = float(value)
    if not math.isfinite(number) or (kind is int and number != int(number)):
        raise ValueError
    return kind(number) if abs(number) > _NEXT_TO_NOTHING else kind(0)

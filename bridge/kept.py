"""JSON texts kept with objects; files from elsewhere, or from another version of the program, may hold anything."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TypeVar

Kept = TypeVar("Kept", dict, list)


def kept_json(text: object, nothing: Kept, needed: Iterable[str] = ()) -> Kept:
    """The value of a JSON text; `nothing` if there is none, of another kind, or without one of the names needed."""
    try:
        value = json.loads(text) if isinstance(text, str) and text else nothing
    except (ValueError, RecursionError):
        return nothing
    if not isinstance(value, type(nothing)) or any(name not in value for name in needed):
        return nothing
    return value

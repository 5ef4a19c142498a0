"""The finished prints of this session, so that an export does not compute again what has not changed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from ..core.job.stage_cache import StageCache
from ..core.model import SurfaceModel
from ..core.records import dataclass
from ..core.settings import PrintSettings

if TYPE_CHECKING:
    from ..core.pipeline import DualColorPrint

CAPACITY = 2
"""A print of a million moves takes some 300 MB."""


@dataclass(frozen=True)
class _Kept:
    digest: str
    result: DualColorPrint


_kept: dict[int, _Kept] = {}
_stages: dict[int, StageCache] = {}
"""Results of stages, of the object that was worked on last only."""


def keep(obj: bpy.types.Object, digest: str, result: DualColorPrint) -> None:
    """Remember an object's print and what it was made from; the oldest beyond the capacity is forgotten."""
    _kept.pop(obj.session_uid, None)
    _kept[obj.session_uid] = _Kept(digest, result)
    while len(_kept) > CAPACITY:
        del _kept[next(iter(_kept))]


def kept(obj: bpy.types.Object, digest: str) -> DualColorPrint | None:
    """The object's print, if it was made from exactly this."""
    found = _kept.get(obj.session_uid)
    return found.result if found and found.digest == digest else None


def stages_of(obj: bpy.types.Object) -> StageCache:
    """The stages of the object's last job; those of another object are forgotten: they take as much as its print."""
    if obj.session_uid not in _stages:
        _stages.clear()
        _stages[obj.session_uid] = StageCache()
    return _stages[obj.session_uid]


def forget_all() -> None:
    """Free the memory; prints needed later are computed again."""
    _kept.clear()
    _stages.clear()


def digest_of(model: SurfaceModel, settings: PrintSettings) -> str:
    """A fingerprint of all that a print is made from."""
    found = hashlib.blake2b(
        repr((model.name, model.object_names, [volume.mark for volume in model.volumes], settings)).encode(),
        digest_size=16,
    )
    for name, array in _arrays(model):
        found.update(f"{name}{array.dtype}{array.shape}".encode())
        found.update(np.ascontiguousarray(array).data)
    return found.hexdigest()


def _arrays(part: Any, name: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """All arrays within dataclasses and tuples with the names of their fields; none of them is copied."""
    if isinstance(part, np.ndarray):
        yield name, part
    elif isinstance(part, tuple):
        for each in part:
            yield from _arrays(each, name)
    elif is_dataclass(part):
        for declared in fields(part):
            yield from _arrays(getattr(part, declared.name), declared.name)


@bpy.app.handlers.persistent
def _before_load(*_: Any) -> None:
    forget_all()


def register() -> None:
    """Forget the prints of a file when another is opened."""
    bpy.app.handlers.load_pre.append(_before_load)


def unregister() -> None:
    """Forget everything."""
    bpy.app.handlers.load_pre.remove(_before_load)
    forget_all()

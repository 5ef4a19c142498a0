"""Results of stages, kept from one run of the job to the next, used again where what a stage reads has not changed.

What a stage reads is not declared but watched: its settings are handed over as a copy that notes which of them are
asked for. A stage that is given the same arrays and the same values of those settings goes the same way and gives the
same result, so nothing can be forgotten when a stage learns to read another setting. Of a property, such as `is_solid`,
its own value is noted and not the settings that it is made from, so a stage that asks no more is not in their way.

Where a stroke of the brush changes a few layers only, `compare_layers` finds out which, from the pictures or the walls;
the stages after it, whose inputs differ on no other layers then, are run on these alone by `run_layers`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray

from ..model import BoolArray
from ..records import dataclass
from ..settings import PrintSettings
from .layers import without_gaps

Result = TypeVar("Result")
Column = NDArray[Any]
Columns = tuple[Column, ...]
_PROPERTIES = [name for name in dir(PrintSettings) if isinstance(getattr(PrintSettings, name), property)]
_READABLE = frozenset([*(declared.name for declared in fields(PrintSettings)), *_PROPERTIES])
_NOTES, _ORIGINAL = "_notes", "_original"
MOST_BYTES = 1 << 30
_BYTES_A_GEOMETRY = 200
_BLOCK_WORDS = 1 << 15
_MOST_CHANGED = 0.8  # of all layers; more are not worth it to keep the others


@dataclass(frozen=True)
class _Held:
    """A result, what it was made from, and the settings that were read meanwhile."""

    arguments: tuple[Any, ...]
    read: dict[str, Any]
    result: Any


class StageCache:
    """The latest result of each stage.

    Args:
        most_bytes: that the results may take; with more of them all are forgotten at the end of the run.
    """

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._held: dict[str, _Held] = {}
        self._changed: BoolArray | None = None  # (L,) layers that differ from those of the last run; None for all
        # What this run and the last one compared or ran by layers: the results of one of them only do not fit together.
        self._layered: set[str] = set()
        self._layered_before: set[str] = set()
        self._has_ended = False

    def run(self, stage: str, function: Callable[..., Result], *arguments: Any) -> Result:
        """The function's result, kept under the stage's name; the former one if nothing that was read has changed."""
        held, settings, others = self._asked(stage, arguments)
        if held and _is_read_alike(held, settings) and _same(held.arguments, others):
            kept: Result = held.result
            return kept
        read: dict[str, Any] = {}
        watched = _watched(settings, read) if settings else None
        result = function(*(watched if given is settings and settings else given for given in arguments))
        self._held[stage] = _Held(others, read, result)
        return result

    def begin(self) -> None:
        """A run begins: nothing is known of it, nor of one that did not end."""
        self._layered_before, self._layered = self._layered if self._has_ended else set(), set()
        self._has_ended, self._changed = False, None

    def compare_layers(
        self, name: str, same: tuple[Any, ...], given: Result, differing: Callable[[Result], BoolArray | None]
    ) -> None:
        """Find out on which layers the stages run by `run_layers` after this are given something else than last time.

        Args:
            name: that what is given is kept under.
            same: what all layers depend on; if it is not what it was, all differ.
            given: what is to be compared.
            differing: from what was given last time to the (L,) layers that differ, or None for all.
        """
        held, self._changed = self._of_last_run(name), None
        self._held[name] = _Held(same, {}, given)
        if held and _same(held.arguments, same):
            found = differing(held.result)
            if found is not None:
                found = without_gaps(found)
                self._changed = found if np.count_nonzero(found) <= _MOST_CHANGED * len(found) else None

    def run_layers(
        self,
        stage: str,
        whole: Callable[..., Result],
        anew: Callable[..., Result | None],
        given: tuple[Any, ...],
        *arguments: Any,
    ) -> Result:
        """As `run`, but where that is possible only on the layers that have changed.

        Args:
            stage: the name that the result is kept under.
            whole: the function for all layers, of what is `given` and the other arguments.
            anew: the same for some layers: before these arguments it takes the former result and the (L,) layers that
                have changed, and it returns the new result of all layers, or None where these may change others too;
                see `changed_layers.py`.
            given: what `compare_layers` has compared, or what other stages have made of that by `run_layers`.
            arguments: the others; where these are not what they were, all layers have changed.
        """
        _, settings, others = self._asked(stage, arguments)
        held = self._of_last_run(stage)
        if self._changed is not None and held and _is_read_alike(held, settings) and _same(held.arguments[1:], others):
            if not self._changed.any():
                kept: Result = held.result
                return kept
            read = dict(held.read)
            more = (_watched(settings, read) if one is settings and settings else one for one in arguments)
            made = anew(held.result, self._changed, *given, *more)
            if made is not None:
                self._held[stage] = _Held((given, *others), read, made)
                return made
        result = self.run(stage, lambda given, *more: whole(*given, *more), given, *arguments)
        if self._held.get(stage) is not held:  # what comes of it is new on all layers
            self._changed = None
        return result

    def _of_last_run(self, name: str) -> _Held | None:
        """What is held of something that is compared or made layer by layer, if the last run did so too."""
        self._layered.add(name)
        return self._held.get(name) if name in self._layered_before else None

    def _asked(
        self, stage: str, arguments: tuple[Any, ...]
    ) -> tuple[_Held | None, PrintSettings | None, tuple[Any, ...]]:
        """What is held of a stage, and its arguments: the settings, and the others."""
        settings = next((given for given in arguments if isinstance(given, PrintSettings)), None)
        return self._held.get(stage), settings, tuple(given for given in arguments if given is not settings)

    def trim(self) -> None:
        """The run is over: forget all if it takes too much memory."""
        self._has_ended = True
        if self.size > self._most_bytes:
            self._held.clear()

    @property
    def size(self) -> int:
        """About how many bytes the results and their inputs take."""
        seen: set[int] = set()
        return sum(_bytes(held.arguments, seen) + _bytes(held.result, seen) for held in self._held.values())


class NoCache(StageCache):
    """Keeps nothing, for a job that is run once."""

    def run(self, stage: str, function: Callable[..., Result], *arguments: Any) -> Result:
        """The function's result."""
        return function(*arguments)

    def compare_layers(
        self, name: str, same: tuple[Any, ...], given: Result, differing: Callable[[Result], BoolArray | None]
    ) -> None:
        """There is nothing to compare with: all layers count as changed."""


class _Watched(PrintSettings):
    """Settings that note under `_NOTES` which of them, and which of their properties, are read."""

    def __getattribute__(self, name: str) -> Any:
        held = object.__getattribute__(self, "__dict__")
        if name not in _READABLE or _ORIGINAL not in held:  # a changed copy has none; making it has read all others
            return object.__getattribute__(self, name)
        value = getattr(held[_ORIGINAL], name)
        held[_NOTES][name] = value
        return value


def _watched(settings: PrintSettings, notes: dict[str, Any]) -> PrintSettings:
    """A copy of the settings that puts into `notes` what is read of it."""
    copy = object.__new__(_Watched)
    vars(copy).update(vars(settings))
    vars(copy).update({_NOTES: notes, _ORIGINAL: settings})
    return copy


def _is_read_alike(held: _Held, settings: PrintSettings | None) -> bool:
    """Whether the settings that a held result has read are what they were."""
    return all(getattr(settings, name, None) == value for name, value in held.read.items())


def _same(first: Any, second: Any) -> bool:
    """Whether two arguments are one and the same, or hold equal arrays."""
    if first is second:
        return True
    if type(first) is not type(second):
        return False
    if isinstance(first, np.ndarray):
        return first.shape == second.shape and first.dtype == second.dtype and _equal_arrays(first, second)
    if isinstance(first, tuple):
        return len(first) == len(second) and all(_same(a, b) for a, b in zip(first, second, strict=True))
    if is_dataclass(first):
        return all(_same(getattr(first, each.name), getattr(second, each.name)) for each in fields(first))
    if isinstance(first, shapely.Geometry):
        return bool(shapely.equals_identical(first, second))
    return isinstance(first, (str, int, float, bool)) and bool(first == second)


def _equal_arrays(first: Column, second: Column) -> bool:
    """Whether arrays of one shape and type hold the same, bit by bit: what is not a number is then like itself too."""
    if first.dtype == object:
        return bool(shapely.equals_identical(first, second).all())
    if first.flags.f_contiguous and second.flags.f_contiguous:
        first, second = first.T, second.T
    one, other = (np.ascontiguousarray(column).reshape(-1).view(np.uint8) for column in (first, second))
    whole = len(one) // 8 * 8
    words = one[:whole].view(np.uint64), other[:whole].view(np.uint64)
    # Where they differ is mostly seen before all is compared.
    blocks = (slice(begin, begin + _BLOCK_WORDS) for begin in range(0, whole // 8, _BLOCK_WORDS))
    return np.array_equal(one[whole:], other[whole:]) and all(
        np.array_equal(words[0][block], words[1][block]) for block in blocks
    )


def _bytes(held: Any, seen: set[int]) -> int:
    """Bytes of all arrays and geometries within, each counted once."""
    if id(held) in seen:
        return 0
    seen.add(id(held))
    if isinstance(held, np.ndarray):
        if held.dtype == object:
            return int(shapely.get_num_coordinates(held).sum()) * 16 + held.size * _BYTES_A_GEOMETRY
        return int(held.nbytes)
    if isinstance(held, (tuple, list)):
        return sum(_bytes(each, seen) for each in held)
    if is_dataclass(held) or hasattr(held, "__dict__"):
        return sum(_bytes(each, seen) for each in vars(held).values())
    return 0

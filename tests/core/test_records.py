"""Dataclasses with shared methods are like those of the standard library."""

import copy
import dataclasses
import pickle
from functools import cached_property
from typing import Any

import numpy as np
import pytest
from dualcolor.core.paths import Paths
from dualcolor.core.records import dataclass
from dualcolor.core.settings import PrintSettings


@dataclass(frozen=True)
class Line:
    """Two places and what is told of them."""

    begin: float
    end: float = 2.0
    notes: list[str] = dataclasses.field(default_factory=list)
    secret: int = dataclasses.field(default=0, repr=False)

    def __post_init__(self) -> None:
        if self.end < self.begin:
            raise ValueError("backwards")

    @cached_property
    def length(self) -> float:
        return self.end - self.begin


@dataclasses.dataclass(frozen=True)
class Standard:
    """The same by the standard library."""

    begin: float
    end: float = 2.0
    notes: list[str] = dataclasses.field(default_factory=list)
    secret: int = dataclasses.field(default=0, repr=False)


@pytest.mark.parametrize(
    ("values", "named"),
    [((1.0,), {}), ((1.0, 3.0), {}), ((), {"begin": 0.5}), ((0.0, 4.0, ["a"]), {"secret": 7}), ((1.0,), {"notes": []})],
)
def test_it_holds_what_the_standard_one_holds(values: tuple[Any, ...], named: dict[str, Any]):
    line, standard = Line(*values, **named), Standard(*values, **named)
    assert dataclasses.asdict(line) == dataclasses.asdict(standard)
    assert repr(line) == repr(standard).replace("Standard", "Line")
    assert [field.name for field in dataclasses.fields(line)] == [field.name for field in dataclasses.fields(standard)]
    assert dataclasses.is_dataclass(line) and line.length == line.end - line.begin
    assert Line.__match_args__ == Standard.__match_args__


@pytest.mark.parametrize(
    ("values", "named"),
    [((), {}), ((1.0, 2.0, [], 0, 5), {}), ((1.0,), {"begin": 2.0}), ((1.0,), {"stop": 2.0}), ((), {"stop": 1})],
)
def test_wrong_arguments_are_told_of(values: tuple[Any, ...], named: dict[str, Any]):
    for kind in (Line, Standard):
        with pytest.raises(TypeError):
            kind(*values, **named)


def test_nothing_can_be_changed_and_a_changed_copy_is_checked():
    line = Line(1.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        line.begin = 0.0  # type: ignore[misc]
    with pytest.raises(dataclasses.FrozenInstanceError):
        del line.end
    assert line.length == 1.0
    assert dataclasses.replace(line, begin=0.0) == Line(0.0) and dataclasses.replace(line, begin=0.0).length == 2.0
    with pytest.raises(ValueError, match="backwards"):
        dataclasses.replace(line, end=0.0)
    assert Line(1.0).notes is not Line(1.0).notes


def test_equality_hash_and_copies():
    line = Line(1.0, notes=["a"])
    assert line == Line(1.0, notes=["a"]) != Line(1.0) and line != Standard(1.0, notes=["a"])
    assert line.length and line == Line(1.0, notes=["a"])  # whatever has been worked out since
    for copied in (copy.copy(line), copy.deepcopy(line), pickle.loads(pickle.dumps(line))):
        assert copied == line
    assert len({PrintSettings(), PrintSettings(), PrintSettings(skirts=3)}) == 2
    with pytest.raises(TypeError):
        hash(line)  # a list has none


def test_the_programs_own():
    paths = Paths.empty()
    assert paths.swapped is None and dataclasses.replace(paths, swapped=np.zeros(0, dtype=bool)).swapped is not None
    with pytest.raises(dataclasses.FrozenInstanceError):
        paths.layer = np.zeros(1)  # type: ignore[misc]
    with pytest.raises(TypeError, match="Paths takes points, start"):
        Paths(paths.points)
    with pytest.raises(TypeError, match="frozen"):
        dataclass(frozen=False)

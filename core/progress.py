"""Long jobs are generators that yield how far they are and return what they made: here they are run and translated."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import TypeVar

Progress = tuple[float, str]
"""Share done, and what comes next."""

_Result = TypeVar("_Result")
_Told = TypeVar("_Told")
_Said = TypeVar("_Said")


def drained(job: Generator[_Told, None, _Result], told: Callable[[_Told], object] = lambda _: None) -> _Result:
    """Run a job to its end; `told` is called with all that it yields. Returns what the job returns."""
    while True:
        try:
            step = next(job)
        except StopIteration as finished:
            result: _Result = finished.value
            return result
        told(step)


def retold(job: Generator[_Told, None, _Result], said: Callable[[_Told], _Said]) -> Generator[_Said, None, _Result]:
    """The same job, yielding what `said` makes of each thing that it yields; closing it closes the job."""
    try:
        while True:
            try:
                step = next(job)
            except StopIteration as finished:
                result: _Result = finished.value
                return result
            yield said(step)
    finally:
        job.close()

"""Long jobs are generators that yield their progress and return their result; here they are run and translated."""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any, TypeVar

Progress = tuple[float, str]
"""Share done, and the name of what comes next."""

_LOOK_S = 0.05  # as often as a window should answer

_Result = TypeVar("_Result")
_Step = TypeVar("_Step")
_Translated = TypeVar("_Translated")


def drained(job: Generator[_Step, None, _Result], on_step: Callable[[_Step], object] = lambda _: None) -> _Result:
    """Run a job to its end; `on_step` is called with everything that it yields. Returns what the job returns."""
    while True:
        try:
            step = next(job)
        except StopIteration as finished:
            result: _Result = finished.value
            return result
        on_step(step)


def translated(
    job: Generator[_Step, None, _Result], translate: Callable[[_Step], _Translated]
) -> Generator[_Translated, None, _Result]:
    """The same job, with each step translated; closing it closes the job."""
    try:
        while True:
            try:
                step = next(job)
            except StopIteration as finished:
                result: _Result = finished.value
                return result
            yield translate(step)
    finally:
        job.close()


def awaited(work: Callable[[], _Result], step: _Step) -> Generator[_Step, None, _Result]:
    """Do work in another thread and return its result; yields the same step again and again meanwhile.

    Closing the job abandons the work, which must therefore change nothing.
    """
    result = in_own_thread(work)
    while wait([result], _LOOK_S).not_done:
        yield step
    return result.result()


def in_own_thread(work: Callable[..., _Result], *arguments: Any) -> Future[_Result]:
    """Begin work in a thread that ends with it; whoever no longer needs its result need not wait for it."""
    thread = ThreadPoolExecutor(1)
    result = thread.submit(work, *arguments)
    thread.shutdown(wait=False)
    return result

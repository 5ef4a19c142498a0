"""How the stages of a job are run: their time is noted, their results are kept, and work goes on beside them."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import Any, TypeVar

import numpy as np

from ..progress import Progress
from .changed_layers import LayerRows
from .clock import StageClock, peak_rss_mb
from .stage_cache import NoCache, StageCache

Result = TypeVar("Result")

_KEPT_BYTES = 1 << 23
_TURN_S = 2e-4  # about ten calls of numpy


class Stages:
    """What runs the stages of one job; as a context it waits at its end for the work beside them.

    Args:
        cache: keeps results for the next job; None for a job that is run once.

    Attributes:
        run: calls a function unless the cache holds its result, see `StageCache.run`.
        compare_layers: see `StageCache.compare_layers`.
        run_layers: makes only those layers anew that differ, see `StageCache.run_layers`.
    """

    def __init__(self, cache: StageCache | None) -> None:
        # Once a block as large was freed, glibc keeps what is freed later: getting new memory takes a tenth of a job.
        np.empty(_KEPT_BYTES, dtype=np.uint8)
        self._cache = cache or NoCache()
        self._cache.begin()
        self._clock = StageClock()
        self._beside = ThreadPoolExecutor(1)
        self.run = self._cache.run
        self.compare_layers, self.run_layers = self._cache.compare_layers, self._cache.run_layers

    def __enter__(self) -> Stages:
        """The stages themselves; until they end, Python does not look for cycles of objects: a job leaves none.

        Threads pass the interpreter on sooner, too: short steps of one would keep the other waiting.
        """
        self._collects, self._turn_s = gc.isenabled(), sys.getswitchinterval()
        gc.disable()
        sys.setswitchinterval(_TURN_S)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wait for the work beside the stages."""
        if kind is None:
            self._cache.trim()
        self._beside.shutdown()
        sys.setswitchinterval(self._turn_s)
        if self._collects:
            gc.enable()

    def run_rows(
        self, rows: LayerRows, stage: str, function: Callable[..., Result], given: tuple[Any, ...], *arguments: Any
    ) -> Result:
        """As `run_layers`, of a function that makes every contour or every island by itself."""
        return self.run_layers(stage, function, rows.only(function), given, *arguments)

    def begin(self, done: float, name: str) -> Progress:
        """The next stage begins; what a job's generator has to yield then."""
        self._clock.begin(name)
        return done, name

    def aside(self, name: str, work: Callable[..., Any], *inputs: Any, kept: bool = True) -> Future[Any]:
        """Run work in the second thread, one piece after the other; its arguments may be results of earlier pieces."""
        run = self.run if kept else NoCache().run
        return self._beside.submit(self._clock.timed, name, lambda: run(name, work, *map(_known, inputs)))

    def ended(self) -> dict[str, Any]:
        """The part of the report on time and memory, after the last stage."""
        self._clock.stop()
        seconds = self._clock.seconds
        times = {"stages_s": seconds, "total_s": sum(seconds.values())}
        return times | {"beside_s": self._clock.beside, "peak_rss_mb": peak_rss_mb()}


def _known(value: Any) -> Any:
    """The result of earlier work in the same thread; any other value as it is."""
    return value.result() if isinstance(value, Future) else value

"""Time of the stages of a job, and its peak memory."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, TypeVar

Result = TypeVar("Result")


@dataclass
class StageClock:
    """Seconds by stage; a stage runs from `begin` to the next `begin` or to `stop`.

    Attributes:
        seconds: of each stage, which add up to the job.
        beside: seconds of work done in another thread beside the stages.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    beside: dict[str, float] = field(default_factory=dict)
    _stage: str = ""
    _since: float = 0.0

    def begin(self, stage: str) -> None:
        """End the running stage and start another one; the same name may come again and adds up."""
        self.stop()
        self._stage, self._since = stage, perf_counter()

    def stop(self) -> None:
        """End the running stage."""
        if self._stage:
            spent = perf_counter() - self._since
            self.seconds[self._stage] = self.seconds.get(self._stage, 0.0) + spent
        self._stage = ""

    def timed(self, work: str, function: Callable[..., Result], *arguments: Any) -> Result:
        """Call a function beside the stages and note its seconds."""
        since = perf_counter()
        result = function(*arguments)
        self.beside[work] = perf_counter() - since
        return result


def peak_rss_mb() -> float:
    """Peak memory of the process so far, MB; 0 where the system does not report it (Windows)."""
    if sys.platform == "win32":
        return 0.0
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024 * 1024 if sys.platform == "darwin" else 1024)

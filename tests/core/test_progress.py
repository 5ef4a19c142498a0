"""Jobs that yield their progress."""

from itertools import islice
from threading import Event

import pytest
from dualcolor.core.progress import awaited, drained


def test_work_elsewhere_lets_its_job_go_on_until_it_is_done():
    allowed = Event()
    job = awaited(lambda: allowed.wait(30) and "result", (0.9, "strands"))
    assert list(islice(job, 3)) == [(0.9, "strands")] * 3
    allowed.set()
    assert drained(job) == "result"


def test_work_elsewhere_fails_where_it_is_awaited():
    with pytest.raises(ZeroDivisionError):
        drained(awaited(lambda: 1 // 0, None))


def test_work_that_is_abandoned_keeps_nobody_waiting():
    allowed, ended = Event(), Event()
    job = awaited(lambda: allowed.wait(30) and ended.set(), None)
    next(job)
    job.close()
    assert not ended.is_set()
    allowed.set()
    assert ended.wait(30)

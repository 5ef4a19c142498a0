"""Rows are handed to threads in runs: all of them, in order, each run about as much work."""

import numpy as np
from dualcolor.core import parallel


def test_runs_hold_all_rows_in_order_and_as_much_work_each(monkeypatch):
    monkeypatch.setattr(parallel, "_THREADS", 4)
    size = np.random.default_rng(1).integers(1, 9, 500)
    runs = parallel.evenly_in_threads(lambda own: np.arange(len(size))[own], size)
    assert np.array_equal(np.concatenate(runs), np.arange(len(size)))
    work = [size[run].sum() for run in runs]
    assert len(work) == 4 and max(work) - min(work) < 2 * size.max()


def test_few_rows_are_one_run_and_no_rows_none():
    assert parallel.evenly_in_threads(lambda own: own, np.ones(3, dtype=np.int64)) == [slice(0, 3)]
    assert parallel.evenly_in_threads(lambda own: own, np.zeros(0, dtype=np.int64)) == []

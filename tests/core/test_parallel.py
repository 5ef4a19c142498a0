"""Work in threads: rows in runs, in order and as much work each; who asks for the results takes part."""

import threading

import numpy as np
import pytest
from dualcolor.core import parallel


def test_runs_hold_all_rows_in_order_and_as_much_work_each(monkeypatch):
    monkeypatch.setattr(parallel, "_THREADS", 4)
    size = np.random.default_rng(1).integers(1, 9, 500)
    runs = parallel.even_runs(size)
    assert np.array_equal(np.concatenate([np.arange(len(size))[run] for run in runs]), np.arange(len(size)))
    work = [size[run].sum() for run in runs]
    assert len(work) == 8 and max(work) - min(work) < 2 * size.max()


def test_few_rows_are_one_run_and_no_rows_none():
    assert parallel.even_runs(np.ones(3, dtype=np.int64)) == [slice(0, 3)]
    assert parallel.even_runs(np.zeros(0, dtype=np.int64)) == []


@pytest.mark.parametrize("threads", [1, 2, 8])
def test_whoever_asks_for_results_takes_part_and_they_are_in_order(threads, monkeypatch):
    monkeypatch.setattr(parallel, "_THREADS", threads)
    last_is_done, workers = threading.Event(), []

    def squared(number):
        workers.append(threading.get_ident())
        if number == 0:
            last_is_done.wait(10)  # so that nobody else gets to the last one
        elif number == 9:
            last_is_done.set()
        return number**2

    with parallel.begun(squared, range(10)) as results:
        assert results() == [number**2 for number in range(10)]
    assert len(workers) == 10
    assert threads > 2 or threading.get_ident() in workers


def test_an_error_in_any_part_is_raised():
    for wrong in range(4):
        with pytest.raises(ZeroDivisionError):
            parallel.in_threads(lambda number, wrong=wrong: 1 / (number - wrong), range(4))

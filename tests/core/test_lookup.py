"""The table that finds numbers among increasing ones finds what bisection does."""

import numpy as np
import pytest
from dualcolor.core.lookup import Lookup
from hypothesis import given
from hypothesis import strategies as st

NUMBERS = st.floats(-1e6, 1e6, allow_nan=False)


def found(increasing, value):
    return np.searchsorted(increasing, value, side="right") - 1


@given(st.lists(NUMBERS, min_size=1, max_size=60), st.lists(NUMBERS, max_size=60))
def test_the_last_number_that_is_not_greater_is_found(numbers, values):
    increasing = np.sort(numbers)
    value = np.concatenate([values, increasing, np.nextafter(increasing, -np.inf), np.nextafter(increasing, np.inf)])
    np.testing.assert_array_equal(Lookup(increasing).before(value), found(increasing, value))


@pytest.mark.parametrize("power", [1, 3, 12])
def test_numbers_that_crowd_in_few_cells_are_found(power):
    rng = np.random.default_rng(3)
    increasing = np.sort(rng.random(3000) ** power) * 1e5
    value = np.concatenate([rng.random(3000) * 1.2e5 - 1e4, increasing])
    np.testing.assert_array_equal(Lookup(increasing).before(value), found(increasing, value))


def test_nothing_comes_before_anything_among_no_numbers():
    assert Lookup(np.zeros(0)).before(np.array([-1.0, 0.0, 2.0])).tolist() == [-1, -1, -1]
    assert Lookup(np.array([2.0])).before(np.array([1.0, 2.0, 3.0])).tolist() == [-1, 0, 0]
    assert not len(Lookup(np.array([2.0])).before(np.zeros(0)))

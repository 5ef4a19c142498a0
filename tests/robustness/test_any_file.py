"""Whatever is done to a file: it is read, or refused in one sentence. Longer and harder: `make fuzz`."""

import warnings

import pytest
from dualcolor.core.errors import PrintError
from dualcolor.tests.fuzz.targets import targets
from dualcolor.tests.robustness.strategies import damaged, examples
from hypothesis import given
from hypothesis import strategies as st

NAMES = ("gcode", "x3g", "preset", "settings", "header", "printer", "table", "sweep", "photograph", "companions")


def test_all_readers_are_tried():
    assert set(targets()) == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
@given(data=st.data())
@examples(40)
def test_any_damage_is_read_or_refused(name, data):
    target = targets()[name]
    content = data.draw(damaged(target.seeds, target.words))
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            target.read(content)
        except PrintError as problem:
            assert problem.message and "\n" not in str(problem) and len(str(problem)) < 600

"""What runs the stages changes settings of the interpreter only as long as it runs them."""

import gc
import sys
from contextlib import suppress

import pytest
from dualcolor.core.job.stages import Stages


@pytest.mark.parametrize("collects", [True, False])
@pytest.mark.parametrize("fails", [True, False])
def test_the_interpreter_is_left_as_it_was(collects, fails):
    turn_s, collected = sys.getswitchinterval(), gc.isenabled()
    try:
        sys.setswitchinterval(0.003)
        (gc.enable if collects else gc.disable)()
        with suppress(ZeroDivisionError), Stages(None):
            assert sys.getswitchinterval() < 0.001 and not gc.isenabled()
            assert not fails or 1 / 0
        assert sys.getswitchinterval() == pytest.approx(0.003) and gc.isenabled() == collects
    finally:
        sys.setswitchinterval(turn_s)
        (gc.enable if collected else gc.disable)()

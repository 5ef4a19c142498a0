"""A rendered photograph of the tile's predicted print, by a tilted camera in light that falls off, gives the table."""

import numpy as np
import pytest

pytest.importorskip("bpy")

from dualcolor.benchmarks.calibration_photo import errors, photograph
from dualcolor.bridge.quiet import quiet_stdout
from dualcolor.core.calibration.step_wedge import wedge_settings
from dualcolor.core.settings import PrintSettings
from PIL import Image


def test_a_photograph_gives_the_instruments_table_back(scene, tmp_path):
    path, settings = tmp_path / "photograph.png", wedge_settings(PrintSettings())
    with quiet_stdout():
        photograph(path, settings, "soft", tilt_deg=10.0, width=600, samples=6)
    with Image.open(path) as image:
        assert image.mode == "RGB" and image.size == (600, 372)
    error, fall_off, notes = errors(path, settings)
    assert fall_off < 0.8
    assert np.abs(error).max() < 0.03
    assert not notes

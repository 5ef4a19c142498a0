"""From the tones of a picture to those that a wall can show."""

import numpy as np
import pytest
from dualcolor.core.calibration.calibrate import table_for
from dualcolor.core.calibration.gamut_mapping import WHOLE_RANGE, image_range, printable_tones, targets
from dualcolor.core.calibration.table import isotonic
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.core.calibration.tone_tables import TONE, calibrated, inverse, table
from hypothesis import given
from hypothesis import strategies as st


def test_compress_spans_the_printable_range_and_clip_takes_tones_as_reflectances():
    made = table(0.1 + 0.4 * TONE, 0.3 + 0.3 * TONE)
    asked = np.array([0.0, 0.5, 1.0])
    wanted = np.array([[0.1, 0.3, 0.5], [0.125, 0.325, 0.525]])
    assert targets(made, "compress", asked, WHOLE_RANGE) == pytest.approx(wanted)
    assert targets(made, "clip", asked, (0.4, 0.5)) == pytest.approx(np.array([[0.0, 0.5, 1.0]] * 2))
    clip = inverse(made, "clip")
    at = np.linspace(0, 1, 513)
    assert np.interp([0.05, 0.3, 0.9], at, clip[0]) == pytest.approx([0, 0.5, 1], abs=0.01)
    # A slope that cannot reach the upright wall's black prints its own darkest tone.
    assert inverse(made, "compress")[1, 0] == 0


def test_compress_goes_from_the_pictures_own_range():
    made = table(0.1 + 0.4 * TONE)
    # More than the wall can show: its ends are the wall's.
    wide = targets(made, "compress", np.array([0.0, 0.25, 0.5, 0.75, 1.0]), (0.25, 0.75))
    assert wide == pytest.approx(np.array([[0.1, 0.1, 0.3, 0.5, 0.5]]))
    # Less than it can show: nothing is stretched, and it lies as high in the wall's range as in the whole one.
    narrow = targets(made, "compress", np.array([0.6, 0.7, 0.8]), (0.6, 0.8))
    assert np.diff(narrow) == pytest.approx(0.1)
    assert narrow[0, 0] == pytest.approx(0.1 + 0.6 / 0.8 * (0.4 - 0.2))
    # One even tone is where it would be in a picture of all tones, and there is no jump on the way there.
    for tone in (0.0, 0.3, 1.0):
        even = targets(made, "compress", np.array([tone]), (tone, tone))
        assert even == pytest.approx(targets(made, "compress", np.array([tone]), WHOLE_RANGE))
        near = targets(made, "compress", np.array([tone]), (max(tone - 1e-6, 0), min(tone + 1e-6, 1)))
        assert near == pytest.approx(even, abs=1e-5)


@given(st.floats(0, 1), st.floats(0, 1), st.floats(0, 0.9), st.floats(0, 1))
def test_compressed_tones_stay_printable_in_order_and_are_never_stretched(first, second, low, room):
    shown = min(first, second), max(first, second)
    made = table(low + min(room, 1 - low) * TONE)
    found = targets(made, "compress", np.linspace(0, 1, 101), shown)[0]
    assert found.min() >= low - 1e-9 and found.max() <= made.reflectance[0, -1] + 1e-9
    assert (np.diff(found) >= -1e-9).all() and np.diff(found).max() <= 0.01 + 1e-6


def test_range_of_a_picture_leaves_specks_out_but_not_fine_print():
    dark, light = 76 / 256, 231 / 256
    tone = np.full(100_000, 0.5)  # places of 0.05 mm²
    tone[:15], tone[20:40], tone[50:80] = 0.0, 1.0, dark
    assert image_range(tone, 0.05) == (dark, 0.5)
    tone[80:100] = light
    assert image_range(tone, 0.05) == (dark, light)
    # The same surface seen as fewer places, some of them larger.
    area, places = np.array([2.0, 3.0, 0.5, 4000.0]), np.array([light, dark, 0.0, 0.5])
    assert image_range(places, area) == (dark, light)
    few = np.linspace(0.2, 0.7, 6)
    assert image_range(few, 0.05) == image_range(few, np.full(6, 0.05)) == (51 / 256, 180 / 256)
    assert image_range(np.zeros(0), 0.05) == WHOLE_RANGE


def test_a_stroke_within_the_range_of_a_picture_leaves_it_as_it_is():
    tone = np.random.default_rng(2).uniform(0.101, 0.901, 50_000)
    known = image_range(tone, 0.05)
    tone[:3000] = 0.4
    assert image_range(tone, 0.05) == known and known[0] <= tone.min() + 0.002 and known[1] >= tone.max() - 0.002


def test_the_tables_for_a_preview_are_what_the_job_prints():
    """`printed` is what the job looks up, `seen` the table's own response to it, on and between its slopes."""
    rng = np.random.default_rng(5)
    for way in ("slope_aware", "upright", "none"):
        chosen = PrintSettings(calibration=way)
        tone, slant = rng.uniform(0.2, 0.9, 4000), rng.uniform(-30, 90, 4000)
        printed, _ = calibrated(tone, slant, chosen)
        shown = image_range(tone, 0.05)
        made = table_for(chosen)
        some = rng.integers(0, 4000, 20)
        for tones, slants, wanted in zip(tone[some], slant[some], printed[some], strict=True):
            found = printable_tones(np.array([tones]), np.array([slants]), made, shown, chosen)
            assert found.printed[0, 0] == pytest.approx(wanted, abs=0.004)
            assert found.seen.shape == found.target.shape == (1, 1)
    at_30 = printable_tones(np.linspace(0, 1, 9), np.array([0.0, 30.0]), made, WHOLE_RANGE, PrintSettings())
    assert at_30.seen[0] == pytest.approx(at_30.target[0], abs=1e-6)
    plain = printable_tones(made.tone, made.slant_deg, made, WHOLE_RANGE, PrintSettings(calibration="none"))
    assert plain.seen == pytest.approx(made.reflectance) and plain.printed[3] == pytest.approx(made.tone)


def test_a_slope_whose_range_lies_elsewhere_shows_most_of_it():
    made = table(0.2 + 0.1 * TONE, 0.25 + 0.1 * TONE, 0.6 + 0.2 * TONE, 0.05 + 0.1 * TONE, 0.0 + 0.5 * TONE)
    low, high = targets(made, "compress", np.array([0.0, 1.0]), WHOLE_RANGE).T
    assert high - low == pytest.approx(0.1)
    assert low == pytest.approx([0.2, 0.225, 0.575, 0.075, 0.2])
    ways = inverse(made, "compress")
    assert (np.ptp(ways, axis=1) >= [0.999, 0.749, 0.374, 0.749, 0.199]).all()


@given(st.lists(st.floats(0, 1), min_size=2, max_size=30), st.sampled_from(["compress", "clip"]))
def test_more_tone_asked_for_is_never_less_printed(values, mapping):
    tone = np.linspace(0, 1, len(values))
    made = table(isotonic(np.array(values)), tone=tone)
    ways = inverse(made, mapping)
    assert ((ways >= 0) & (ways <= 1)).all()
    assert (np.diff(ways, axis=1) >= 0).all() or made.reflectance[0, 0] == made.reflectance[0, -1]

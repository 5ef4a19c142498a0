"""How well a photograph matches its picture, of made-up photographs for which that is known."""

from types import SimpleNamespace

import numpy as np
import pytest
from dualcolor.core.pictures.match import averaged, cell_means, correlation, enlarged, pattern_period, picture_match
from dualcolor.core.settings import PrintSettings

SETTINGS = PrintSettings(texture_filter="lanczos")
PERIOD = (1.0, SETTINGS.wavelength)


def patterned(picture, settings, mm_per_pixel=0.1):
    """A made-up photograph: stripes and waves of exactly the pattern's period, whose mean is 0.1 + 0.2 × tone."""
    high, wide = (round(cells * 0.5 / mm_per_pixel) for cells in picture.shape)
    tone = enlarged(picture, (high, wide))
    z, x = np.mgrid[0:high, 0:wide] * mm_per_pixel
    wave = np.cos(2 * np.pi * x / settings.wavelength) * np.sign(np.sin(2 * np.pi * (z + 0.05)))
    return (0.1 + 0.2 * tone * (1 + wave))[::-1].astype(np.float32)


def test_the_pattern_itself_costs_no_correlation_and_the_contrast_is_the_pictures():
    smooth = averaged(np.random.default_rng(5).random((48, 48)), (9, 9))
    picture = ((smooth - smooth.min()) / np.ptp(smooth)).astype(np.float32)
    found = picture_match(patterned(picture, SETTINGS), picture, 0.1, PERIOD)
    assert found.correlation > 0.995
    assert found.texel_correlation < 0.9  # a texel is narrower than a wave
    wanted = averaged(enlarged(picture, (240, 240)), (10, 12))[10:-10, 12:-12]
    assert found.contrast == pytest.approx(0.2 * np.subtract(*np.percentile(wanted, [99, 1])), rel=0.1)
    inverse = picture_match(patterned(1 - picture, SETTINGS), picture, 0.1, PERIOD)
    assert inverse.correlation < -0.99
    turned = picture_match(patterned(picture, SETTINGS)[:, ::-1], picture, 0.1, PERIOD)
    assert turned.correlation < 0.7


def test_averages_leave_out_what_is_not_seen():
    values = np.arange(20.0).reshape(4, 5)
    values[0, 0] = np.nan
    assert averaged(values, (2, 2))[1, 1] == pytest.approx((1 + 5 + 6) / 3)
    means = cell_means(values, (2, 1))
    np.testing.assert_allclose(means[:, 0], [np.arange(1, 10).mean(), np.arange(10, 20).mean()])
    assert correlation(np.array([1.0, 2.0, np.nan]), np.array([2.0, 4.0, 9.0])) == pytest.approx(1)
    assert correlation(np.ones(3), np.arange(3.0)) == 0


def test_each_pixel_has_the_texel_that_its_middle_lies_in():
    picture = np.arange(6, dtype=np.float32).reshape(2, 3)
    np.testing.assert_array_equal(enlarged(picture, (8, 12)), np.kron(picture, np.ones((4, 4))))
    np.testing.assert_array_equal(enlarged(picture, (5, 3))[:, 0], [0, 0, 3, 3, 3])


def test_the_period_is_four_layers_and_the_mean_wave_of_the_lines_that_have_some():
    around = np.exp(2j * np.pi * np.arange(48) / 48)
    base = np.concatenate([5 * around, 9 * around])
    wave = np.concatenate([np.tile([1.0, 0.0, -1.0, 0.0], 12), np.zeros(48)])  # the second line has no waves
    lines = SimpleNamespace(base=np.stack([base.real, base.imag], axis=1), start=np.array([0, 48, 96]), wave=wave)
    length = 48 * 2 * 5 * np.sin(np.pi / 48)
    assert pattern_period(lines, SETTINGS) == pytest.approx((4 * SETTINGS.layer_height, length / 12))
    lines.wave = np.zeros(96)
    assert pattern_period(lines, SETTINGS)[1] == SETTINGS.wavelength

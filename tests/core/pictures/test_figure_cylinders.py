"""The paper's Figure 3 as objects: colors of layers, shifted phases, attenuated waves."""

import numpy as np
import pytest
from dualcolor.core.gcode.reader import read_gcode
from dualcolor.core.paths import Feature
from dualcolor.core.pattern.modulation import layer_is_black, layer_shift
from dualcolor.core.pictures.figure_cylinders import FIGURES, figure_cylinder
from dualcolor.core.pictures.shapes import surface_of
from dualcolor.core.pipeline import generate
from dualcolor.core.ragged import following
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.printing import gcode_text

SMALL = PrintSettings(texture_filter="lanczos", infill_density=0.0)
NO_TOWER = {"tower_type": "none", "skirts": 0}


def printed(kind, height, more=NO_TOWER):
    made = figure_cylinder(kind, 8.0, height, SMALL)
    return made, generate(surface_of(made.shape, made.picture, 0.5, kind), made.settings.changed(more))


def phases(outlines):
    """(L,) radians, where the waves of each layer sit about the cylinder; they are the same number in all layers."""
    angle = np.arctan2(*outlines.base.T[::-1])
    off = np.hypot(*outlines.points.T) - np.hypot(*outlines.base.T)
    step = np.angle(np.exp(1j * (angle[following(outlines.start)] - angle)))
    layer = np.repeat(outlines.layer, np.diff(outlines.start))
    crests = np.bincount(layer, outlines.wave > 1 - 1e-12)
    assert np.ptp(crests) == 0
    both = (off + off[following(outlines.start)]) / 2
    wave = both * step * np.exp(-1j * crests[0] * (angle + step / 2))
    return np.angle(np.bincount(layer, wave.real) + 1j * np.bincount(layer, wave.imag))


def between(one, other):
    """Radians from one phase to the other, 0 to π."""
    return np.abs(np.angle(np.exp(1j * (one - other))))


def test_layers_alternate_unless_it_is_set_otherwise():
    layer = np.arange(24)
    assert layer_is_black(layer, PrintSettings()).tolist() == [True, False] * 12
    mixed = layer_is_black(layer, PrintSettings(mostly_white_below=8, mostly_black_above=16))
    assert mixed[:8].tolist() == [True, False, False, False] * 2
    assert mixed[8:16].tolist() == [True, False] * 4
    assert mixed[16:].tolist() == [True, False, True, True] * 2
    shift = layer_shift(layer, PrintSettings(phase_shift_layers=2))
    assert (shift[layer % 2 == 0] == 0).all()
    assert shift[1::2] == pytest.approx(np.arange(12) % 8 * np.pi / 4)


def test_three_of_four_layers_are_white_below_and_black_above():
    made, result = printed("checkered", 9.0, {})
    laid = result.moves.extrudes & (result.moves.feature == Feature.OUTER_WALL)
    tool = np.array([result.moves.tool[laid & (result.moves.layer == layer)][0] for layer in range(36)])
    assert [int((tool[part] == made.settings.black_tool).sum()) for part in (np.s_[:12], np.s_[12:24], np.s_[24:])] == [
        3, 6, 9,
    ]  # fmt: skip
    assert result.report["tool_changes"] == (np.diff(tool) != 0).sum() < 35
    middle = phases(result.outlines)[12:24]
    assert between(middle[1::2], middle[::2]) == pytest.approx([np.pi, np.pi] * 3, abs=0.1)  # the checkerboard
    read = read_gcode(gcode_text(result.moves, made.settings, ["object = Cylinder"]), "file")
    assert read.settings == made.settings
    assert read.moves.filament.sum() == pytest.approx(result.moves.filament.sum(), abs=0.01)
    back = read.moves.extrudes
    assert (read.moves.tool[back] == result.moves.tool[result.moves.extrudes]).all()


def test_white_waves_are_shifted_by_an_eighth_more_in_each_band():
    made, result = printed("phase_shifted", 9.0)
    assert made.settings.phase_shift_layers == 4 and made.settings.calibration == "none"
    sits = phases(result.outlines)
    shift = between(sits[1::2], sits[::2]).reshape(9, 2).mean(axis=1)
    assert shift == pytest.approx(np.pi / 4 * np.array([0, 1, 2, 3, 4, 3, 2, 1, 0]), abs=0.12)
    assert between(sits[::2], sits[0]).max() < 0.1  # the black ones stand still


def test_waves_get_shallower_as_the_tone_asks_for():
    _, result = printed("attenuated", 9.0)
    outline = result.outlines
    layer = np.repeat(outline.layer, np.diff(outline.start))
    depth = np.bincount(layer, outline.depth) / np.bincount(layer)
    black, white = depth[::2], depth[1::2]
    assert black[:8] == pytest.approx(np.full(8, 0.75), abs=0.01) and (np.diff(black[9:]) < 0).all()
    assert white[-8:] == pytest.approx(np.full(8, 0.75), abs=0.01) and (np.diff(white[:9]) > 0).all()
    assert [black[-1], white[0]] == pytest.approx([0.375, 0.375], abs=0.03)


def test_every_kind_has_a_name_and_the_gradient_keeps_the_settings():
    assert set(FIGURES) == {"gradient", "checkered", "phase_shifted", "attenuated"}
    made = figure_cylinder("gradient", 20.0, 36.0, SMALL)
    assert made.settings == SMALL and made.shape.rows == 72
    assert made.picture.tone[:, 0] == pytest.approx(np.linspace(0, 1, 72), abs=1e-6)
    assert all(
        figure_cylinder(kind, 20.0, 36.0, SMALL).settings.pattern == "wave" for kind in FIGURES if kind != "gradient"
    )

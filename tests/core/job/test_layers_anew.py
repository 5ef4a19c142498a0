"""After a stroke only the layers that it touches are made anew, and the print is what it is without the others kept."""

from dataclasses import replace

import numpy as np
import pytest
from dualcolor.core.errors import PrintError
from dualcolor.core.job import changed_layers, move_stages
from dualcolor.core.job.layers import widened, without_gaps
from dualcolor.core.job.stage_cache import StageCache
from dualcolor.core.mesh.plate import plate
from dualcolor.core.pipeline import generate
from dualcolor.core.ragged import runs
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.core.job.test_stage_cache import of
from dualcolor.tests.solids import lathe, picture

ROWS = 64
BOTTLE = [[7, 0], [8, 3], [8, 6], [5, 8], [9, 10], [9, 12]]
PICTURE = picture(np.random.default_rng(1).random((ROWS, 16)) * 0.9 + 0.05)
CHANGES = {
    "offset": {},
    "wave": {"pattern": "wave"},
    "waves set back": {"pattern": "wave_offset", "support_enable": True, "raft_layers": 2},
    "as in the paper": {"pattern": "wave", "sampling": "paper", "support_enable": True},
    "two tools in a layer": {"solid_regions": "tool_change", "solid_region_tolerance": 0.4},
    "black set back": {"solid_regions": "set_back", "solid_region_tolerance": 0.4},
    "hidden seams": {"pattern": "wave", "hide_seams": True},
    "no tower": {"tower_type": "none"},
    "mostly white": {"mostly_white_below": 99, "retract_before_travel": 14.0, "skirts": 0},
    "seams above seams": {"seam_position": "aligned"},
    "near seams": {"seam_position": "nearest", "infill_pattern": "gyroid", "perimeters": 3},
    "slowed": {"slowdown_below_layer_time": 25.0, "min_print_speed": 5.0},
    "mostly white, slowed": {"mostly_white_below": 99, "slowdown_below_layer_time": 25.0},
    "hollow, cooled": {"infill_density": 0.0, "standby_temperature_delta": 60.0, "calibration": "none"},
}


def bottle(image, **places):
    return lathe(BOTTLE, 48, textures=(image,), **places)


def touched(image, rng):
    """The picture with a stroke or two."""
    tone = image.tone.copy()
    for _ in range(rng.integers(1, 3)):
        row, column = rng.integers(0, ROWS - 4), rng.integers(0, 10)
        tone[row : row + rng.integers(1, 5), column : column + 5] = rng.choice([0.0, 1.0, 0.3])
    return replace(image, tone=tone)


@pytest.fixture
def made(monkeypatch):
    """How many loops and rows of moves are made anew."""
    counts = {"loops": [], "moves": []}

    def noting(name, function, length):
        def call(*given):
            result = function(*given)
            counts[name].append(length(result))
            return result

        return call

    monkeypatch.setattr(
        changed_layers, "joined", noting("loops", changed_layers.joined, lambda result: len(result.layer))
    )
    assembled = noting("moves", move_stages.assemble, lambda result: len(result.tool))
    monkeypatch.setattr(move_stages, "assemble", assembled)
    return counts


@pytest.mark.parametrize("name", CHANGES)
def test_strokes_print_as_without_former_layers(name, made):
    rng, cache, settings = np.random.default_rng(len(name)), StageCache(), PrintSettings().changed(CHANGES[name])
    image = PICTURE
    generate(bottle(image), settings, cache=cache)
    for _ in range(3):
        image = touched(image, rng)
        kept = generate(bottle(image), settings, cache=cache)
        assert of(kept) == of(generate(bottle(image), settings))
    # Where seams are hidden the tone moves all waves.
    assert made["loops"] or name in ("hidden seams", "two tools in a layer")


def test_only_a_few_layers_are_made_anew(made):
    cache = StageCache()
    whole = generate(bottle(PICTURE), PrintSettings(), cache=cache)
    tone = PICTURE.tone.copy()
    tone[20:22] = 0.5
    result = generate(bottle(replace(PICTURE, tone=tone)), PrintSettings(), cache=cache)
    layers = len(whole.slices.layers)
    assert 1 <= made["loops"][0] < 0.15 * layers and len(made["loops"]) == 1
    assert len(made["moves"]) == 2 and made["moves"][1] < 0.3 * made["moves"][0]
    below = np.searchsorted(whole.moves.layer, 10)
    assert np.array_equal(whole.moves.position[:below], result.moves.position[:below])
    assert result.moves.position.flags.f_contiguous  # axis by axis, as the later stages read it


def test_settings_of_the_pattern_change_only_layers_that_are_set_back(made):
    cache, tone = StageCache(), PICTURE.tone.copy()
    tone[: ROWS // 2] = 0.5  # set back in neither color
    image = replace(PICTURE, tone=tone)
    for change in ({}, {"offset_max": 0.3}, {"offset_onset": 0.2}, {}):
        settings = PrintSettings().changed(change | {"calibration": "none"})
        whole = generate(bottle(image), settings)
        assert of(generate(bottle(image), settings, cache=cache)) == of(whole)
    assert len(made["loops"]) == 3 and max(made["loops"]) < 0.6 * len(whole.slices.layers)


def test_what_the_last_run_did_without_counts_as_new():
    cache, other = StageCache(), replace(PICTURE, tone=PICTURE.tone[::-1].copy())
    for image, hidden in ((PICTURE, False), (other, True), (PICTURE, False)):
        settings = PrintSettings().changed({"hide_seams": hidden, "calibration": "none"})
        assert of(generate(bottle(image), settings, cache=cache)) == of(generate(bottle(image), settings))


def test_a_layer_of_the_same_color_begins_where_the_fresh_one_below_it_ends():
    settings = PrintSettings().changed({"mostly_white_below": 99, "z_hop": 0.4, "slowdown_below_layer_time": 0.0})
    cache, tone = StageCache(), PICTURE.tone.copy()
    tone[19] = 0.2
    image = replace(PICTURE, tone=tone)
    former, kept = (generate(bottle(painted), settings, cache=cache) for painted in (PICTURE, image))
    assert layers_apart(former, kept) == [14, 15]
    assert layers_apart(kept, generate(bottle(image), settings)) == []


def layers_apart(one, other):
    """The layers on which the moves of two prints differ."""

    def rows(moves, layer):
        here = slice(*np.searchsorted(moves.layer, (layer, layer + 1)))
        return np.column_stack([moves.position[here], moves.filament[here], moves.speed[here], moves.tool[here]])

    count = len(one.slices.layers)
    return [layer for layer in range(count) if not np.array_equal(rows(one.moves, layer), rows(other.moves, layer))]


def test_a_tip_too_thin_to_print_hinders_nobody(made):
    cache, settings = StageCache(), PrintSettings()
    for row in (4, 40, 60):
        tone = PICTURE.tone.copy()
        tone[row : row + 4, 3:8] = 0.2
        tipped = lathe([[7, 0], [7, 10], [0.1, 12]], 48, textures=(replace(PICTURE, tone=tone),))
        assert of(generate(tipped, settings, cache=cache)) == of(generate(tipped, settings))
    assert len(made["loops"]) >= 2


def test_objects_that_share_a_picture(made):
    settings, cache, tone = PrintSettings(), StageCache(), PICTURE.tone.copy()
    tone[20:24, 3:8] = 0.2
    for image in (PICTURE, replace(PICTURE, tone=tone)):
        both = plate([bottle(image), bottle(image, x=25)], settings)
        assert of(generate(both, settings, cache=cache)) == of(generate(both, settings))
    assert made["loops"]


def test_other_settings_and_a_run_that_fails_leave_nothing_behind(made):
    rng, cache, image = np.random.default_rng(0), StageCache(), PICTURE
    for change in ({}, {"infill_density": 30.0}, {"tower_x": 140.0, "tower_placement": "manual"}, {}, {"skirts": 3}):
        image, settings = touched(image, rng), PrintSettings().changed(change)
        if "tower_x" in change:
            with pytest.raises(PrintError):
                generate(bottle(image), settings, cache=cache)
        else:
            assert of(generate(bottle(image), settings, cache=cache)) == of(generate(bottle(image), settings))


def test_runs_of_layers():
    layers = np.zeros(60, dtype=bool)
    layers[[3, 4, 7, 30]] = True
    assert runs(layers) == [(3, 5), (7, 8), (30, 31)] and runs(without_gaps(layers)) == [(3, 8), (30, 31)]
    assert runs(widened(layers, 2)) == [(1, 10), (28, 33)] and runs(widened(layers[:4], 2)) == [(1, 4)]
    layers[::6] = True
    assert runs(without_gaps(layers)) == [(0, 55)]

"""Time and plastic by feature, cost, progress, and the same object in a single color."""

import math

import numpy as np
import pytest
from dualcolor.core.job.path_stages import path_stages
from dualcolor.core.job.stages import Stages
from dualcolor.core.job.wall_stages import wall_stages
from dualcolor.core.paths import Feature, Paths
from dualcolor.core.pipeline import generate
from dualcolor.core.progress import drained
from dualcolor.core.settings import PrintSettings
from dualcolor.core.statistics.breakdown import (
    filament_report,
    filament_use,
    heating_seconds,
    stretches,
    time_report,
    tool_change_rows,
)
from dualcolor.core.statistics.single_color import single_color_moves, single_color_seconds
from dualcolor.core.toolpaths.move_times import layer_begins, move_seconds
from dualcolor.core.toolpaths.moves import Moves
from dualcolor.tests.core.fill.fill_shapes import fill_paths
from dualcolor.tests.printing import print_time, rosette
from dualcolor.tests.real_models import obj_model
from dualcolor.tests.solids import box, cylinder, joined, lathe

SETTINGS = PrintSettings(pattern="wave")


@pytest.fixture(scope="module")
def can():
    return generate(cylinder(radius=12, height=2), SETTINGS.changed({"skirts": 0}))


def test_parts_add_up_to_the_whole():
    moves = rosette(4, 300)
    report = time_report(moves, SETTINGS)
    assert sum(report["features"].values()) == pytest.approx(report["total"], rel=1e-12)
    for name, seconds in print_time(moves, SETTINGS).items():
        assert report[name] == pytest.approx(seconds)
    assert report["features"]["tower"] == pytest.approx(report["tower"])
    assert report["features"]["tool_change"] == pytest.approx(report["tool_change"])
    assert "single_color" not in report


def test_layers_begin_when_the_time_before_them_has_passed():
    moves = rosette(4, 300)
    seconds = move_seconds(moves, SETTINGS.printer_profile)
    begins = layer_begins(moves, seconds)
    assert len(begins) == 5 and begins[0] == 0
    assert begins[-1] == pytest.approx(seconds.sum(), rel=1e-12)
    starts = np.searchsorted(moves.layer, [1, 2, 3])
    assert begins[1:4] == pytest.approx([seconds[:row].sum() for row in starts], rel=1e-12)
    # all four layers take as long, the first one without a tool change
    assert np.diff(begins) == pytest.approx(np.full(4, begins[-1] / 4), rel=0.1)


def test_heating_waits_for_the_bed_then_for_the_nozzles():
    moves = rosette(2, 30)
    cold_bed = heating_seconds(moves, SETTINGS.changed({"bed_temperature": 0}))
    assert cold_bed == pytest.approx((235 - 22) / 1.5)
    assert heating_seconds(moves, SETTINGS) == pytest.approx((110 - 22) / 0.15 + (235 - 140) / 1.5)
    hotter = SETTINGS.changed({"nozzle_temperature_1": 260})
    assert heating_seconds(moves, hotter) == pytest.approx(heating_seconds(moves, SETTINGS) + 25 / 1.5)


def test_cost_and_shares():
    moves = rosette(4, 101)
    report = filament_report(moves, SETTINGS.changed({"filament_cost": 40}))
    assert report["cost"] == pytest.approx((report["tool0_g"] + report["tool1_g"]) * 0.04)
    gram_per_mm = np.pi / 4 * 1.75**2 * 1.04e-3
    assert report["features_g"]["tower"] == pytest.approx(4 * 0.66 * gram_per_mm)
    assert report["features_g"]["outer_wall"] == pytest.approx(400 * 0.0041 * gram_per_mm)
    assert report["tower_share"] == pytest.approx(4 * 0.66 / (4 * 0.66 + 400 * 0.0041))
    assert report["support_share"] == 0


def test_single_color_print_has_no_wave_no_tower_and_no_tool_change(can):
    settings = SETTINGS.changed({"perimeters": 0, "infill_density": 0, "top_solid_layers": 0, "bottom_solid_layers": 0})
    moves = single_color_moves(can.outlines, Paths.empty(), can.slices.layers, settings)
    assert (moves.tool == 0).all()
    assert set(moves.feature[moves.extrudes]) == {int(Feature.OUTER_WALL)}
    layers = len(can.slices.layers)
    way = np.linalg.norm(np.diff(moves.position, axis=0), axis=1)[moves.extrudes[1:]].sum()
    assert way == pytest.approx(layers * 2 * np.pi * (12 - 0.2), rel=2e-3)
    radius = np.hypot(*moves.position[moves.extrudes, :2].T)
    assert np.ptp(radius) < 0.06
    assert (moves.position[moves.extrudes, 2] == can.slices.layers.top[moves.layer[moves.extrudes]]).all()
    # one circle a layer at 40 mm/s, which is below what its bend allows; a tenth for starting and stopping
    hurried = settings.changed({"slowdown_below_layer_time": 0})
    moves = single_color_moves(can.outlines, Paths.empty(), can.slices.layers, hurried)
    line = print_time(moves, settings)["total"]
    assert line == pytest.approx((layers - 1) * 2 * np.pi * 11.8 / 40 + 2 * np.pi * 11.8 / 30, rel=0.1)


def test_report_of_a_job_compares_with_a_single_color(can):
    time = can.report["time_s"]
    assert time["total"] > time["single_color"] + time["tower"]
    assert time["ratio"] == pytest.approx(time["total"] / time["single_color"])
    wall = time["features"]["outer_wall"]
    alone = time["single_color"] - sum(time["features"].get(name, 0) for name in ("inner_wall", "skin", "infill"))
    assert alone < wall  # what is left of a single color is its wall and its travels


def test_fill_of_the_single_color_is_that_of_the_dual_color(can):
    cut = can.slices
    fill = fill_paths(cut.regions, cut.polygons, cut.polygon_layer, SETTINGS)
    moves = single_color_moves(can.outlines, fill, cut.layers, SETTINGS)
    for feature in (Feature.SKIN, Feature.INNER_WALL):
        assert feature in moves.feature
    assert (np.diff(moves.layer) >= 0).all()


def compared(model, settings):
    """Seconds in one color, as the report tells them and as all layers take, and how many layers the report used."""
    with Stages(None) as stages:
        wall = drained(wall_stages(model, settings, stages))
        paths = drained(path_stages(wall, settings, stages))
    printer = settings.printer_profile
    known = paths.single_color.result()
    told = single_color_seconds(known, paths.moves, move_seconds(paths.moves, printer), settings)
    beside = paths.beside
    inner = Paths.joined([paths.fill, beside.supports])
    moves = single_color_moves(wall.outlines, inner, wall.cut.layers, settings, paths.within, below=beside.below)
    return told, move_seconds(moves, printer).sum(), len(known.layer) / len(wall.cut.layers)


AROUND = {"tower_type": "w", "ooze_shield": True, "raft_layers": 2, "skirts": 0}


THICK = {"filament_diameter_1": 3.5, "slowdown_below_layer_time": 16.0, "infill_density": 30.0}


@pytest.mark.parametrize("more", [{"tower_type": "none", "brim_width": 3}, {"pattern": "wave"} | AROUND, THICK])
def test_some_layers_tell_the_time_in_a_single_color(more):
    told, all_layers, share = compared(lathe([[4, 0], [9, 11], [5, 18], [7, 30]]), PrintSettings().changed(more))
    assert share < 0.5
    assert told == pytest.approx(all_layers, rel=0.005)


def test_some_layers_tell_the_time_of_a_real_print_in_a_single_color(data):
    model = obj_model(data / "meshes/spot/spot.obj", 60)
    told, all_layers, share = compared(model, PrintSettings())
    assert share < 0.25
    assert told == pytest.approx(all_layers, rel=0.01)


def test_layers_without_anything_tell_nothing():
    """Two slabs far apart: the layers between them are empty."""
    model = joined(box((-4, -4, 0), (4, 4, 1.1)), box((-4, -4, 38.9), (4, 4, 40)))
    told, all_layers, _ = compared(model, PrintSettings())
    assert told == pytest.approx(all_layers, rel=1e-12)


def test_no_moves_take_no_time():
    nothing = Moves(*(column[:0] for column in vars(rosette(1, 9)).values()))
    assert move_seconds(nothing, SETTINGS.printer_profile).tolist() == []


def test_a_low_print_is_put_together_as_a_whole_in_a_single_color():
    told, all_layers, share = compared(cylinder(radius=6, height=6), PrintSettings())
    assert share == 1
    assert told == pytest.approx(all_layers, rel=1e-12)


def test_filament_use():
    moves = rosette(4, 101)
    use = filament_use(moves, SETTINGS.changed({"filament_diameter_1": 2.0, "filament_density": 1.1}))
    strands = 2 * 0.66 + 2 * 100 * 0.0041
    assert use["tool0_mm"] == pytest.approx(strands + 4.0 - 8.0)  # pulled back at the end, primed once
    assert use["tool1_mm"] == pytest.approx(strands)
    assert use["tool0_g"] == pytest.approx(use["tool0_mm"] * math.pi / 4 * 1.75**2 * 1.1e-3)
    assert use["tool1_g"] == pytest.approx(use["tool1_mm"] * math.pi * 1.1e-3)
    assert (moves.feature == Feature.RETRACT).sum() == 7


def test_stretches_add_up_to_the_moves():
    moves = rosette(3, 40)
    seconds = move_seconds(moves, SETTINGS.printer_profile)
    few, taken = stretches(moves, seconds)
    assert len(few.tool) < len(moves.tool) / 5 and taken.sum() == pytest.approx(seconds.sum())
    told, whole = (time_report(rows, SETTINGS, 100.0, spent) for rows, spent in ((few, taken), (moves, seconds)))
    assert told.pop("features") == pytest.approx(whole.pop("features")) and told == pytest.approx(whole)
    assert filament_use(few, SETTINGS) == pytest.approx(filament_use(moves, SETTINGS))
    assert layer_begins(few, taken) == pytest.approx(layer_begins(moves, seconds))
    assert len(tool_change_rows(few)) and taken[tool_change_rows(few)].sum() == pytest.approx(
        seconds[tool_change_rows(moves)].sum()
    )

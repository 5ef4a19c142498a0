"""Warnings of objects that may fall over and of lines too narrow for their height."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from dualcolor.commands.terminal import summary
from dualcolor.core.pipeline import generate
from dualcolor.core.printability.footing import footing_warnings, line_warnings
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.solids import box, joined, lathe

PLAN = PrintSettings(calibration="none")


def warned(model, settings=PLAN):
    return [text for text in generate(model, settings).warnings if "fall over" in text]


def test_a_needle_may_fall_over_and_a_brim_holds_it():
    needle = box((0, 0, 0), (2, 6, 30))
    (text,) = warned(needle)
    assert "30 mm high on a foot of 2.0 mm" in text and "brim_width" in text
    for change in ({"brim_width": 0.5}, {"raft_layers": 2}):
        assert not warned(needle, replace(PLAN, **change))
    assert not warned(box((0, 0, 0), (3, 6, 30)))


def test_the_foot_counts_not_the_body_and_several_feet_are_one():
    assert warned(lathe([[1, 0], [1, 3], [8, 14], [8, 30]]))
    assert not warned(joined(box((0, 0, 0), (1, 1, 18)), box((8, 8, 0), (9, 9, 18)), box((0, 8, 0), (1, 9, 18))))


def test_a_slanted_foot_is_measured_across():
    turn = np.radians(30)
    model = box((0, 0, 0), (2, 20, 30))
    x, y, z = model.vertices.T
    turned = np.column_stack([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn), z])
    (text,) = warned(replace(model, vertices=turned))
    assert "a foot of 2.0 mm" in text


def test_each_object_of_a_plate_has_its_own_foot():
    result = generate(joined(box((0, 0, 0), (1, 1, 20)), box((20, 0, 0), (30, 10, 20))), PLAN)
    mesh = replace(result.mesh, face_object=np.repeat([0, 1], 12))
    (text,) = footing_warnings(mesh, ["pin", "brick"], result.slices.regions[0], PLAN)
    assert text.startswith("pin is 20 mm high")


@pytest.mark.parametrize("nothing", [shapely.Polygon(), shapely.MultiPolygon()])
def test_an_object_of_which_nothing_stands_on_the_bed_has_no_foot(nothing):
    mesh = generate(box((0, 0, 0), (2, 6, 30)), PLAN).mesh
    assert footing_warnings(mesh, ["needle"], nothing, PLAN) == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"extrusion_width": 0.2}, "raise extrusion_width or lower layer_height"),
        ({"first_layer_height": 0.5}, "raise first_layer_extrusion_width or lower first_layer_height"),
    ],
)
def test_lines_that_are_higher_than_wide(change, words):
    (text,) = line_warnings(replace(PLAN, **change))
    assert text.endswith(words)
    assert line_warnings(PLAN) == []


def test_one_layer_is_one_layer():
    assert "1 layer, 0 tool changes" in summary(generate(box((0, 0, 0), (8, 8, 0.2)), PLAN))[0]
    assert "2 layers, 1 tool change" in summary(generate(box((0, 0, 0), (8, 8, 0.5)), PLAN))[0].split("mm, ")[1]

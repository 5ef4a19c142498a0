"""Features too thin for a wall against solids of known size."""

import json

import numpy as np
import pytest
from dualcolor.core.contours.contours import contours
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.pipeline import generate
from dualcolor.core.printability.thin_features import thin_features, thin_report
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.tests.solids import box, cylinder, joined, lathe, surface

PLAN = PrintSettings(center_on_bed=False)


def found_in(model, plan=PLAN):
    cut = slices(triangulate(model, plan), plan)
    found = thin_features(cut, contours(cut.outlines, cut.loop_polygon, plan), plan)
    return found, thin_report(found, cut)


def test_what_holds_a_wall_is_not_reported():
    thick = joined(box((0, 0, 0), (20, 20, 3)), box((5, 10, 3), (15, 10.6, 6)))
    for model in (cylinder(8, 3), thick):
        _, report = found_in(model)
        assert report == {"count": 0, "layers": 0, "length_mm": 0.0, "area_mm2": 0.0, "places": []}


def test_a_fin_is_reported_with_place_height_length_and_area():
    _, report = found_in(joined(box((0, 0, 0), (20, 20, 3)), box((4, 15, 3), (14, 15.3, 5))))
    assert report["count"] == 1 and report["layers"] == 8
    assert (report["z_from"], report["z_to"]) == (3.0, 5.0)
    assert report["length_mm"] == pytest.approx(8 * 10.3, rel=0.02)
    assert report["area_mm2"] == pytest.approx(8 * 10 * 0.3, rel=0.02)
    (place,) = report["places"]
    assert (place["x"], place["y"]) == pytest.approx((9.0, 15.15), abs=0.05)


def test_a_fin_on_a_thick_wall_is_told_from_it():
    """In one outline with what is thick: only the part that juts out counts."""
    plus = joined(box((0, 0, 0), (10, 10, 2)), box((9.9, 4.85, 0), (16, 5.15, 2)))
    found, report = found_in(plus)
    assert report["count"] == 1 and report["layers"] == 8
    assert found.area == pytest.approx(6.0 * 0.3, rel=0.1)
    assert found.place[:, 0] == pytest.approx(13.0, abs=0.2)


def test_a_wedge_is_thin_where_it_is_thinner_than_two_thinnest_lines():
    wedge = surface(
        [[0, 0, 0], [40, 1, 0], [0, 2, 0], [0, 0, 2], [40, 1, 2], [0, 2, 2]],
        [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]],
    )
    found, _ = found_in(wedge)
    assert len(found.layer) == 8
    assert found.area == pytest.approx(8.0 * 0.4 / 2, rel=0.15)  # 2 mm on 40 mm: thinner than 0.4 mm over 8 mm


def test_pins_that_were_left_out_are_reported_one_by_one():
    pins = [lathe([[0.17, 2], [0.17, 4]], x=x, y=5.0) for x in (3.0, 15.0)]
    _, report = found_in(joined(box((0, 0, 0), (20, 10, 2)), *pins))
    assert report["count"] == 2 and report["layers"] == 8
    assert sorted(place["x"] for place in report["places"]) == pytest.approx([3.0, 15.0], abs=0.01)
    assert report["area_mm2"] == pytest.approx(2 * 8 * np.pi * 0.17**2, rel=0.02)


def test_thicker_lines_make_more_features_thin():
    model = joined(box((0, 0, 0), (20, 20, 2)), box((4, 15, 2), (14, 15.5, 4)))
    assert found_in(model)[1]["count"] == 0
    assert found_in(model, PLAN.changed({"extrusion_width": 0.6}))[1]["count"] == 1


def test_the_job_warns_and_says_what_to_do():
    model = joined(box((0, 0, 0), (20, 20, 2)), box((4, 15, 2), (14, 15.3, 3)))
    job = generate(model, PrintSettings(center_on_bed=False, skirt_distance=2.0, tower_type="none"))
    (said,) = [warning for warning in job.warnings if "too thin" in warning]
    assert (
        "1 feature is thinner" in said and "x 9.0, y 15." in said and "z 2.00 to 3.00 mm" in said and "thicken" in said
    )
    assert json.loads(json.dumps(job.report))["thin_features"]["layers"] == 4

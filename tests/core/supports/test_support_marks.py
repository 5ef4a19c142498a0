"""Support enforcers and blockers: marked faces and volumes."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from dualcolor.core.errors import MeshError
from dualcolor.core.mesh.plate import plate
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.model import SupportMark, SupportVolume
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.slicing.planes import layer_stack
from dualcolor.core.supports.marks import marks, painted
from dualcolor.tests.core.supports.test_supports import SETTINGS, TABLE, held
from dualcolor.tests.solids import box, joined, lathe, surface

BLOCKER, ENFORCER = SupportMark.BLOCKER, SupportMark.ENFORCER
# Leans out by a layer's height a layer: 45 degrees, more than the 30 that are held by default.
FUNNEL = lathe([[4, 0], [14, 10]])
LEFT, RIGHT = shapely.box(-99, -99, -5, 99), shapely.box(5, -99, 99, 99)


def marked(model, mark, where):
    """A copy in which the downward faces whose middle satisfies `where` carry a mark."""
    corners = model.vertices[model.corner_vertex.reshape(-1, 3)]
    down = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] < -1e-9
    chosen = down & where(corners.mean(axis=1)) & (corners[:, :, 2].max(axis=1) > 0.1)
    assert chosen.any()
    return replace(model, polygon_support=np.where(chosen, int(mark), 0))


def volume(mark, low, high):
    solid = box(low, high)
    return SupportVolume(mark, solid.vertices, solid.polygon_start, solid.corner_vertex, "marker")


def split(model):
    """A table whose plate is two, so that the halves of its underside are faces of their own."""
    return joined(box((-3, -3, 0), (3, 3, 10)), box((-12, -8, 10), (0, 8, 14)), box((0, -8, 10), (12, 8, 14)))


def covered(made):
    return shapely.union_all(made.covered)


@pytest.mark.parametrize("how", ["faces", "volume"])
def test_a_blocked_overhang_gets_no_support(how):
    table = split(TABLE)
    left = marked(table, BLOCKER, lambda middle: middle[:, 0] < 0)
    if how == "volume":
        left = replace(table, volumes=(volume(BLOCKER, (-20, -20, 9), (0, 20, 11)),))
    _, made = held(left)
    _, usual = held(table)
    assert not covered(made).intersects(LEFT)
    assert covered(made).intersection(RIGHT).area == pytest.approx(covered(usual).intersection(RIGHT).area, rel=0.01)
    assert covered(usual).intersection(LEFT).area > 80


@pytest.mark.parametrize("how", ["faces", "volume"])
def test_an_enforced_slope_that_holds_itself_is_supported(how):
    _, bare = held(FUNNEL)
    assert not len(bare.paths.layer)
    right = marked(FUNNEL, ENFORCER, lambda middle: middle[:, 0] > 5)
    if how == "volume":
        right = replace(FUNNEL, volumes=(volume(ENFORCER, (5, -20, -1), (20, 20, 20)),))
    cut, made = held(right)
    found = covered(made)
    assert found.area > 60 and not found.intersects(LEFT)
    under = shapely.Point(0, 0).buffer(14.2)
    assert under.covers(found), "straight below the slope"
    for layer in range(len(cut.regions)):
        assert made.covered[layer].distance(cut.regions[layer]) > SETTINGS.support_xy_distance or (
            made.covered[layer].is_empty
        )


@pytest.mark.parametrize(("pattern", "perimeters"), [("offset", 1), ("offset", 3), ("wave", 1)])
def test_bridges_need_no_supports_but_what_sticks_out_does(pattern, perimeters):
    """A gate of two pillars, whose beam goes on for 10 mm beyond the right one."""
    pillars = joined(box((-15, -5, 0), (-9, 5, 10)), box((9, -5, 0), (15, 5, 10)))
    gate = joined(pillars, box((-15, -5, 10), (25, 5, 13)))
    plan = SETTINGS.changed({"pattern": pattern, "perimeters": perimeters, "tower_type": "none"})
    middle, end = (-9, 9), (15, 25)

    def held_between(model, settings):
        moves = generate(model, settings.changed({"center_on_bed": False})).moves
        x = moves.position[moves.extrudes & np.isin(moves.feature, (Feature.SUPPORT, Feature.SUPPORT_INTERFACE)), 0]
        return [bool(((x > low) & (x < high)).any()) for low, high in (middle, end)]

    assert held_between(gate, plan) == [True, True]
    spanned = plan.changed({"dont_support_bridges": True})
    assert held_between(gate, spanned) == [False, True]
    enforced = marked(gate, ENFORCER, lambda middle: (middle[:, 2] > 9) & (middle[:, 2] < 11))
    assert held_between(enforced, spanned) == [True, True]


def test_a_blocker_wins():
    both = replace(
        marked(FUNNEL, ENFORCER, lambda middle: middle[:, 0] > 5),
        volumes=(volume(BLOCKER, (0, -20, -1), (20, 20, 20)),),
    )
    assert not len(held(both)[1].paths.layer)


def test_only_what_is_enforced_without_automatic_supports():
    settings = SETTINGS.changed({"support_auto": False})
    table = split(TABLE)
    assert not len(held(table, settings)[1].paths.layer)
    _, made = held(marked(table, ENFORCER, lambda middle: middle[:, 0] > 0), settings)
    assert covered(made).intersection(RIGHT).area > 80 and not covered(made).intersects(LEFT)


def test_a_small_enforced_patch_is_worth_a_column():
    """A nib of 1.5 mm² below a roof hangs without a support; enforced it gets a column that stands."""
    roof = joined(box((-3, -3, 0), (3, 3, 12)), box((-3, -3, 12), (4.4, 3, 14)))
    narrow = box((4.4, -0.5, 13), (5.9, 0.5, 14))
    settings = SETTINGS.changed({"support_xy_distance": 0.0})
    nib = joined(roof, narrow)
    enforced = marked(nib, ENFORCER, lambda middle: middle[:, 2] > 12.5)
    _, made = held(enforced, settings.changed({"support_auto": False}))
    assert covered(made).area > 3


def test_walls_cannot_be_enforced():
    _, made = held(replace(TABLE, polygon_support=np.full(24, int(ENFORCER))), SETTINGS)
    _, usual = held(TABLE, SETTINGS)
    assert covered(made).symmetric_difference(covered(usual)).area < 0.5


def test_marked_areas_are_those_between_the_planes():
    """A slope of 20 mm by 6 mm that rises by 5 mm: 1 mm of it a layer, the last layers none."""
    slope = surface([[0, 0, 1], [20, 0, 6], [20, 6, 6], [0, 6, 1]], [[0, 1, 2], [0, 2, 3]])
    planes = layer_stack(8.0, SETTINGS).plane
    found = painted(
        triangulate(replace(slope), SETTINGS.changed({"center_on_bed": False})), np.array([True, True]), planes
    )
    length = np.clip((planes - 1) * 4, 0, 20)
    expected = np.diff(length, prepend=0.0)
    rows = expected > 0
    # All shapes are a little larger than the faces.
    np.testing.assert_allclose(shapely.area(found[rows]), (expected[rows] + 0.1) * 6.1, rtol=0.005)
    assert shapely.is_empty(found[~rows]).all()
    assert rows.sum() == 21
    for layer in np.flatnonzero(rows):
        assert shapely.bounds(found[layer])[2] == pytest.approx(length[layer] + 0.05, abs=0.06)


def test_a_horizontal_face_belongs_to_the_layer_that_rests_on_it():
    square = surface([[0, 0, 2], [9, 0, 2], [9, 9, 2], [0, 9, 2], [0, 0, 0]], [[0, 1, 2], [0, 2, 3], [0, 4, 1]])
    planes = np.array([0.5, 1.5, 2.0, 2.5, 3.5])
    mesh = triangulate(square, SETTINGS.changed({"center_on_bed": False}))
    found = painted(mesh, np.array([True, True, False]), planes)
    assert (shapely.area(found) > 80).tolist() == [False, False, False, True, False]


def test_marks_move_with_the_object():
    """Off the bed's middle, or on an arranged plate, volumes stay with their object."""
    away = replace(FUNNEL.moved(np.array([50.0, 20, 7])), volumes=(volume(ENFORCER, (55, 0, 6), (70, 40, 27)),))
    found = covered(held(away)[1])
    assert found.area > 60 and not found.intersects(LEFT)
    whole = plate([box((0, 0, 0), (40, 10, 5)), replace(away, name="B")], SETTINGS.changed({"arrange": True}))
    mesh = triangulate(whole, SETTINGS)
    low, high = mesh.bounds_of(1)
    assert mesh.volumes[0].vertices.min(axis=0) == pytest.approx([(low[0] + high[0]) / 2 + 5, low[1] - 6, -1])


def test_marks_of_a_plate_are_those_of_its_objects():
    marked_funnel = marked(FUNNEL, ENFORCER, lambda middle: middle[:, 0] > 5)
    whole = plate([TABLE, replace(marked_funnel, name="funnel")], SETTINGS)
    assert whole.polygon_support.sum() == marked_funnel.polygon_support.sum()
    assert not whole.polygon_support[whole.polygon_object == 0].any()


def test_without_marks_nothing_is_looked_at():
    assert marks(triangulate(TABLE, SETTINGS), np.array([1.0, 2.0])) is None


def test_an_open_volume_is_named():
    solid = box((0, 0, 0), (9, 9, 9))
    hollow = replace(
        volume(BLOCKER, (0, 0, 0), (9, 9, 9)),
        polygon_start=solid.polygon_start[:-4],
        corner_vertex=solid.corner_vertex[: solid.polygon_start[-5]],
    )
    with pytest.raises(MeshError, match="the support volume marker is open"):
        held(replace(TABLE, volumes=(hollow,)))


def test_marks_without_supports_are_told():
    off = SETTINGS.changed({"support_enable": False})
    small = replace(box((0, 0, 0), (10, 10, 2)), volumes=(volume(BLOCKER, (0, 0, 0), (9, 9, 9)),))
    assert any("do nothing while support_enable is off" in warning for warning in generate(small, off).warnings)
    assert not any("support" in warning for warning in generate(small, SETTINGS).warnings)

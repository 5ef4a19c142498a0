"""Several objects on one plate: their places, their own tones, and what is said about them."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from dualcolor.core.errors import MeshError, TextureError
from dualcolor.core.mesh.plate import plate
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.tests.real_models import obj_model
from dualcolor.tests.solids import box, cylinder, joined, picture

SETTINGS = PrintSettings()
ARRANGE = PrintSettings(arrange=True)


def named(model, name):
    return replace(model, name=name)


def toned(low, high, tone, name):
    made = box(low, high)
    return named(replace(made, corner_tone=np.full(len(made.corner_vertex), float(tone))), name)


def places(model, settings):
    mesh = triangulate(model, settings)
    return [mesh.bounds_of(number) for number in range(len(model.names))]


def test_one_object_is_no_plate():
    alone = box((0, 0, 0), (10, 10, 5))
    assert plate([alone], ARRANGE) is alone


def test_the_group_is_moved_as_one():
    pair = plate([named(box((50, 0, 7), (60, 10, 17)), "A"), named(box((75, 4, 9), (80, 9, 19)), "B")], SETTINGS)
    first, second = places(pair, SETTINGS)
    np.testing.assert_allclose(first, [[-15, -5, 0], [-5, 5, 10]])
    np.testing.assert_allclose(second, [[10, -1, 2], [15, 4, 12]])
    stay = PrintSettings(center_on_bed=False)
    np.testing.assert_allclose(places(pair, stay)[1], [[75, 4, 9], [80, 9, 19]])


SHIELD = {"pattern": "offset", "ooze_shield": True, "ooze_shield_distance": 2.0, "extrusion_width": 0.5}


@pytest.mark.parametrize(
    ("changes", "crests"), [({"pattern": "offset"}, 0.0), ({"pattern": "wave"}, 0.75), (SHIELD, 2 * (2.0 + 0.5))]
)
@pytest.mark.parametrize("distance", [1.0, 8.0])
def test_arranged_objects_stand_on_the_bed_clear_of_each_other(distance, changes, crests):
    """What lies around each of them, the crests of waves or a shield as thick as a line, counts as theirs."""
    settings = ARRANGE.changed({"arrange_distance": distance, **changes})
    models = [named(box((0, 0, k), (20 + 5 * k, 12, 9 + k)), f"box {k}") for k in range(7)]
    found = places(plate(models, settings), settings)
    boxes = [shapely.box(*bounds[0, :2], *bounds[1, :2]) for bounds in found]
    assert all(bounds[0, 2] == pytest.approx(0) for bounds in found)
    between = [a.distance(b) for k, a in enumerate(boxes) for b in boxes[:k]]
    assert distance + crests <= min(between) <= distance + crests + 3.3
    whole = shapely.union_all(boxes).bounds
    assert (np.abs(whole) <= [105, 73, 105, 73]).all()
    np.testing.assert_allclose(np.add(whole[:2], whole[2:]), 0, atol=1e-6)
    again = places(plate(models, settings), settings)
    assert np.array_equal(again, found)


def test_what_has_no_room_is_named():
    models = [named(box((0, 0, 0), (100, 100, 5)), name) for name in ("one", "two", "three")]
    assert len(plate(models[:2], ARRANGE).names) == 2
    with pytest.raises(MeshError, match="no room for three"):
        plate(models, ARRANGE)
    with pytest.raises(MeshError, match="long is 300"):
        plate([*models, named(box((0, 0, 0), (300, 10, 5)), "long")], ARRANGE)


def test_a_bad_object_is_named():
    good = named(box((0, 0, 0), (10, 10, 5)), "good")
    bad = named(replace(good, vertices=good.vertices * np.nan), "bad")
    with pytest.raises(MeshError, match="bad has 8 vertices"):
        plate([good, bad], SETTINGS)
    bare = named(replace(good, textures=(picture([[0.5]]),), polygon_texture=np.zeros(12, dtype=np.int64)), "bare")
    with pytest.raises(TextureError, match="bare has a texture but no UV map"):
        plate([good, bare], SETTINGS)


def test_each_object_keeps_its_own_tone():
    """A box of dark vertex colors, a box of light ones, a textured cylinder and a bare box."""
    wrapped = named(cylinder(5, 3, x=30, textures=[picture([[0.3, 0.3], [0.3, 0.3]])]), "wrapped")
    models = [toned((0, 0, 0), (10, 10, 3), 0.1, "dark"), toned((14, 0, 0), (24, 10, 3), 0.9, "light"), wrapped]
    models.append(named(box((-20, 0, 0), (-10, 10, 3)), "bare"))
    result = generate(plate(models, SETTINGS), SETTINGS)
    assert [row["name"] for row in result.report["objects"]] == ["dark", "light", "wrapped", "bare"]
    for row, tone in zip(result.report["objects"], (0.1, 0.9, 0.3, 0.5), strict=True):
        low, high = np.array(row["bounds_mm"])[:, :2]
        mine = ((result.outlines.base >= low) & (result.outlines.base <= high)).all(axis=1)
        assert mine.sum() > 100
        np.testing.assert_allclose(result.outlines.tone[mine], tone, atol=0.01)
    assert result.report["tool_changes"] == result.report["layers"] - 1
    assert result.report["name"] == "dark"
    about_paint = [warning for warning in result.warnings if "has no texture" in warning]
    assert about_paint == ["bare has no texture and no color attribute: it prints in one even tone"]


def test_pictures_are_shared_and_told_apart():
    image, other = picture([[0.2]]), picture([[0.2]])
    made = [named(cylinder(5, 3, x=20 * k, textures=[each]), str(k)) for k, each in enumerate((image, other, image))]
    whole = plate(made, SETTINGS)
    assert len(whole.textures) == 2
    assert np.unique(whole.polygon_texture[whole.polygon_object == 2]).tolist() == [0]
    assert np.unique(whole.polygon_texture[whole.polygon_object == 1]).tolist() == [1]


def test_polygons_without_a_picture_stay_without_one():
    image, other, hidden = picture([[0.2]]), picture([[0.7]]), picture([[1.0]])
    bare = cylinder(5, 3, sides=6, textures=[image])
    count = len(bare.polygon_texture)
    single = replace(bare, polygon_texture=np.where(np.arange(count) % 2, 0, -1))
    several = replace(
        bare,
        textures=(other, image, hidden),
        polygon_texture=np.arange(count) % 3 - 1,
        polygon_visibility=np.full(count, 2),
    )
    whole = plate([single, named(several, "several"), named(bare, "bare")], SETTINGS)
    shown = [whole.polygon_texture[whole.polygon_object == number] for number in range(3)]
    seen = [[None if row < 0 else whole.textures[row] for row in rows] for rows in shown]
    assert [row is image for row in seen[0]] == (single.polygon_texture == 0).tolist()
    assert [row is None for row in seen[0]] == (single.polygon_texture < 0).tolist()
    expected = [(None, other, image)[number] for number in np.arange(count) % 3]
    assert all(one is two for one, two in zip(seen[1], expected, strict=True)) and set(shown[2]) == {shown[0].max()}
    visible = [set(whole.polygon_visibility[whole.polygon_object == number]) for number in range(3)]
    assert visible[0] == visible[2] == {-1} and [whole.textures[row] is hidden for row in visible[1]] == [True]


def test_every_layer_has_the_islands_of_all():
    fork = joined(box((0, 0, 0), (4, 10, 10)), box((8, 0, 0), (12, 10, 10)), box((0, 0, 9.9), (12, 10, 14)))
    lone, tall = slices(triangulate(fork, SETTINGS), SETTINGS), box((0, 0, 0), (10, 10, 20))
    cut = slices(triangulate(plate([fork, tall, named(fork, "other")], ARRANGE), ARRANGE), ARRANGE)
    counts, alone = np.bincount(cut.polygon_layer), np.bincount(lone.polygon_layer)
    assert counts[: len(alone)].tolist() == (2 * alone + 1).tolist()
    assert (counts[len(alone) :] == 1).all() and len(counts) == 80
    assert not len(cut.overlaps)


def test_objects_that_touch_stay_apart():
    """Two boxes with a face in common: nothing is welded across, and no loop runs over both."""
    pair = plate([box((0, 0, 0), (10, 10, 5)), named(box((10, 0, 0), (20, 10, 5)), "B")], SETTINGS)
    mesh = triangulate(pair, SETTINGS)
    assert len(mesh.vertices) == 16
    cut = slices(mesh, SETTINGS)
    assert not len(cut.overlaps)
    assert cut.regions[3].area == pytest.approx(200, abs=0.01)


def test_overlaps_are_counted_by_layer():
    first, second = named(box((0, 0, 0), (10, 10, 10)), "A"), named(box((8, 2, 0), (20, 8, 5)), "B")
    inside, apart = named(box((2, 2, 2), (6, 6, 4)), "C"), named(box((30, 0, 0), (40, 10, 5)), "D")
    result = generate(plate([first, second, inside, apart], SETTINGS), SETTINGS)
    assert result.slices.overlaps.tolist() == [[0, 1, 20], [0, 2, 8]]
    assert sum("run into each other" in warning for warning in result.warnings) == 2
    assert any(warning.startswith("C begins 2.0 mm above the bed") for warning in result.warnings)
    # A post in a ring is inside the ring's outline, but not in its plastic.
    ring = joined(box((0, 0, 0), (10, 10, 5)), box((2, 2, -1), (8, 8, 6), inward=True))
    assert not len(slices(triangulate(plate([ring, box((4, 4, 0), (6, 6, 5))], SETTINGS), SETTINGS), SETTINGS).overlaps)


def test_a_plate_of_three_spots(data):
    """Every cow is waved as it is alone, with room around it, without a tool change more."""
    spot = obj_model(data / "meshes" / "spot" / "spot.obj", 16)
    alone, three = generate(spot, ARRANGE), generate(plate([spot] * 3, ARRANGE), ARRANGE)
    assert three.report["layers"] == alone.report["layers"]
    assert three.report["tool_changes"] == three.report["layers"] - 1
    assert np.bincount(three.outlines.layer).tolist() == (3 * np.bincount(alone.outlines.layer)).tolist()
    wall = [result.moves.filament[result.moves.feature == Feature.OUTER_WALL].sum() for result in (alone, three)]
    assert wall[1] == pytest.approx(3 * wall[0], rel=0.01)
    boxes = [shapely.box(*np.array(row["bounds_mm"])[:, :2].ravel()) for row in three.report["objects"]]
    hulls = [shapely.convex_hull(region) for region in shapely.get_parts(shapely.union_all(three.slices.regions))]
    assert len(hulls) == 3 and len({each.bounds for each in boxes}) == 3
    assert min(hulls[i].distance(hulls[j]) for i, j in ((0, 1), (0, 2), (1, 2))) > ARRANGE.arrange_distance

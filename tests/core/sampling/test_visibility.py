"""Seams go where they are not seen: the front, what is painted, the picture's own tones and the creases say where."""

from dataclasses import replace

import numpy as np
import pytest
from dualcolor.core.analysis.analysis import analyze
from dualcolor.core.contours.contours import contours
from dualcolor.core.errors import SettingsError, TextureError
from dualcolor.core.job.stage_cache import StageCache
from dualcolor.core.job.wall_stages import pattern_samples
from dualcolor.core.mesh.plate import plate
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.pipeline import generate
from dualcolor.core.sampling.projector import Projector
from dualcolor.core.sampling.quality import SALIENT, seam_errors
from dualcolor.core.sampling.visibility import crease_visibility, front_visibility, seam_visibility, tone_visibility
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.tests.solids import box, cylinder, lathe, picture

WAVES = PrintSettings(pattern="wave", wave_depth_max=0.6)
# Waves are born on the way up, as it gets wider.
CONE = [[6, 0], [14, 16]]


def found(model, settings=WAVES, tone=None):
    mesh = triangulate(model, settings)
    cut = slices(mesh, settings)
    lines = contours(cut.outlines, cut.loop_polygon, settings)
    return cut, lines, seam_visibility(lines, cut.layers.plane, mesh, model.textures, tone, settings)


def weighted(model, settings):
    """Salient share weighted by visibility: of the paper's sampling, and of ours that knows of it."""
    _, lines, seen = found(model, settings)
    projector = Projector(lines, settings.projection_threshold)
    shares = []
    for scheme in ("paper", "optimized"):
        samples = pattern_samples(projector, settings.changed({"sampling": scheme}), seen)
        errors = seam_errors(samples, projector)
        weight = seen[lines.locate(errors.arc)[0]]
        report = errors.shares(len(samples.arc), weight)
        kept = ~errors.discarded
        weight = weight[kept]
        assert report["salient_seen"] == pytest.approx(weight @ (errors.error[kept] >= SALIENT) / weight.sum())
        assert report["visibility"] == pytest.approx(weight.mean())
        shares.append(report["salient_seen"])
    return shares


def test_the_front_is_told_by_its_angle():
    turn = np.radians(np.arange(0, 360, 15))
    normal = np.column_stack([np.cos(turn), np.sin(turn)])
    for angle, way in ((0, (0, -1)), (90, (1, 0)), (180, (0, 1)), (-90, (-1, 0)), (30, (0.5, -(3**0.5) / 2))):
        np.testing.assert_allclose(front_visibility(normal, angle), np.maximum(normal @ way, 0), atol=1e-12)


def test_nothing_is_worked_out_unless_something_asks_for_it():
    model = lathe(CONE)
    assert found(model)[2] is None
    assert found(model, PrintSettings(front=True))[2] is None  # the pattern offset has no waves
    assert "salient_seen" not in generate(model, WAVES).report["pattern"]


def test_seams_leave_the_front():
    """Of a few dozen births one more or less in front makes a difference, so three fronts are taken together."""
    fronts = [WAVES.changed({"front": True, "front_angle": angle}) for angle in (0.0, 90.0, 180.0)]
    paper, known = np.sum([weighted(lathe(CONE), front) for front in fronts], axis=0)
    assert paper > 0.015 and known < 0.3 * paper


def test_corner_values_are_interpolated_on_the_faces():
    """A value that is linear in space comes out as it is at the walls of a box, half a line inside."""
    model = box((-10, -10, 0), (10, 10, 12))
    place = model.vertices[model.corner_vertex]
    value = 0.4 + place @ [0.02, 0.01, 0.02]
    _, lines, seen = found(replace(model, corner_visibility=value))
    cut, *_ = found(model)
    height = cut.layers.plane[lines.layer[lines.loop]]
    middle = (np.abs(lines.points) < 8).any(axis=1)  # of a side, clear of the rounded corners
    outside = np.where(np.abs(lines.points) > 9, np.sign(lines.points) * 10, lines.points)
    np.testing.assert_allclose(seen[middle], (0.4 + outside @ [0.02, 0.01] + height * 0.02)[middle], atol=2e-3)


def test_seams_leave_what_is_painted():
    """A picture, white on a third of the way around; then the same as values at the vertices."""
    shown = picture(np.where(np.arange(96) < 32, 1.0, 0.0)[None].repeat(8, axis=0))
    plain = lathe(CONE, textures=[picture(np.full((8, 8), 0.5))])
    pictured = replace(
        plain, textures=(*plain.textures, shown), polygon_visibility=np.ones(len(plain.polygon_texture), int)
    )
    turn = np.degrees(np.arctan2(*plain.vertices[plain.corner_vertex][:, 1::-1].T)) % 360
    weights = replace(plain, corner_visibility=np.where((turn > 1) & (turn < 119), 1.0, 0.0))
    for model in (pictured, weights):
        _, lines, seen = found(model)
        angle = np.degrees(np.arctan2(*lines.points[:, ::-1].T)) % 360
        wall = lines.layer[lines.loop] > 0
        assert seen[wall & (angle > 8) & (angle < 112)].min() > 0.99
        assert seen[wall & (angle > 128) & (angle < 352)].max() < 0.01
        paper, known = weighted(model, WAVES)
        assert paper > 0.005 and known < 0.35 * paper


def test_a_picture_that_only_says_where_seams_are_seen_is_not_printed():
    shown = picture(np.zeros((8, 8)))
    gray = lathe(CONE, textures=[picture(np.full((8, 8), 0.7))])
    model = replace(gray, textures=(*gray.textures, shown), polygon_visibility=np.ones(len(gray.polygon_texture), int))
    assert generate(model, WAVES).outlines.tone[1000:] == pytest.approx(0.7, abs=0.02)


def test_seams_go_where_the_picture_is_of_one_color():
    tone = np.where(np.arange(96) < 48, 0.5, 1.0)[None].repeat(8, axis=0)
    model = lathe(CONE, textures=[picture(tone)])
    plain = generate(model, WAVES.changed({"hide_seams": True, "sampling": "paper"})).report["pattern"]
    hidden = generate(model, WAVES.changed({"hide_seams": True})).report["pattern"]
    assert plain["salient_seen"] > 0.002 and hidden["salient_seen"] < 0.3 * plain["salient_seen"]
    assert tone_visibility(np.array([0.0, 0.25, 0.5, 0.75, 1.0])) == pytest.approx([0.2, 0.5, 1, 0.5, 0.2])


def test_creases_are_hidden():
    """A plus sign from above: its four inner corners are creases, its outer ones are not."""
    arm = [
        (3, 3),
        (3, 10),
        (-3, 10),
        (-3, 3),
        (-10, 3),
        (-10, -3),
        (-3, -3),
        (-3, -10),
        (3, -10),
        (3, -3),
        (10, -3),
        (10, 3),
    ]
    sides = len(arm)
    low = np.column_stack([arm, np.zeros(sides)])
    vertices = np.concatenate([low, low + np.array([0, 0, 5])])
    wall = [[k, (k + 1) % sides, (k + 1) % sides + sides, k + sides] for k in range(sides)]
    start = np.concatenate([np.arange(sides + 1) * 4, [5 * sides, 6 * sides]])
    corners = np.concatenate([np.ravel(wall), np.arange(sides)[::-1], np.arange(sides) + sides])
    model = replace(box((0, 0, 0), (1, 1, 1)), vertices=vertices, polygon_start=start, corner_vertex=corners,
                    polygon_texture=np.full(sides + 2, -1))  # fmt: skip
    hiding = WAVES.changed({"hide_seams": True})
    cut = slices(triangulate(model, hiding), hiding)
    seen = crease_visibility(lines := contours(cut.outlines, cut.loop_polygon, hiding))
    inner = np.hypot(*(np.abs(lines.points) - 3).T) < 0.3
    flat = (np.abs(lines.points).max(axis=1) > 5) & (np.abs(lines.points).max(axis=1) < 8)
    assert inner.any() and seen[inner].min() < 0.4 and seen[flat] == pytest.approx(1.0)


def test_what_is_said_for_nothing_is_warned_of():
    model = cylinder(8, 4)
    warned = {
        name: [text for text in generate(model, PrintSettings().changed(change)).warnings if "seams" in text]
        for name, change in {
            "offset": {"front": True},
            "paper": {"front": True, "pattern": "wave", "sampling": "paper"},
            "fine": {"front": True, "pattern": "wave"},
        }.items()
    }
    assert "no waves" in warned["offset"][0] and "paper" in warned["paper"][0] and not warned["fine"]
    assert "salient_seen" in analyze(model, WAVES.changed({"front": True})).report["pattern"]


def test_a_plate_keeps_what_each_object_says():
    shown, paint = picture(np.zeros((4, 4))), picture(np.ones((4, 4)))
    one = replace(cylinder(5, 4, textures=[paint]), name="one")
    one = replace(one, textures=(paint, shown), polygon_visibility=np.ones(len(one.polygon_texture), int))
    other = replace(cylinder(5, 4, x=20), name="other")
    other = replace(other, corner_visibility=np.full(len(other.corner_vertex), 0.25))
    whole = plate([one, other, replace(box((30, 0, 0), (40, 9, 4)), name="third")], WAVES)
    assert whole.textures[whole.polygon_visibility[0]] is shown
    assert set(whole.polygon_visibility[whole.polygon_object > 0].tolist()) == {-1}
    _, lines, seen = found(whole)
    x = lines.points[:, 0] - lines.points[:, 0].min()
    for low, high, value in ((0, 11, 0.0), (19, 31, 0.25), (34, 60, 1.0)):
        assert seen[(x > low) & (x < high)] == pytest.approx(value, abs=1e-6)


def test_kept_stages_notice_another_front():
    model, cache = lathe(CONE), StageCache()
    names = []
    original = cache.run

    def watched(name, work, *inputs):
        def told(*given):
            names.append(name)
            return work(*given)

        return original(name, told, *inputs)

    cache.run = watched
    front = WAVES.changed({"front": True})
    generate(model, WAVES, cache=cache)
    for settings, expected in (
        (WAVES, False),
        (front, True),
        (front, False),
        (WAVES.changed({"front": True, "front_angle": 90.0}), True),
    ):
        names.clear()
        generate(model, settings, cache=cache)
        assert ("sampling" in names) == expected and "slicing" not in names and "contours" not in names


def painted_box():
    """A box of 20 mm with UVs and a vertex group that is 1 at its bottom; Blender's scene is fresh."""
    pytest.importorskip("bpy")
    from dualcolor.tests.scene import add_box, add_uvs, fresh

    fresh()
    obj = add_box((20, 20, 20))
    add_uvs(obj)
    obj.vertex_groups.new(name="unused")
    obj.vertex_groups.new(name="seen").add([0, 2, 4, 6], 0.75, "REPLACE")
    return obj


def test_a_vertex_group_says_where_seams_are_seen():
    obj = painted_box()
    from dualcolor.tests.scene import model_of

    model = model_of(obj, seam_visibility="seen")
    height = model.vertices[model.corner_vertex, 2]
    np.testing.assert_allclose(model.corner_visibility, np.where(height < 1, 0.75, 0.0))
    assert model.polygon_visibility is None and model_of(obj).corner_visibility is None


def test_the_other_objects_of_a_plate_need_no_such_group():
    obj = painted_box()
    import bpy
    from dualcolor.bridge.input.plate import plate_model
    from dualcolor.tests.scene import add_box

    other = add_box((5, 5, 5), "other")
    other.location.x = 30
    depsgraph = bpy.context.evaluated_depsgraph_get()
    whole = plate_model([obj, other], depsgraph, PrintSettings(seam_visibility="seen"), [None, None])
    corner_object = np.repeat(whole.polygon_object, np.diff(whole.polygon_start))
    assert set(whole.corner_visibility[corner_object == 0].tolist()) == {0.0, 0.75}
    assert set(whole.corner_visibility[corner_object == 1].tolist()) == {1.0}


def test_an_image_says_where_seams_are_seen(tmp_path):
    obj = painted_box()
    import bpy
    from dualcolor.tests.scene import flat_image, model_of

    flat_image((1, 1, 1, 1), "mask", is_data=True)
    model = model_of(obj, seam_visibility="mask")
    assert model.textures[model.polygon_visibility[0]].tone == pytest.approx(1.0)
    assert (model.polygon_texture == -1).all()
    image = bpy.data.images["mask"]
    image.filepath_raw, image.file_format = str(tmp_path / "file.png"), "PNG"
    image.save()
    before = len(bpy.data.images)
    model = model_of(obj, seam_visibility=str(tmp_path / "file.png"))
    assert model.textures[0].tone == pytest.approx(1.0) and len(bpy.data.images) == before


def test_what_is_not_there_is_named():
    obj = painted_box()
    from dualcolor.tests.scene import add_box, model_of

    with pytest.raises(SettingsError, match="box has no vertex group absent"):
        model_of(obj, seam_visibility="absent")
    with pytest.raises(TextureError, match="no UV map"):
        model_of(add_box((9, 9, 9)), seam_visibility="absent")

"""Rendering the predicted print: what the picture shows, and that the scene stays as it was."""

import struct
from types import SimpleNamespace

import numpy as np
import pytest
from dualcolor.tests.sample_print import square_print

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.pictures.render import leaving_no_trace  # noqa: E402
from dualcolor.bridge.pictures.studio import camera_axes, camera_place  # noqa: E402
from dualcolor.bridge.pictures.views import picture_steps  # noqa: E402
from dualcolor.bridge.strands.preview import build_preview  # noqa: E402
from dualcolor.core.errors import OutputError, PrintError  # noqa: E402
from dualcolor.core.pictures.viewing import USUAL_VIEW, PictureOptions  # noqa: E402
from dualcolor.core.progress import drained  # noqa: E402
from dualcolor.tests.scene import datablocks  # noqa: E402


def png_size(path):
    return struct.unpack(">II", path.read_bytes()[16:24])


def render(collection, path, resolution=(48, 48), whole=False):
    options = PictureOptions(resolution=resolution, samples=4, whole_plate=whole)
    drained(picture_steps(collection, {USUAL_VIEW: path}, options))


def test_a_render_leaves_the_scene_as_it_was(scene, tmp_path):
    collection = build_preview(square_print())
    scene.render.engine, scene.render.filepath = "BLENDER_WORKBENCH", "//kept"
    before, images = datablocks(), set(bpy.data.images)
    render(collection, tmp_path / "a.png", (48, 40))
    assert png_size(tmp_path / "a.png") == (48, 40)
    assert datablocks() == before and set(bpy.data.images) == images
    assert bpy.context.scene == scene and scene.camera is None and scene.world is None
    assert (scene.render.engine, scene.render.filepath) == ("BLENDER_WORKBENCH", "//kept")
    assert [found.name for found in tmp_path.iterdir()] == ["a.png"]


def test_the_picture_shows_the_object_and_not_the_tower(scene, tmp_path):
    collection = build_preview(square_print())
    tones = {}
    for whole in (False, True):
        path = tmp_path / f"{whole}.png"
        render(collection, path, whole=whole)
        picture = bpy.data.images.load(str(path))
        tones[whole] = np.array(picture.pixels[:]).reshape(48, 48, 4)[..., 0]
    # Between the black and white lines of the block the picture varies; a plate with a tower shows the block smaller.
    assert tones[False][14:34, 10:38].std() > 0.05
    assert abs(tones[True] - tones[False]).mean() > 0.02


def test_no_strands_and_no_folder_are_errors(scene, tmp_path):
    empty = bpy.data.collections.new("Empty")
    before = datablocks()
    with pytest.raises(PrintError, match="no strands"):
        render(empty, tmp_path / "a.png")
    with pytest.raises(OutputError):
        render(empty, tmp_path / "missing" / "a.png")
    assert datablocks() == before


def test_what_the_user_makes_while_a_picture_is_taken_stays(scene):
    before = datablocks()
    with pytest.raises(ZeroDivisionError), leaving_no_trace() as all_is_made:
        bpy.data.scenes.new("Studio").collection.objects.link(bpy.data.objects.new("Lamp", None))
        all_is_made()
        kept = bpy.data.objects.new("Mine", None)
        raise ZeroDivisionError
    assert datablocks() == before | {"objects": sorted([*before["objects"], kept.name])}


def test_what_is_still_being_rendered_is_removed_once_that_has_ended(scene, monkeypatch, tmp_path):
    before, rendering, waiting = datablocks(), [True], []
    timers = SimpleNamespace(register=lambda action, first_interval: waiting.append(action))
    app = SimpleNamespace(is_job_running=lambda _: rendering[0], timers=timers)
    monkeypatch.setattr("dualcolor.bridge.pictures.render.bpy", SimpleNamespace(app=app, data=bpy.data))
    folder = tmp_path / "pictures"
    with leaving_no_trace(folder):
        folder.mkdir()
        bpy.data.scenes.new("Studio").collection.objects.link(bpy.data.objects.new("Lamp", None))
    (again,) = waiting
    assert again() > 0 and "Studio" in bpy.data.scenes and folder.exists()
    rendering[0] = False
    assert again() is None and datablocks() == before and not folder.exists()


@pytest.mark.parametrize("azimuth", [-0.5, 2.0])
def test_the_camera_sees_all_points_and_no_closer_place_does(azimuth):
    points = np.random.default_rng(3).normal(size=(200, 3)) * (5, 2, 9)
    axes = camera_axes(azimuth, 0.3)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    place = camera_place(points, axes, 0.2, 0.15)
    seen = (points - place) @ axes.T
    share = np.abs(seen[:, :2] / -seen[:, 2:]) / (0.2, 0.15)
    assert share.max() == pytest.approx(1.0)
    assert (seen[:, 2] < 0).all()

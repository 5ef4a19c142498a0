"""Hollows get dark, what is open stays as it was, and nothing is left behind."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.paint.ambient_occlusion import darkened, occlusion, occlusion_steps  # noqa: E402
from dualcolor.core.errors import MeshError, TextureError  # noqa: E402
from dualcolor.core.progress import drained  # noqa: E402
from dualcolor.core.texture.decode import linear_from_srgb  # noqa: E402
from dualcolor.tests.scene import add_box, add_mesh, add_uvs, flat_image  # noqa: E402

KINDS = ("scenes", "worlds", "objects", "meshes", "materials", "images")
pytestmark = pytest.mark.usefixtures("registered")


def counts():
    return {kind: len(getattr(bpy.data, kind)) for kind in KINDS}


@pytest.fixture
def corner():
    """Two walls of 40 mm at a right angle; U runs along both, away from the corner from the middle on."""
    corners = [(-20, 0, 0), (20, 0, 0), (20, 20, 0), (-20, 20, 0), (20, 0, 20), (-20, 0, 20)]
    obj = add_mesh(corners, [(0, 1, 2, 3), (1, 0, 5, 4)])
    floor, wall = [[0, 0.5], [1, 0.5], [1, 1], [0, 1]], [[1, 0.5], [0, 0.5], [0, 0], [1, 0]]
    add_uvs(obj, floor + wall)
    return obj


def test_a_corner_is_half_dark_and_grows_lighter_away_from_it(corner):
    before = counts()
    shade = occlusion(corner, (64, 64), distance_mm=15.0, samples=64)
    assert counts() == before
    rows = shade[:, 16:48].mean(axis=1)
    assert rows[33] == pytest.approx(0.5, abs=0.12)
    assert rows[62] > 0.9 and rows[1] > 0.9
    assert np.all(np.diff(rows[33:62:7]) > 0)


def test_distance_is_in_millimeters_in_every_scene(corner):
    near = occlusion(corner, (32, 32), distance_mm=4.0, samples=32)
    far = occlusion(corner, (32, 32), distance_mm=40.0, samples=32)
    assert far.mean() < near.mean() - 0.1
    bpy.context.scene.unit_settings.scale_length = 1.0
    corner.scale = (0.001,) * 3
    bpy.context.view_layer.update()
    assert occlusion(corner, (32, 32), distance_mm=4.0, samples=32).mean() == pytest.approx(near.mean(), abs=0.02)


def test_the_uv_map_can_be_another_than_the_active_one(corner):
    name = corner.data.uv_layers.active.name
    expected = occlusion(corner, (32, 32), samples=4)
    corner.data.uv_layers.new(name="other", do_init=False).active = True
    job = occlusion_steps(corner, (32, 32), samples=4, uv_map=name)
    np.testing.assert_allclose(drained(job), expected, atol=0.02)
    assert corner.data.uv_layers.active.name == "other"


def test_stopped_in_between_nothing_is_left(corner):
    before = counts()
    job = occlusion_steps(corner, (16, 16))
    next(job)
    job.close()
    assert counts() == before


def test_without_a_uv_map_it_says_so():
    with pytest.raises(TextureError, match="no UV map"):
        occlusion(add_box((9, 9, 9)), (16, 16))


def test_an_object_of_which_its_modifiers_leave_no_face_is_refused():
    """Cutting what has no edges finer would never end."""
    box = add_box((9, 9, 9))
    add_uvs(box)
    box.modifiers.new("Mask", "MASK").vertex_group = box.vertex_groups.new(name="none").name
    before = counts()
    with pytest.raises(MeshError, match="has no faces"):
        occlusion(box, (16, 16))
    assert counts() == before


def test_darkened_multiplies_light_and_keeps_alpha():
    image = flat_image((0.5, 0.8, 0.2, 0.25), size=8)
    made = darkened(image, np.full((8, 8), 0.5, dtype=np.float32), 0.6)
    after, before = (np.array(each.pixels[:]).reshape(-1, 4) for each in (made, image))
    assert made != image
    np.testing.assert_allclose(linear_from_srgb(after[:, :3]), 0.7 * linear_from_srgb(before[:, :3]), atol=0.01)
    np.testing.assert_allclose(after[:, 3], before[:, 3], atol=1e-6)


def test_a_picture_of_tiles_is_refused_before_anything_is_baked(corner):
    corner.dualcolor.image = tiled = bpy.data.images.new("tiled", 16, 16, tiled=True)
    tiled.tiles.new(1002)
    with pytest.raises(RuntimeError, match="several tiles"):
        bpy.ops.dualcolor.bake_occlusion(samples=1)
    assert corner.dualcolor.image == tiled and list(bpy.data.images) == [tiled]


def test_the_button_exchanges_the_picture(corner):
    assert bpy.ops.dualcolor.bake_occlusion(distance=15.0, samples=4) == {"FINISHED"}
    first = corner.data.materials[0].node_tree.nodes.active.image
    assert corner.dualcolor.image == first and len(bpy.data.images) == 1
    assert np.array(first.pixels[:]).reshape(-1, 4)[:, 0].min() < 0.9
    corner.dualcolor.image = painted = flat_image((0.5, 0.5, 0.5, 1.0), "painted", size=32)
    bpy.ops.dualcolor.bake_occlusion(samples=4)
    assert corner.dualcolor.image not in (first, painted) and painted.users == 0
    corner.data.uv_layers.remove(corner.data.uv_layers[0])
    assert not bpy.ops.dualcolor.bake_occlusion.poll()


def test_a_picture_that_was_resized_meanwhile_is_refused(scene):
    with pytest.raises(TextureError, match="resized"):
        darkened(flat_image((1, 1, 1, 1), size=8), np.ones((4, 4), dtype=np.float32), 1.0)

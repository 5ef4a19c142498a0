"""Model files end up as one upright object of the wanted size; unwrapping keeps what was there."""

from itertools import combinations, pairwise

import bpy
import numpy as np
import pytest
import shapely
from dualcolor.bridge.input.model_file import open_model
from dualcolor.bridge.paint.unwrap import unwrap
from dualcolor.core.errors import MeshError, PrintError
from dualcolor.core.texture.decode import linear_from_srgb
from dualcolor.tests.scene import add_box, add_material, add_mesh, add_uvs, extent, flat_image, fresh, model_of, volume

WEDGE = "v 0 0 0\nv 4 0 0\nv 0 3 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.fixture
def wedge(tmp_path):
    path = tmp_path / "wedge.obj"
    path.write_text(WEDGE)
    return path


@pytest.mark.parametrize(("up", "size"), [("", [4, 1, 3]), ("y", [4, 1, 3]), ("z", [4, 3, 1])])
def test_up_axis_of_an_obj(wedge, up, size):
    model = model_of(open_model(wedge, up=up))
    np.testing.assert_allclose(extent(model), size, atol=1e-5)
    np.testing.assert_allclose(model.vertices.min(axis=0)[2], 0, atol=1e-5)
    assert volume(model) == pytest.approx(2)
    assert model.name == "wedge"


def test_y_up_turns_the_front_to_the_front(wedge):
    model = model_of(open_model(wedge, up="y"))
    assert model.vertices[:, 1].min() == pytest.approx(-1)  # the file's +z looks at the viewer, as Blender's -y


def test_height_scales_everything_alike(wedge):
    np.testing.assert_allclose(extent(model_of(open_model(wedge, height_mm=60))), [80, 20, 60], rtol=1e-5)


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".glb"])
def test_formats_agree(tmp_path, suffix):
    fresh()
    add_box((10, 20, 30))
    path = tmp_path / f"box{suffix}"
    if suffix == ".stl":
        bpy.ops.wm.stl_export(filepath=str(path), forward_axis="Y", up_axis="Z")
    elif suffix == ".ply":
        bpy.ops.wm.ply_export(filepath=str(path), forward_axis="Y", up_axis="Z")
    else:
        bpy.ops.export_scene.gltf(filepath=str(path))
    model = model_of(open_model(path))
    np.testing.assert_allclose(extent(model), [10, 20, 30], rtol=1e-5)
    assert volume(model) == pytest.approx(6000, rel=1e-5)
    other = {".glb": "z"}.get(suffix, "y")
    np.testing.assert_allclose(extent(model_of(open_model(path, up=other))), [10, 30, 20], rtol=1e-5)


def test_all_meshes_of_a_file_are_joined_with_their_pictures(tmp_path):
    fresh()
    for number, tone in enumerate((0.0, 1.0)):
        box = add_box(name=f"box{number}")
        box.location.x = 3 * number
        add_uvs(box, name=f"map{number}")
        add_material(box, flat_image((tone, tone, tone, 1), f"image{number}"))
    path = tmp_path / "two.glb"
    bpy.ops.export_scene.gltf(filepath=str(path))
    model = model_of(open_model(path))
    np.testing.assert_allclose(extent(model), [4, 1, 1], atol=1e-5)
    assert model.name == "two"
    left = model.vertices[model.corner_vertex[model.polygon_start[:-1]], 0] < 2
    tones = np.array([image.tone.mean() for image in model.textures])[model.polygon_texture]
    np.testing.assert_allclose(tones, np.where(left, 0, 1), atol=0.01)
    alone = model_of(open_model(path, object_name="box1"))
    assert alone.name == "box1" and len(alone.polygon_start) == 13  # triangles of one box


def test_blend_keeps_units_and_modifiers_and_takes_the_active_mesh(tmp_path):
    fresh(millimeters=False)
    add_box((1, 1, 1), name="first")
    box = add_box((0.01, 0.02, 0.03), name="second")
    box.modifiers.new("Array", "ARRAY").count = 2
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    obj = open_model(path)
    assert obj.name == "second" and obj.modifiers
    np.testing.assert_allclose(extent(model_of(obj)), [20, 20, 30], rtol=1e-5)
    np.testing.assert_allclose(extent(model_of(open_model(path, height_mm=60))), [40, 40, 60], rtol=1e-5)
    np.testing.assert_allclose(extent(model_of(open_model(path, object_name="first"))), [1000] * 3, rtol=1e-5)
    with pytest.raises(PrintError, match=r"there is no object third.*first, second"):
        open_model(path, object_name="third")


def test_mirrored_objects_are_baked_facing_outward(tmp_path):
    fresh()
    box = add_box((10, 10, 10))
    box.scale = (-1, 1, 1)
    path = tmp_path / "mirror.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert volume(model_of(open_model(path, height_mm=20))) == pytest.approx(8000, rel=1e-4)


def test_several_meshes_without_an_active_one_need_a_name(tmp_path):
    fresh()
    add_box(name="first")
    add_box(name="second")
    bpy.context.view_layer.objects.active = None
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    with pytest.raises(PrintError, match="several meshes: choose one with --object: first, second"):
        open_model(path)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("nothing.obj", None, "there is no file"),
        ("notes.txt", "hello", "is not a model file"),
        ("part.3mf", "PK", "is of a kind that cannot be read: open it elsewhere and save it as .stl"),
        ("cat.png", "PNG", "dualcolor plate puts pictures on plates"),
        ("print.x3g", "", "dualcolor render shows"),
        ("empty.obj", "", "is empty"),
        ("nothing.stl", "solid nothing\nendsolid nothing\n", "holds no triangles"),
        ("comment.obj", "# nothing\n", "there is no mesh"),
        ("empty.stl", "", "is empty"),
        ("broken.glb", "hello", "cannot read"),
        ("broken.blend", "hello", "cannot read"),
        ("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n", "is flat"),
        ("points.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\n", "no faces|there is no mesh"),
    ],
)
def test_files_that_are_no_use_are_refused_in_one_sentence(tmp_path, name, content, message):
    path = tmp_path / name
    if content is not None:
        path.write_text(content)
    with pytest.raises(PrintError, match=message) as caught:
        open_model(path, height_mm=10)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("share", [0.0, 0.05, 0.4, 0.8, 0.97])
@pytest.mark.parametrize("name", ["a.blend", "compressed.blend", "a.obj", "a.stl", "a.ply", "a.glb", "a.gltf"])
def test_files_that_break_off(tmp_path, name, share):
    fresh()
    add_box(name="box")
    whole, cut = tmp_path / name, tmp_path / f"cut-{name}"
    if name.endswith(".blend"):
        bpy.ops.wm.save_as_mainfile(filepath=str(whole), compress=name.startswith("c"))
    elif ".gl" in name:
        bpy.ops.export_scene.gltf(filepath=str(whole), export_format="GLB" if name == "a.glb" else "GLTF_SEPARATE")
    else:
        getattr(bpy.ops.wm, f"{whole.suffix[1:]}_export")(filepath=str(whole))
    cut.write_bytes(whole.read_bytes()[: int(share * whole.stat().st_size)])
    try:
        made = open_model(cut, height_mm=10)
    except PrintError as problem:
        assert "\n" not in str(problem) and "Traceback" not in str(problem)
    else:
        assert share > 0.5 and made.data.polygons


def test_a_traceback_of_an_importer_is_not_passed_on(tmp_path):
    fresh()
    add_box(name="box")
    path = tmp_path / "a.glb"
    bpy.ops.export_scene.gltf(filepath=str(path))
    path.write_bytes(path.read_bytes().replace(b'"componentType":5126', b'"componentType":5127'))
    with pytest.raises(PrintError, match=r"cannot read .*damaged") as caught:
        open_model(path)
    assert "\n" not in str(caught.value)


def test_colors_of_a_ply_become_tone(tmp_path):
    path = tmp_path / "tetra.ply"
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 4\n"
    header += "property list uchar int vertex_indices\nend_header\n"
    points = ["0 0 0 255 255 255", "1 0 0 0 0 0", "0 1 0 128 128 128", "0 0 1 255 255 255"]
    path.write_text(header + "\n".join([*points, "3 0 2 1", "3 0 1 3", "3 0 3 2", "3 1 2 3"]) + "\n")
    model = model_of(open_model(path))
    expected = np.array([1, 0, float(linear_from_srgb(np.array(128 / 255))), 1])
    np.testing.assert_allclose(model.corner_tone, expected[model.corner_vertex], atol=2e-3)


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".glb"])
def test_painted_vertices_keep_their_tone_through_a_file(tmp_path, suffix):
    fresh()
    box = add_box((10, 20, 30))
    painted = box.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    box.data.color_attributes.active_color = painted
    tone = np.linspace(0.05, 0.95, len(painted.data))
    for place, value in zip(painted.data, tone, strict=True):
        place.color = (value, value, value, 1.0)
    straight = model_of(box)
    np.testing.assert_allclose(straight.corner_tone, tone[straight.corner_vertex], atol=1e-6)
    path = tmp_path / f"box{suffix}"
    if suffix == ".glb":
        bpy.ops.export_scene.gltf(filepath=str(path), export_vertex_color="ACTIVE")
    elif suffix == ".obj":
        bpy.ops.wm.obj_export(filepath=str(path), export_colors=True, forward_axis="Y", up_axis="Z")
    else:
        bpy.ops.wm.ply_export(filepath=str(path), export_colors="SRGB", forward_axis="Y", up_axis="Z")
    model = model_of(open_model(path, up="y" if suffix == ".glb" else "z"))
    nearest = np.linalg.norm(model.vertices[:, None] - straight.vertices, axis=2)
    assert nearest.min(axis=1).max() < 0.01
    np.testing.assert_allclose(model.corner_tone, tone[nearest.argmin(axis=1)][model.corner_vertex], atol=0.01)


def test_real_files_stand_upright_with_their_pictures(data):
    spot = model_of(open_model(data / "meshes/spot/spot.obj", height_mm=60))
    assert len(spot.textures) == 1 and spot.corner_uv is not None and extent(spot)[2] == pytest.approx(60, rel=1e-5)
    fox = model_of(open_model(data / "meshes/fox/Fox.glb"))
    assert len(fox.textures) == 1 and len(fox.polygon_start) == 577 and extent(fox)[1] > extent(fox)[2] > 60


@pytest.mark.parametrize("method", ["smart", "xatlas"])
def test_unwrapping_fills_the_square_without_overlap_and_keeps_old_maps(method):
    if method == "xatlas":
        pytest.importorskip("xatlas")
    fresh()
    box = add_box((10, 20, 30))
    add_uvs(box, np.array([0.25, 0.75]), "old")
    unwrap(box, method)
    model = model_of(box)
    assert box.data.uv_layers.active.name == "Dual-Color" and "old" in box.data.uv_layers
    uv = model.corner_uv
    assert uv.min() >= 0 and uv.max() <= 1 + 1e-6
    kept = np.empty(len(box.data.loops) * 2, dtype=np.float32)
    box.data.uv_layers["old"].uv.foreach_get("vector", kept)
    np.testing.assert_allclose(kept.reshape(-1, 2), np.tile([0.25, 0.75], (len(box.data.loops), 1)))
    area = [_uv_area(uv[a:b]) for a, b in zip(model.polygon_start[:-1], model.polygon_start[1:], strict=True)]
    assert min(area) > 0.005 and 0.3 < sum(area) <= 1
    assert volume(model) == pytest.approx(6000, rel=1e-5)


@pytest.mark.parametrize("side", [8, 20, 60])
def test_smart_charts_are_half_a_millimeter_apart(side):
    fresh()
    box = add_box((side, side, side))
    unwrap(box, "smart")
    model = model_of(box)
    charts = [shapely.Polygon(model.corner_uv[a:b]) for a, b in pairwise(model.polygon_start)]
    mm = side / np.sqrt(charts[0].area)
    apart = [one.distance(other) * mm for one, other in combinations(charts, 2)]
    assert 0.4 < min(gap for gap in apart if gap) < 0.8  # three charts of this box are one


def _uv_area(polygon):
    x, y = polygon.T
    return abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def test_what_cannot_be_unwrapped_is_said(monkeypatch):
    fresh()
    with pytest.raises(MeshError, match="no faces to unwrap"):
        unwrap(add_mesh([[0, 0, 0]], []), "smart")
    monkeypatch.setitem(__import__("sys").modules, "xatlas", None)
    with pytest.raises(PrintError, match="xatlas is not installed"):
        unwrap(add_box(), "xatlas")

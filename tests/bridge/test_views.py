"""Pictures of several sides, at a distance, and side by side."""

from types import SimpleNamespace

import numpy as np
import pytest
from dualcolor.tests.sample_print import LAYERS, SIDE, STEP, square_print
from PIL import Image

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor import cli  # noqa: E402
from dualcolor.bridge.input.mesh_input import surface_model  # noqa: E402
from dualcolor.bridge.pictures.painted import painted_model  # noqa: E402
from dualcolor.bridge.pictures.studio import swept  # noqa: E402
from dualcolor.bridge.pictures.views import TURNTABLE_FRAMES, picture_steps  # noqa: E402
from dualcolor.bridge.strands.preview import build_preview  # noqa: E402
from dualcolor.bridge.strands.rods import rods_of  # noqa: E402
from dualcolor.bridge.units import use_millimeters  # noqa: E402
from dualcolor.core.errors import OutputError  # noqa: E402
from dualcolor.core.pictures.viewing import PictureOptions  # noqa: E402
from dualcolor.core.progress import drained  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.operators import render  # noqa: E402
from dualcolor.tests.scene import add_box, add_material, add_uvs, flat_image  # noqa: E402

SMALL = PictureOptions(resolution=(40, 40), samples=2)


@pytest.fixture
def cube(scene):
    """A white block of the sample's size; its print is black and white."""
    use_millimeters(scene)
    made = add_box((SIDE, SIDE, LAYERS * STEP), "Cube")
    add_uvs(made)
    add_material(made, flat_image((1, 1, 1, 1)))
    bpy.context.view_layer.update()
    return made


def take_pictures(*wanted):
    drained(picture_steps(*wanted))


def pixels(path):
    with Image.open(path) as image:
        return np.asarray(image.convert("L"), dtype=float)


def datablocks():
    kinds = ("scenes", "objects", "hair_curves", "meshes", "cameras", "worlds", "materials", "images", "node_groups")
    return {kind: sorted(held.name for held in getattr(bpy.data, kind)) for kind in kinds}


def test_views_and_a_sheet_leave_everything_as_it_was(cube, tmp_path):
    collection = build_preview(square_print(), cube)
    before = datablocks()
    files = {view: tmp_path / f"{view}.png" for view in ("front", "left")}
    model = surface_model(cube, bpy.context.evaluated_depsgraph_get(), PrintSettings())
    take_pictures(collection, files, SMALL, tmp_path / "sheet.png", model)
    assert datablocks() == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["front.png", "left.png", "sheet.png"]
    assert pixels(files["front"]).shape == (40, 40)
    sheet = pixels(tmp_path / "sheet.png")
    assert sheet.shape[1] > 120 and sheet.shape[0] > 80  # three columns, two rows
    # The model on the left is white all over, the print beside it has black lines.
    third = sheet.shape[1] // 3
    middle = [sheet[45:55, column * third + 25 : column * third + 35] for column in range(2)]
    assert middle[0].mean() > middle[1].mean() + 15


def test_turning_the_front_is_going_around(cube, tmp_path):
    collection = build_preview(square_print(), cube)
    cube_like = {"front": tmp_path / "a.png"}
    take_pictures(collection, cube_like, PictureOptions(90.0, resolution=(40, 40), samples=2))
    take_pictures(collection, {"right": tmp_path / "b.png"}, SMALL)
    np.testing.assert_array_equal(pixels(tmp_path / "a.png"), pixels(tmp_path / "b.png"))


def test_a_distance_takes_detail_away(cube, tmp_path):
    collection = build_preview(square_print(), cube)
    take_pictures(collection, {"front": tmp_path / "near.png"}, SMALL)
    far = PictureOptions(distance="shelf", resolution=(40, 40), samples=2)
    take_pictures(collection, {"front": tmp_path / "far.png"}, far)
    near, far = (pixels(tmp_path / name)[14:26, 12:28] for name in ("near.png", "far.png"))
    assert far.std() < 0.8 * near.std()


def test_a_turntable_is_an_animation(cube, tmp_path, monkeypatch):
    monkeypatch.setattr("dualcolor.bridge.pictures.views.TURNTABLE_FRAMES", 4)
    collection = build_preview(square_print(), cube)
    take_pictures(collection, {"turntable": tmp_path / "t.gif"}, PictureOptions(resolution=(24, 20), samples=1))
    with Image.open(tmp_path / "t.gif") as image:
        assert (image.n_frames, image.size) == (4, (24, 20))
    assert 360 % TURNTABLE_FRAMES == 0


def test_what_a_turning_object_needs_holds_it_at_every_angle():
    points = np.random.default_rng(1).normal(size=(500, 3)) * (9, 2, 5)
    ring = swept(points)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    reach = np.hypot(*(ring[:, :2] - middle[:2]).T)
    for point in points[::25]:
        same = np.abs(ring[:, 2] - point[2]) <= np.ptp(points[:, 2]) / 32 + 1e-9
        assert reach[same].max() >= np.hypot(*(point[:2] - middle[:2])) - 1e-9


def test_the_painted_model_stands_in_its_place_with_its_tones(cube):
    model = surface_model(cube, bpy.context.evaluated_depsgraph_get(), PrintSettings())
    made = painted_model(model, 0.5, 2.0)
    corners = np.array([vertex.co[:] for vertex in made.data.vertices])
    np.testing.assert_allclose(corners.max(axis=0), [2 * SIDE, 2 * SIDE, 2 * LAYERS * STEP], rtol=1e-6)
    assert {polygon.material_index for polygon in made.data.polygons} == {1}
    image = next(node.image for node in made.data.materials[1].node_tree.nodes if node.type == "TEX_IMAGE")
    assert image.pixels[0] == pytest.approx(1.0) and image.colorspace_settings.name == "Non-Color"


def test_new_strands_know_their_place_in_the_world(scene):
    use_millimeters(scene)
    rods = rods_of(build_preview(square_print()))
    assert np.ptp(rods.points[:, 2]) == pytest.approx((LAYERS - 1) * STEP, abs=1e-3)
    area = np.pi * rods.across * rods.up
    assert area == pytest.approx(np.full(len(area), 0.4 * STEP), rel=1e-3)


def test_the_operators(cube, tmp_path):
    dualcolor.register()
    try:
        collection = build_preview(square_print(), cube)
        with bpy.context.temp_override(object=collection.objects[0]):
            found = bpy.ops.dualcolor.render_prediction(
                filepath=str(tmp_path / "a.png"), width=24, height=24, samples=1, views={"FRONT", "BACK"},
                distance="HAND", azimuth=30.0, contact_sheet=True,
            )  # fmt: skip
            assert found == {"FINISHED"}
            assert bpy.ops.dualcolor.export_strands(filepath=str(tmp_path / "a.obj")) == {"FINISHED"}
    finally:
        dualcolor.unregister()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.obj", "a_back.png", "a_front.png", "a_sheet.png"]


@pytest.mark.parametrize(("typed", "given"), [("a", "a.stl"), ("a.obj", "a.obj"), ("a.fbx", "a.fbx"), ("", "")])
def test_a_mesh_without_a_suffix_becomes_an_stl_file(tmp_path, typed, given):
    operator = SimpleNamespace(filepath=f"{tmp_path}/{typed}", filename_ext=".stl")
    changed = render.DUALCOLOR_OT_export_strands.check(operator, None)
    assert operator.filepath == f"{tmp_path}/{given}" and changed == (typed != given)


def test_arguments(capsys):
    parser = cli.make_parser()
    args = parser.parse_args(["render", "f.gcode", "--views", "front,turntable", "--render", "a.png"])
    assert list(args.command.outputs(args)) == ["render front", "render turntable"]
    args = parser.parse_args(["print", "m.obj", "--views", "front"])
    with pytest.raises(OutputError, match="--views"):
        args.command.outputs(args)
    with pytest.raises(SystemExit):
        parser.parse_args(["print", "m.obj", "--views", "frnt"])
    assert "'frnt' is not one of" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["nan", "inf", "north"])
def test_an_azimuth_is_a_number_of_degrees(text, capsys):
    for command in ("print", "render", "analyze"):
        with pytest.raises(SystemExit):
            cli.make_parser().parse_args([command, "m.obj", "--azimuth", text])
        assert f"'{text}' is not an angle" in capsys.readouterr().err
    assert cli.make_parser().parse_args(["print", "m.obj", "--azimuth=-450"]).azimuth == -450.0

"""Add Calibration Tile and Read Calibration Photo, as the sidebar and the Image Editor run them."""

from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor.bridge.objects.calibration_tile import is_calibration_tile  # noqa: E402
from dualcolor.bridge.properties import to_settings  # noqa: E402
from dualcolor.bridge.units import use_millimeters  # noqa: E402
from dualcolor.core.calibration.calibrate import shipped_table  # noqa: E402
from dualcolor.core.calibration.step_wedge import wedge_plate, wedge_settings  # noqa: E402
from dualcolor.core.calibration.table import read_table  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.tests.scene import add_box, extent, model_of  # noqa: E402
from dualcolor.tests.wedge_photograph import developed, light_on_wedge, marks_in  # noqa: E402

CORNERS = np.array([(80.0, 100.0), (560.0, 60.0), (530.0, 360.0), (100.0, 310.0)])
SHAPE = (420, 640)


@pytest.fixture
def registered(scene):
    dualcolor.register()
    use_millimeters(scene)
    yield scene
    dualcolor.unregister()


@pytest.fixture
def photo(tmp_path):
    table = shipped_table(PrintSettings())
    light = light_on_wedge(
        SHAPE, CORNERS, lambda tone: np.interp(tone, table.tone, table.reflectance[0]), PrintSettings()
    )
    path = tmp_path / "tile.png"
    Image.fromarray(developed(light)).save(path, compress_level=1)
    return path


def test_the_tile_is_ready_to_print_with_the_active_objects_settings(registered):
    box = add_box()
    box.dualcolor.layer_height, box.dualcolor.wavelength = 0.2, 1.0
    assert bpy.ops.dualcolor.add_calibration_tile() == {"FINISHED"}
    tile = bpy.context.object
    assert is_calibration_tile(tile) and not is_calibration_tile(box)
    settings = to_settings(tile.dualcolor)
    assert settings == wedge_settings(to_settings(box.dualcolor))
    shape, picture = wedge_plate(settings)
    model = model_of(tile)
    np.testing.assert_allclose(extent(model), np.ptp(shape.vertices, axis=0), atol=1e-4)
    assert model.textures[0].tone == pytest.approx(picture.tone, abs=0.005)


def test_a_photograph_calibrates_the_active_object(registered, photo):
    box = add_box()
    assert bpy.ops.dualcolor.read_calibration_photo(filepath=str(photo)) == {"FINISHED"}
    settings = to_settings(box.dualcolor)
    assert settings.calibration == "file"
    table, base = read_table(photo.with_name("tile_tones.json")), shipped_table(PrintSettings())
    assert settings.calibration_file == str(photo.with_name("tile_tones.json"))
    assert table.reflectance[0] == pytest.approx(np.interp(table.tone, base.tone, base.reflectance[0]), abs=0.015)
    from dualcolor.panels.calibrate import table_words

    assert [icon for _, icon in table_words(box)] == ["CHECKMARK"] and "tile.png" in table_words(box)[0][0]
    box.dualcolor.offset_max = 0.3
    assert "offset_max 0.3 instead of 0.35" in table_words(box)[1][0]
    box.dualcolor.calibration = "none"
    assert "as they are" in table_words(box)[0][0]
    box.dualcolor.calibration, box.dualcolor.calibration_file = "file", "nowhere.json"
    assert table_words(box)[0][1] == "ERROR"


def test_the_tile_itself_stays_uncalibrated(registered, photo):
    bpy.ops.dualcolor.add_calibration_tile()
    assert bpy.ops.dualcolor.read_calibration_photo(filepath=str(photo)) == {"FINISHED"}
    assert bpy.context.object.dualcolor.calibration == "none"
    assert photo.with_name("tile_tones.json").exists()


def test_corners_may_be_given(registered, photo):
    add_box()
    corners = [float(each) for each in marks_in(CORNERS).ravel()]
    read = bpy.ops.dualcolor.read_calibration_photo
    assert read(filepath=str(photo), find_marks=False, corners=corners) == {"FINISHED"}
    photo.with_name("tile_tones.json").unlink()
    crossed = [*corners[:2], *corners[4:6], *corners[2:4], *corners[6:]]
    with pytest.raises(RuntimeError, match="cross"):
        read(filepath=str(photo), find_marks=False, corners=crossed)
    assert not photo.with_name("tile_tones.json").exists()


def test_four_clicks_in_the_image_editor_make_the_table(registered, photo):
    """The operator's own events, with a window's parts stood in for."""
    from dualcolor.operators.calibrate import DUALCOLOR_OT_click_calibration_photo as Clicks

    box, asked = add_box(), []
    image = bpy.data.images.load(str(photo))
    view = SimpleNamespace(region_to_view=lambda x, y: (x / SHAPE[1], y / SHAPE[0]))
    context = SimpleNamespace(
        object=box,
        space_data=SimpleNamespace(image=image),
        region=SimpleNamespace(view2d=view, width=SHAPE[1], height=SHAPE[0]),
        area=SimpleNamespace(type="IMAGE_EDITOR", tag_redraw=lambda: None),
        workspace=SimpleNamespace(status_text_set=asked.append),
        window_manager=SimpleNamespace(modal_handler_add=lambda operator: None),
    )
    said = []
    made = SimpleNamespace(report=lambda kind, text: said.append(text))
    for name in ("invoke", "modal", "cancel", "read", "_ask"):
        setattr(made, name, getattr(Clicks, name).__get__(made))

    def event(kind, x=0.0, y=0.0):
        return SimpleNamespace(type=kind, value="PRESS", mouse_region_x=x, mouse_region_y=y)

    assert made.invoke(context, None) == {"RUNNING_MODAL"} and "upper left" in asked[-1]
    marks = marks_in(CORNERS) + 3.0
    clicks = [event("LEFTMOUSE", x, SHAPE[0] - y) for x, y in marks]
    assert made.modal(context, event("WHEELUPMOUSE")) == {"PASS_THROUGH"}
    assert made.modal(context, event("LEFTMOUSE", -5.0, 20.0)) == {"PASS_THROUGH"}
    assert made.modal(context, clicks[1]) == {"RUNNING_MODAL"} and "upper right" in asked[-1]
    assert made.modal(context, event("BACK_SPACE")) == {"RUNNING_MODAL"} and "upper left" in asked[-1]
    for each in clicks[:3]:
        assert made.modal(context, each) == {"RUNNING_MODAL"}
    assert made.modal(context, clicks[3]) == {"FINISHED"} and asked[-1] is None
    assert box.dualcolor.calibration == "file" and "is calibrated by tile_tones.json" in said[-1]
    made.invoke(context, None)
    assert made.modal(context, event("ESC")) == {"CANCELLED"}
    made.invoke(context, None)
    context.area.type = "VIEW_3D"  # the editor was turned into another one
    assert made.modal(context, clicks[0]) == {"CANCELLED"}

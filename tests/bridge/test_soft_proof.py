"""The soft proof shows what the core says the print will show."""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.benchmarks.proof_picture import proof_picture  # noqa: E402
from dualcolor.bridge.input.image_input import image_tone  # noqa: E402
from dualcolor.bridge.measuring.instrument import Face  # noqa: E402
from dualcolor.bridge.objects.picture_objects import add_picture_object  # noqa: E402
from dualcolor.bridge.paint.painting import picture_of  # noqa: E402
from dualcolor.bridge.paint.unwrap import smart_project  # noqa: E402
from dualcolor.bridge.pictures.picture_print import picture_print  # noqa: E402
from dualcolor.bridge.proof.soft_proof import show_proof  # noqa: E402
from dualcolor.bridge.properties import to_settings  # noqa: E402
from dualcolor.core.analysis.soft_proof import TAPS, proof_table, proof_window, tone_range  # noqa: E402
from dualcolor.core.calibration.calibrate import table_for  # noqa: E402
from dualcolor.core.calibration.gamut_mapping import printable_tones  # noqa: E402
from dualcolor.core.model import ToneImage  # noqa: E402
from dualcolor.core.pattern.modulation import PERIOD_LAYERS  # noqa: E402
from dualcolor.core.pictures.match import averaged, correlation, in_pixels  # noqa: E402
from dualcolor.core.pictures.shapes import picture_plate  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.texture.decode import srgb_from_linear  # noqa: E402
from dualcolor.tests.scene import add_box, add_material, add_mesh, add_uvs, flat_image, fresh, model_of  # noqa: E402
from mathutils import Matrix  # noqa: E402


def picture(tone, name="picture"):
    """An sRGB image of tones (H, W), row 0 at the bottom."""
    tone = np.asarray(tone, dtype=np.float64)
    image = bpy.data.images.new(name, tone.shape[1], tone.shape[0], alpha=True, float_buffer=False)
    pixels = np.ones((*tone.shape, 4), dtype=np.float32)
    pixels[..., :3] = srgb_from_linear(tone)[..., None]
    image.pixels.foreach_set(pixels.ravel())
    return image


def leaning_wall(slant_deg, width, height, to_uv):
    """A face about the origin that looks to the front, leaning back; its UVs are `to_uv` of mm across and up."""
    slant = math.radians(slant_deg)
    across, up = np.array([1.0, 0, 0]), np.array([0, math.sin(slant), math.cos(slant)])
    flat = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [width / 2, height / 2]
    wall = add_mesh(flat[:, :1] * across + flat[:, 1:] * up, [(0, 1, 2, 3)], "wall")
    add_uvs(wall, to_uv(flat))
    return wall, Face((0.0, 0.0, 0.0), width, height, slant_deg)


def filling(size):
    return lambda flat: flat / size + 0.5


def expected(table, tone, slant_deg):
    """Read off the table between its four nearest entries."""
    rows = [np.interp(tone, table.tone, row) for row in table.reflectance]
    return float(np.interp(slant_deg, table.slant_deg, rows))


@pytest.mark.parametrize("slant", [-25, 0, 33, 57])
def test_nodes_show_what_the_table_says(registered, slant):
    tones = np.array([0.0, 0.1, 0.3, 0.6, 0.85, 1.0])
    wall, face = leaning_wall(slant, 30, 20, filling([30, 20]))
    add_material(wall, picture(np.tile(np.repeat(tones, 20), (4, 1))))
    wall.dualcolor.calibration = "none"  # so that slopes differ
    bpy.ops.dualcolor.soft_proof()
    seen = proof_picture(wall, face, 1.0, samples=2)
    table = proof_table(to_settings(wall.dualcolor), (0.0, 1.0))
    wanted = [expected(table, tone, max(slant, 0)) for tone in tones]
    np.testing.assert_allclose(seen[10, 2::5], wanted, atol=0.01)


def test_what_is_too_flat_is_marked(registered):
    shown = {}
    for slant in (55, 65, 75):
        fresh()
        wall, face = leaning_wall(slant, 12, 12, filling([12, 12]))
        add_material(wall, picture(np.ones((4, 4))))
        bpy.ops.dualcolor.soft_proof()
        shown[slant] = proof_picture(wall, face, 0.5, samples=2)
    even = shown[55].mean()
    assert np.ptp(shown[55]) < 0.01
    assert 0.3 < (np.abs(shown[65] - even) < 0.02).mean() < 0.7  # stripes, and gaps between them
    assert (np.abs(shown[75] - even) < 0.02).mean() < 0.1


def blurred_step(distance, window):
    """Share of the taps beyond a step, for places that far before it (negative: beyond)."""
    taps = ((np.arange(TAPS) + 0.5) / TAPS - 0.5) * window
    return (distance[:, None] + taps > 0).mean(axis=1)


@pytest.mark.parametrize("unit", [1.0, 1000.0])
@pytest.mark.parametrize("upward", [False, True])
def test_window_is_as_wide_and_high_as_the_print_is_fine(registered, unit, upward):
    settings = PrintSettings().changed({"pattern": "wave", "wavelength": 3.0, "layer_height": 0.5})
    window = proof_window(settings)[1 if upward else 0]
    turn = np.array([[0.8, 0.6], [-0.6, 0.8]])  # the chart lies askew in the picture
    side, slant = 12.0, 50.0
    wall, face = leaning_wall(slant, 8, 8, lambda flat: flat @ turn.T / side + 0.5)
    # The picture is white where the wall is right of, or above, its middle.
    place = (np.arange(384) + 0.5) / 384 * side - side / 2
    u, v = np.meshgrid(place, place)
    flat = np.stack([u, v], axis=-1) @ turn
    image = picture((flat[..., 1 if upward else 0] > 0).astype(float))
    add_material(wall, image)
    if unit != 1.0:
        bpy.context.scene.unit_settings.scale_length = 1.0
        wall.scale = (1 / unit,) * 3
        bpy.context.view_layer.update()
        face = Face((0, 0, 0), face.width / unit, face.height / unit, slant)
    show_proof(wall, settings)
    seen = proof_picture(wall, face, 0.1 / unit, samples=2)
    profile = seen.mean(axis=1)[::-1] if upward else seen.mean(axis=0)
    distance = (np.arange(len(profile)) + 0.5) * 0.1 - 4.0
    table = proof_table(settings, (0.0, 1.0))
    high = window / math.cos(math.radians(slant)) if upward else window
    wanted = [expected(table, tone, slant) for tone in blurred_step(distance, high)]
    away = np.abs(np.abs(distance)[:, None] - np.array([0, high / 3])).min(axis=1) > 0.1  # not astride a step
    np.testing.assert_allclose(profile[away], np.array(wanted)[away], atol=0.01)


def test_vertex_colors_and_plain_materials_are_proofed_too(registered):
    wall, face = leaning_wall(0, 10, 10, filling([10, 10]))
    colors = wall.data.color_attributes.new("Col", "FLOAT_COLOR", "CORNER")
    colors.data.foreach_set("color", np.tile([0.25, 0.25, 0.25, 1.0], 4))
    bpy.ops.dualcolor.soft_proof()
    table = proof_table(to_settings(wall.dualcolor), (0.25, 0.25))
    assert proof_picture(wall, face, 1.0, samples=1).mean() == pytest.approx(expected(table, 0.25, 0), abs=0.01)
    bpy.ops.dualcolor.soft_proof()
    assert not wall.data.materials
    wall.data.color_attributes.remove(wall.data.color_attributes[0])
    bpy.ops.dualcolor.soft_proof()
    table = proof_table(to_settings(wall.dualcolor), (0.5, 0.5))
    assert proof_picture(wall, face, 1.0, samples=1).mean() == pytest.approx(expected(table, 0.5, 0), abs=0.01)


def test_unpainted_parts_have_the_background_tone(registered):
    wall, face = leaning_wall(0, 10, 10, filling([10, 10]))
    add_material(wall, flat_image((1, 1, 1, 0)))
    wall.dualcolor.background_tone = 0.3
    bpy.ops.dualcolor.soft_proof()
    table = proof_table(to_settings(wall.dualcolor), (0.3, 0.3))
    assert proof_picture(wall, face, 1.0, samples=1).mean() == pytest.approx(expected(table, 0.3, 0), abs=0.01)


@pytest.mark.parametrize("tone", [0.0, 1.0])
@pytest.mark.parametrize("size", [8.0, 20.0])
def test_no_other_chart_shows_along_the_borders_of_one_that_was_unwrapped_here(registered, size, tone):
    """One side has a tone, all others another one; strokes go on beyond all of them as Set Up Painting has it."""
    box = add_box((size, size, size))
    box.data.transform(Matrix.Translation((-size / 3, -size / 2, -size / 4)))  # so that no charts meet by chance
    smart_project(box)
    bpy.ops.dualcolor.set_up_painting()
    texels = picture_of(box).size[0]
    uv = np.array([each.vector for each in box.data.uv_layers.active.uv]).reshape(6, 4, 2) * texels
    place = np.stack(np.meshgrid(*[np.arange(texels) + 0.5] * 2), axis=-1)
    beyond = np.maximum(uv.min(axis=1) - place[..., None, :], place[..., None, :] - uv.max(axis=1)).max(axis=-1)
    front = next(face for face in box.data.polygons if face.normal.y < -0.9)
    bleed = bpy.context.scene.tool_settings.image_paint.seam_bleed
    mine = (beyond.argmin(axis=-1) == front.index) & (beyond[..., front.index] < bleed)
    picture_of(box).pixels.foreach_set(picture(np.where(mine, tone, 1 - tone)).pixels[:])
    bpy.ops.dualcolor.soft_proof()
    seen = proof_picture(box, Face(tuple(front.center), size, size, 0.0), 0.05, samples=2)
    inner = seen[1:-1, 1:-1]  # beside the silhouette the camera sees a part of a pixel
    assert np.nanmax(inner) - np.nanmin(inner) < 0.01


def test_table_is_that_of_the_job_and_says_when_settings_differ():
    settings = PrintSettings()
    made = proof_table(settings, (0.2, 0.7))
    same = printable_tones(made.tone, made.slant_deg, table_for(settings), (0.2, 0.7), settings).seen
    inside = (made.tone > 0.2) & (made.tone < 0.7)
    np.testing.assert_allclose(made.reflectance[:, inside], same[:, inside])
    assert not made.notes
    # A stroke beyond the picture's own range is seen: darker, or lighter, than all there was.
    narrow = proof_table(settings, (0.4, 0.6)).reflectance[0]
    assert narrow[0] < narrow[26] < narrow[39] < narrow[64] and (np.diff(narrow) >= 0).all()
    uncalibrated = proof_table(settings.changed({"calibration": "none"}), (0.0, 1.0))
    table = table_for(settings)
    np.testing.assert_allclose(uncalibrated.reflectance[0], np.interp(made.tone, table.tone, table.reflectance[0]))
    assert "offset_max" in proof_table(settings.changed({"offset_max": 0.2}), (0, 1)).notes[0]


def test_range_is_that_of_the_surface_at_the_resolution_of_the_print(registered):
    box = add_box((10, 10, 10))
    layer = add_uvs(box)
    fine = np.where(np.add.outer(np.arange(512), np.arange(512)) % 2, 1.0, 0.0)  # 0.02 mm
    fine[:, :128] = 0.25
    image = picture(fine)
    uv = np.tile([[0.05, 0], [1, 0], [1, 1], [0.05, 1]], (6, 1))
    layer.uv.foreach_set("vector", uv.astype(np.float32).ravel())
    low, high = tone_range(model_of(box, image), PrintSettings())
    assert low == pytest.approx(0.25, abs=0.01) and high < 0.7
    assert image_tone(image).tone.max() == 1.0


def test_proof_predicts_the_print(registered):
    """A small picture on a plate: what the proof shows is what the strands show, in their own tones."""
    settings = PrintSettings()
    plate = picture_plate(10.0, 10.0, 2.0, settings)
    x, y = np.meshgrid(np.linspace(-1, 1, plate.columns), np.linspace(-1, 1, plate.rows))
    tone = np.clip(0.5 + 0.45 * np.sin(3 * x + 2 * y) * np.cos(2 * x - 3 * y), 0, 1).astype(np.float32)
    image = ToneImage(tone, np.ones_like(tone))
    made = picture_print(image, plate, settings, "wavy", 0.1, samples=2)
    obj = add_picture_object(image, plate, "wavy", settings)
    bpy.context.view_layer.update()
    show_proof(obj, settings)
    width, height = plate.size
    shown = proof_picture(obj, Face((0.0, float(plate.vertices[:, 1].min()), height / 2), width, height), 0.1, 2)
    window = in_pixels((PERIOD_LAYERS * settings.layer_height, made.match.period_mm), 0.1)
    inner = tuple(slice(size, -size) for size in window)
    proof, printed = (averaged(each.astype(float), window)[inner] for each in (shown, made.photograph))
    assert correlation(proof, printed) > 0.97
    assert np.abs(proof - printed).mean() < 0.02

"""Photographs of the printed calibration tile: the tile, its marks, the table that is read off."""

from dataclasses import replace

import numpy as np
import pytest
from dualcolor.cli import main
from dualcolor.core.calibration.calibrate import shipped_table
from dualcolor.core.calibration.homography import is_clockwise, projected, square_to
from dualcolor.core.calibration.marks import checked_corners, find_marks
from dualcolor.core.calibration.photo_table import patch_means, read_wedge
from dualcolor.core.calibration.photograph import Photograph, read_photograph
from dualcolor.core.calibration.read_photo import table_of_photo
from dualcolor.core.calibration.step_wedge import (
    COLUMNS,
    MARKS,
    ROWS,
    STEPS,
    patch_tones,
    patches,
    references,
    wedge_plate,
    wedge_settings,
)
from dualcolor.core.calibration.table import read_table, write_table
from dualcolor.core.errors import CalibrationError, PrintError
from dualcolor.core.pictures.shapes import surface_of
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.settings.presets import preset_values
from dualcolor.tests.wedge_photograph import developed, light_on_wedge, marks_in
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

DEFAULT = PrintSettings()
TILTED = np.array([(100.0, 120.0), (690.0, 70.0), (660.0, 440.0), (130.0, 380.0)])
SHAPE = (500, 780)


def simulated(tone, settings=DEFAULT):
    table = shipped_table(settings)
    return np.interp(tone, table.tone, table.reflectance[0])


def faded(tone):
    """A print that is not as the simulation says: white spreads."""
    return 0.1 + 0.4 * np.asarray(tone) ** 0.6


def photo_of(tmp_path, response=simulated, corners=TILTED, shape=SHAPE, settings=DEFAULT, name="photo.png", **light):
    path = tmp_path / name
    Image.fromarray(developed(light_on_wedge(shape, corners, response, settings, **light))).save(path, compress_level=1)
    return path


# The tile


def test_patches_are_whole_periods_and_the_wedge_is_complete():
    tone = patch_tones()
    white, black = references()
    steps = tone[~(white | black | np.isnan(tone))]
    assert tone.shape == (ROWS, COLUMNS) and np.isnan(tone).sum() == 4
    assert np.sort(steps) == pytest.approx(np.linspace(0, 1, STEPS)[1:-1])
    assert min(white.sum(), black.sum()) >= 10  # six unknowns of the light's fall-off are found from each
    for settings in (DEFAULT, PrintSettings(layer_height=0.2, wavelength=1.0), PrintSettings(first_layer_height=0.3)):
        size = patches(settings)
        assert size.height / (4 * settings.layer_height) == pytest.approx(6)
        assert size.width >= 6 * settings.wavelength - 1e-9
        plate, picture = wedge_plate(settings)
        border = plate.frame
        inner = picture.tone[border:-border, border:-border]
        assert picture.tone.shape == (plate.rows, plate.columns)
        assert inner.shape[0] % (2 * ROWS) == 0 and inner.shape[1] % COLUMNS == 0
        middle = inner[inner.shape[0] // 10 :: inner.shape[0] // 5, inner.shape[1] // 18 :: inner.shape[1] // 9][::-1]
        assert np.where(np.isnan(tone), middle, tone) == pytest.approx(middle)


@pytest.mark.parametrize("preset", ["set_back", "paper"])
def test_the_tile_prints_each_step_with_its_own_modulation(preset):
    settings = wedge_settings(DEFAULT.changed(preset_values([preset]) | {"solid_regions": "set_back"}))
    assert settings.calibration == "none" and settings.brim_width > 0
    plate, picture = wedge_plate(settings)
    model = surface_of(plate, picture, 0.5, "Tile")
    outlines = generate(model, settings.changed({"tower_type": "none", "infill_density": 0.0})).outlines
    size, frame = patches(settings), plate.frame * 2 * settings.layer_height
    layer = np.repeat(outlines.layer, np.diff(outlines.start))
    x = (outlines.base[:, 0] + plate.size[0] / 2 - frame) / size.width
    y = (plate.size[1] - frame - (layer + 0.5) * settings.layer_height) / size.height
    off = np.abs(np.stack([x % 1 - 0.5, y % 1 - 0.5]))
    front = (outlines.base[:, 1] < -1.5) & (np.abs(x - COLUMNS / 2) < COLUMNS / 2) & (np.abs(y - ROWS / 2) < ROWS / 2)
    read = front & (off[0] < size.read_width / size.width / 2) & (off[1] < 4 / 12)
    asked = patch_tones()[y[read].astype(int), x[read].astype(int)]
    inner = ~np.isnan(asked)
    assert inner.sum() > 40  # lines that are straight have few points
    assert outlines.tone[read][inner] == pytest.approx(asked[inner], abs=0.01)
    if preset == "set_back":
        back, black = outlines.set_back[read][inner], layer[read][inner] % 2 == 0
        wanted = np.where(black, 2 * asked[inner] - 1, 1 - 2 * asked[inner]).clip(0, 1) * settings.offset_max
        assert back == pytest.approx(wanted, abs=0.01)


# Geometry


@given(st.lists(st.floats(-0.2, 0.2), min_size=8, max_size=8))
def test_four_corners_are_taken_to_the_square_and_back(shifts):
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    corners = square + np.reshape(shifts, (4, 2))
    matrix = square_to(corners)
    assert projected(matrix, square) == pytest.approx(corners, abs=1e-9)
    assert is_clockwise(corners) and not is_clockwise(corners[::-1]) and not is_clockwise(corners[[0, 2, 1, 3]])
    line = projected(matrix, np.array([(0.1, 0.2), (0.3, 0.4), (0.7, 0.8)]))  # straight lines stay straight
    assert np.linalg.det(np.diff(line, axis=0)) == pytest.approx(0.0, abs=1e-9)
    assert projected(np.linalg.inv(matrix), line) == pytest.approx(np.array([(0.1, 0.2), (0.3, 0.4), (0.7, 0.8)]))


@pytest.mark.parametrize("turn", range(4))
def test_marks_are_found_however_the_tile_lies(tmp_path, turn):
    corners, shape = TILTED, SHAPE
    for _ in range(turn):
        corners, shape = np.stack([shape[0] - corners[:, 1], corners[:, 0]], axis=1), shape[::-1]
    photo = read_photograph(photo_of(tmp_path, corners=corners, shape=shape, contrast=0.2))
    assert find_marks(photo, DEFAULT) == pytest.approx(marks_in(corners), abs=1.5)


def test_marks_are_found_in_the_faint_contrast_of_the_papers_pattern(tmp_path):
    settings = DEFAULT.changed(preset_values(["paper"]))
    path = photo_of(tmp_path, lambda tone: simulated(tone, settings), settings=settings, fall_off=1.0)
    assert find_marks(read_photograph(path), settings) == pytest.approx(marks_in(TILTED), abs=3.0)


@pytest.mark.parametrize("turn", [0, 3])
def test_rough_clicks_are_moved_onto_the_marks(tmp_path, turn):
    photo = read_photograph(photo_of(tmp_path))
    clicks = np.roll(marks_in(TILTED), turn, axis=0) + np.array([(9, -7), (-11, 5), (4, 10), (-12, -3)])
    assert checked_corners(photo, clicks, DEFAULT) == pytest.approx(marks_in(TILTED), abs=1.0)


# The table


@pytest.mark.parametrize("response", [simulated, faded], ids=["as simulated", "otherwise"])
def test_a_photograph_gives_the_response_back(tmp_path, response):
    path = photo_of(tmp_path, response, fall_off=1.0, veil=0.02)
    ends = tuple(response(np.array([0.0, 1.0])))
    made = table_of_photo(path, DEFAULT, ends=ends)
    assert made.table.reflectance[0] == pytest.approx(response(made.table.tone), abs=0.008)
    assert (np.diff(made.table.reflectance, axis=1) >= 0).all()
    assert not made.notes and made.table.provenance.settings == shipped_table(DEFAULT).provenance.settings
    assert made.table.noise.max() < 0.02
    assert made.marks == pytest.approx(marks_in(TILTED), abs=1.0)


def test_slopes_are_the_simulation_corrected_by_what_the_upright_wall_shows(tmp_path):
    base = shipped_table(DEFAULT)
    rows = np.stack([np.interp(np.linspace(0, 1, STEPS), base.tone, row) for row in base.reflectance])
    marks = marks_in(TILTED)
    same = table_of_photo(photo_of(tmp_path), DEFAULT, marks).table
    assert same.slant_deg == pytest.approx(base.slant_deg)
    assert same.reflectance == pytest.approx(rows, abs=0.02)
    lighter = table_of_photo(photo_of(tmp_path, faded), DEFAULT, marks, ends=(0.1, 0.5)).table
    assert lighter.reflectance[3, 8] - rows[3, 8] == pytest.approx(
        (faded(0.4) - rows[0, 8]) * (rows[3, -1] - rows[3, 0]) / (rows[0, -1] - rows[0, 0]), abs=0.015
    )


def test_an_own_simulation_may_take_the_place_of_the_programs(tmp_path):
    base = shipped_table(DEFAULT)
    own = replace(base, reflectance=base.reflectance / 2 + 0.1)
    write_table(tmp_path / "own.json", own)
    made = table_of_photo(photo_of(tmp_path), DEFAULT, marks_in(TILTED), simulated=tmp_path / "own.json").table
    assert made.reflectance[0, [0, -1]] == pytest.approx(own.reflectance[0, [0, -1]], abs=1e-4)


def test_other_settings_than_the_simulations_give_the_upright_wall_alone(tmp_path):
    settings = DEFAULT.changed({"offset_max": 0.3})
    made = table_of_photo(photo_of(tmp_path), settings, marks_in(TILTED))
    assert made.table.slant_deg.tolist() == [0.0]
    assert any("upright wall alone" in note and "offset_max" in note for note in made.notes)
    assert not made.table.provenance.differences(settings)


def test_patches_are_averaged_as_they_are_and_not_as_they_are_seen():
    """From close by at a slant the nearer half of a patch has more pixels; light that rises evenly across tells."""
    marks = np.array([(100.0, 150.0), (1300.0, 450.0), (1300.0, 750.0), (100.0, 1050.0)])
    row, column = np.indices((1200, 1400))
    pixel = np.stack([column.ravel(), row.ravel()], axis=1) + 0.5
    place = projected(np.linalg.inv(square_to(marks)), pixel) * (MARKS[2] - MARKS[0]) + MARKS[0]
    photo = Photograph((1.0 + place[:, 0]).reshape(row.shape).astype(np.float32), np.zeros(row.shape, dtype=bool))
    mean, _ = patch_means(photo, marks, patches(DEFAULT))
    np.testing.assert_allclose(mean[1:-1, 1:-1], np.broadcast_to(1.5 + np.arange(1, COLUMNS - 1), (3, 7)), atol=2e-3)


def test_blobs_on_a_patch_do_not_count(tmp_path):
    light = light_on_wedge(SHAPE, TILTED, simulated, DEFAULT)
    marks, size = marks_in(TILTED), patches(DEFAULT)
    clean, _ = patch_means(Photograph(light.astype(np.float32), light > 9), marks, size)
    x, y = projected(square_to(marks), (np.array([(4.5, 1.3)]) - MARKS[0]) / (MARKS[2] - MARKS[0]))[0].astype(int)
    light[y - 3 : y + 3, x - 16 : x - 5] = 0.9
    stained, _ = patch_means(Photograph(light.astype(np.float32), light > 9), marks, size)
    assert stained == pytest.approx(clean, rel=0.03)


def test_a_photograph_turned_by_its_camera_is_read_like_any_other(tmp_path):
    path = photo_of(tmp_path, name="photo.jpg")
    with Image.open(path) as image:
        exif = image.getexif()
        exif[0x0112] = 6
        image.save(tmp_path / "turned.jpg", exif=exif, quality=95)
    turned = table_of_photo(tmp_path / "turned.jpg", DEFAULT)
    stored = table_of_photo(tmp_path / "turned.jpg", DEFAULT, as_stored=True)
    assert turned.table.reflectance == pytest.approx(stored.table.reflectance, abs=0.01)
    assert turned.marks[:, 1] == pytest.approx(stored.marks[:, 0], abs=1.0)


# What can go wrong


def test_troubles_are_told_in_a_sentence(tmp_path):
    def told(path, corners=None, settings=DEFAULT):
        with pytest.raises(PrintError) as problem:
            table_of_photo(path, settings, corners)
        assert "\n" not in str(problem.value) and not str(problem.value).endswith(".")
        return str(problem.value)

    path, marks = photo_of(tmp_path), marks_in(TILTED)
    assert "cross or run counterclockwise" in told(path, marks[[0, 2, 1, 3]])
    assert "cross or run counterclockwise" in told(path, marks[::-1])
    assert "outside" in told(path, marks + 500)
    assert "cannot be read" in told(tmp_path / "nowhere.png")
    (tmp_path / "text.png").write_text("no picture")
    assert "cannot be read" in told(tmp_path / "text.png")
    Image.fromarray(np.zeros((40, 40), dtype=np.uint16)).save(tmp_path / "deep.png")
    assert "more than 8 bits" in told(tmp_path / "deep.png")
    noise = np.random.default_rng(1).integers(0, 255, (300, 400, 3), dtype=np.uint8)
    Image.fromarray(noise).save(tmp_path / "noise.png")
    assert "marks were not found" in told(tmp_path / "noise.png")
    Image.new("RGB", (500, 400), (128, 128, 128)).save(tmp_path / "plain.png")
    assert "marks were not found" in told(tmp_path / "plain.png")
    plain = light_on_wedge(SHAPE, TILTED, lambda tone: 0.3 + 0.002 * tone, DEFAULT, contrast=0.0)
    with pytest.raises(CalibrationError, match="look alike"):
        read_wedge(Photograph(plain.astype(np.float32), plain > 9), marks, DEFAULT)
    assert "not seen between the corners" in told(path, marks * (0.5, 0.5))
    assert "overexposed" in told(photo_of(tmp_path, lambda tone: 0.5 + 1.5 * tone), marks)
    small = photo_of(tmp_path, corners=TILTED / 6, shape=(120, 170), contrast=0.0)
    assert "too small" in told(small, marks_in(TILTED / 6))


def test_glare_and_a_bad_print_are_noted(tmp_path):
    light = light_on_wedge(SHAPE, TILTED, simulated, DEFAULT, contrast=0.0)
    row, column = np.indices(SHAPE)
    glare = 0.1 * np.exp(-((column - 500) ** 2 + (row - 150) ** 2) / 3000)
    photo = Photograph((light + glare).astype(np.float32), light > 9)
    assert any("from place to place" in note for note in read_wedge(photo, marks_in(TILTED), DEFAULT).notes)

    def swapped(tone):
        return np.where((tone > 0.6) & (tone < 0.9), 0.3, simulated(tone))

    made = table_of_photo(photo_of(tmp_path, swapped, contrast=0.0), DEFAULT, marks_in(TILTED))
    assert any("get darker" in note for note in made.notes)


# The command


def test_the_command_reads_a_photograph(tmp_path, capsys):
    path, out = photo_of(tmp_path), tmp_path / "own.json"
    assert main(["read-photo", str(path), "--out", str(out)]) == 0
    said = capsys.readouterr().out
    assert "corner marks at" in said and "own.json" in said
    assert read_table(out).reflectance[0] == pytest.approx(simulated(read_table(out).tone), abs=0.01)
    corners = [f"{x:.0f},{y:.0f}" for x, y in marks_in(TILTED)]
    given_out = tmp_path / "given.json"
    assert main(["read-photo", str(path), "--out", str(given_out), "--black", "0.2", "--white", "0.6", "--corners",
                 *corners]) == 0  # fmt: skip
    assert read_table(given_out).reflectance[0, [0, -1]] == pytest.approx([0.2, 0.6], abs=1e-4)
    assert main(["read-photo", str(path), "--out", str(out), "--corners", *corners[::-1]]) == 1
    assert "counterclockwise" in capsys.readouterr().err
    assert main(["read-photo", str(path), "--out", str(out), "--corners", "1,2"]) == 2
    assert main(["read-photo", str(path), "--out", str(out), "--black", "0.6", "--white", "0.2"]) == 1
    assert main(["read-photo", str(path), "--out", str(out), "--white", "0.2"]) == 1


def test_a_table_that_is_read_is_used(tmp_path):
    path, out = photo_of(tmp_path, faded), tmp_path / "own.json"
    assert main(["read-photo", str(path), "--out", str(out), "--black", "0.1", "--white", "0.5"]) == 0
    settings = PrintSettings(calibration="file", calibration_file=str(out))
    from dualcolor.tests.core.calibration.tone_tables import calibrated

    asked = np.linspace(0, 1, 101)
    printed, notes = calibrated(asked, np.zeros(101), settings)
    assert not notes
    assert np.interp(printed, read_table(out).tone, faded(read_table(out).tone)) == pytest.approx(
        0.1 + 0.4 * asked, abs=0.02
    )
    with pytest.raises(CalibrationError):
        calibrated(asked, np.zeros(101), settings.changed({"calibration_file": str(path)}))

"""Tone calibration without Blender: tile, readings, table, and the tables that come with the program."""

import json
from dataclasses import fields, replace

import numpy as np
import pytest
from dualcolor.core.calibration.calibrate import shipped_table
from dualcolor.core.calibration.gamut_maps import gamut_maps, one_map
from dualcolor.core.calibration.provenance import tone_settings
from dualcolor.core.calibration.readings import read_tones
from dualcolor.core.calibration.sweep import Sweep, angles_of, read_sweep, read_sweeps, sweep_path, write_sweep
from dualcolor.core.calibration.table import isotonic, read_table, table_of, write_table
from dualcolor.core.calibration.tile import gradient_tile, profile_tile, step_tile
from dualcolor.core.contours.slant import face_slant_deg
from dualcolor.core.errors import CalibrationError
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.settings.presets import preset_values
from dualcolor.tests.core.calibration.tone_tables import DEFAULT, PROVENANCE, TONE, calibrated, inverse, table
from dualcolor.tests.solids import cylinder
from hypothesis import given
from hypothesis import strategies as st

# Tile and readings


@pytest.mark.parametrize("slant", [0.0, 30.0, 80.0])
def test_tile_leans_back_and_shows_its_tones_where_it_says(slant):
    tile = gradient_tile(slant, 0.25, 25, 4.8)
    result = generate(tile.model, PrintSettings(pattern="wave", tower_type="none", skirts=0, calibration="none"))
    assert face_slant_deg(result.mesh).tolist().count(pytest.approx(slant)) >= 2
    assert all("will not show" in warning for warning in result.warnings)  # on the flattest tile
    right, up = np.array([1.0, 0.0, 0.0]), np.array([0, np.sin(np.radians(slant)), np.cos(np.radians(slant))])
    center = result.mesh.bounds[0] + tile.center
    outline = result.outlines
    z = result.slices.layers.plane[np.repeat(outline.layer, np.diff(outline.start))]
    off = np.column_stack([outline.base, z]) - center
    x, y = off @ right, off @ up
    on_face = (np.abs(y) < tile.height / 2) & (np.abs(x) < tile.width / 2) & (np.abs(off @ np.cross(right, up)) < 0.3)
    assert on_face.sum() > 300
    asked = np.clip(x[on_face] / 60 + 0.5, 0, 1)
    assert outline.tone[on_face] == pytest.approx(asked, abs=0.02)
    assert tile.tone == pytest.approx(np.linspace(0, 1, 25))
    assert tile.place[1:-1] == pytest.approx((tile.tone[1:-1] - 0.5) * 60)
    # Whole periods of the pattern, black, white and both phases, lie in the part that is measured.
    periods = tile.height * np.cos(np.radians(slant)) / (4 * 0.25)
    assert periods == pytest.approx(round(periods)) and periods >= 2


def test_steps_and_profiles():
    steps = step_tile(0.0, 0.25, np.array([0.2, 0.9]))
    picture = steps.model.textures[0].tone[0]
    middle = len(picture) // 2
    assert picture[middle - 1] == pytest.approx(0.2) and picture[middle] == pytest.approx(0.9)
    assert steps.place == pytest.approx([-3, 3])
    profile = profile_tile(0.0, 0.25, np.array([1.0, 0.0, 0.5]), 20.0)
    assert profile.place == pytest.approx([-10, 0, 10])
    assert np.interp(-5, np.linspace(-15, 15, 300), profile.model.textures[0].tone[0]) == pytest.approx(0.5, abs=0.02)


def test_a_pattern_averages_out_and_the_noise_is_told():
    random = np.random.default_rng(3)
    at = (np.arange(600) + 0.5 - 300) * 0.1
    wave = 0.3 * np.cos(2 * np.pi * at / 1.2) * np.array([1, 1, -1, -1] * 10)[:, None]
    true = 0.4 + 0.005 * at + wave
    first, second = (np.float32(true + random.normal(scale=0.2, size=true.shape)) for _ in range(2))
    place = np.linspace(-25, 25, 21)
    mean, error = read_tones(first, second, 0.1, place, 4.8)
    assert error == pytest.approx(0.2 / np.sqrt(2) * np.sqrt(1 / (24 * 40) * 2 / 3), rel=0.1)
    assert np.abs(mean - (0.4 + 0.005 * place)).max() < 4 * error.max()
    assert (mean - 0.4 - 0.005 * place).std() == pytest.approx(error.mean(), rel=0.5)
    first[:, :100] = np.nan
    gone, _ = read_tones(first, second, 0.1, np.array([-27.0, 10.0]), 4.8)
    assert np.isnan(gone[0]) and np.isfinite(gone[1])


# Table


@given(st.lists(st.floats(0, 1), min_size=1, max_size=30))
def test_isotonic_ascends_keeps_the_mean_and_is_the_nearest(values):
    values = np.array(values)
    fit = isotonic(values)
    assert (np.diff(fit) >= 0).all()
    assert fit.mean() == pytest.approx(values.mean(), abs=1e-9)
    assert isotonic(np.sort(values)) == pytest.approx(np.sort(values))
    other = np.maximum.accumulate(values)
    assert ((fit - values) ** 2).sum() <= ((other - values) ** 2).sum() + 1e-9


def test_the_surest_reading_of_a_slope_counts(tmp_path):
    def sweep(slant, block, level, noise):
        angle = np.array(angles_of(block))[:, 1 if block == "theta" else 0]
        seen = np.repeat(TONE[:, None] * level, len(angle), axis=1)
        return Sweep(slant, block, angle, TONE, seen, np.full(seen.shape, noise), PROVENANCE)

    sweeps = [sweep(30, "phi", 0.5, 0.1), sweep(30, "face", 0.6, 0.01), sweep(0, "theta", 0.7, 0.1)]
    for each in sweeps:
        write_sweep(sweep_path(tmp_path, each.slant_deg, each.block), each)
    found = read_sweeps(tmp_path)
    assert [(each.slant_deg, each.block) for each in found] == [(0, "theta"), (30, "face"), (30, "phi")]
    made = table_of(found)
    assert made.slant_deg.tolist() == [0, 30]
    assert made.reflectance[:, -1] == pytest.approx([0.7, 0.6])
    page = gamut_maps(found)
    assert page.size[1] > 2 * len(TONE)
    assert one_map(found[0]).size == (17 * 14, len(TONE) * 7)
    write_sweep(sweep_path(tmp_path, 40, "phi"), replace(sweeps[0], provenance=replace(PROVENANCE, source="another")))
    with pytest.raises(CalibrationError, match="different settings"):
        read_sweeps(tmp_path)
    broken = tmp_path / "slant_50_phi.npz"
    broken.write_bytes(b"PK\x03\x04 no")
    with pytest.raises(CalibrationError, match="holds no readings"):
        read_sweep(broken)
    with pytest.raises(CalibrationError, match="holds no readings"):
        read_sweeps(tmp_path / "nothing")


@pytest.mark.parametrize(
    "wrong",
    [
        {"angle_deg": np.array([10.0])},
        {"angle_deg": np.array([0.0, 10.0])},
        {"block": "psi"},
        {"tone": TONE[::-1]},
        {"tone": TONE[:-1]},
        {"noise": np.zeros((1, 1))},
        {"slant_deg": np.nan},
    ],
)
def test_readings_that_are_inconsistent_are_refused(tmp_path, wrong):
    seen = TONE[:, None] / 2
    sweep, path = Sweep(0.0, "face", np.zeros(1), TONE, seen, np.zeros_like(seen), PROVENANCE), tmp_path / "a.npz"
    write_sweep(path, sweep)
    assert np.array_equal(read_sweep(path).reflectance, seen)
    write_sweep(path, replace(sweep, **wrong))
    with pytest.raises(CalibrationError, match="holds no readings"):
        read_sweep(path)


def test_table_survives_a_file(tmp_path):
    path = tmp_path / "table.json"
    made = table(TONE**2, 0.2 + TONE / 2)
    write_table(path, made)
    read = read_table(path)
    assert read.provenance == made.provenance
    for name in ("tone", "slant_deg", "reflectance", "noise"):
        assert getattr(read, name) == pytest.approx(getattr(made, name), abs=1e-5)


@pytest.mark.parametrize(
    "change",
    [
        {"format": "soup"},
        {"version": 9},
        {"tone": [0.0]},
        {"tone": "x"},
        {"slant_deg": [30.0, 0.0]},
        {"reflectance": [[0.5] * 10 + [0.1]] * 2},
        {"reflectance": [[float("nan")] * 11] * 2},
        {"slant_deg": [], "reflectance": [], "noise": []},
        {"about": {}},
        {"about": {"settings": {}, "reflectance": {}, "source": ""}},
    ],
)
def test_what_is_no_table_is_refused(tmp_path, change):
    path = tmp_path / "table.json"
    write_table(path, table(TONE, TONE))
    path.write_text(json.dumps(json.loads(path.read_text()) | change), encoding="utf-8")
    with pytest.raises(CalibrationError):
        read_table(path)
    path.write_text("[1", encoding="utf-8")
    with pytest.raises(CalibrationError, match="not a tone table"):
        read_table(path)
    with pytest.raises(CalibrationError, match="cannot be read"):
        read_table(tmp_path / "none.json")


# From the tone asked for to the tone printed


def test_calibration_undoes_the_response():
    """What is printed, seen through the response, is the tone asked for, on and between the slopes of the table."""
    fine = np.linspace(0, 1, 401)
    responses = 0.1 + 0.4 * fine**2, 0.1 + 0.4 * np.sqrt(fine)
    made = table(*responses, tone=fine)
    asked = np.linspace(0.02, 1, 50)
    ways = inverse(made, "compress")
    for row, response in zip(ways, responses, strict=True):
        printed = np.interp(asked, np.linspace(0, 1, 513), row)
        seen = np.interp(printed, fine, response)
        assert (seen - 0.1) / 0.4 == pytest.approx(asked, abs=0.01)


def test_slopes_are_interpolated_and_overhangs_count_as_upright(tmp_path):
    path = tmp_path / "t.json"
    tone = np.linspace(0, 1, 21)
    write_table(path, table(tone, np.clip(tone * 2, 0, 1), tone=tone))
    chosen = PrintSettings(calibration="file", calibration_file=str(path))
    asked = np.full(5, 0.6)
    printed, notes = calibrated(asked, np.array([-40.0, 0.0, 15.0, 30.0, 80.0]), chosen)
    assert printed == pytest.approx([0.6, 0.6, 0.45, 0.3, 0.3], abs=0.003)
    assert notes == []
    assert calibrated(asked, asked, chosen.changed({"calibration": "none"}))[0] is asked
    with pytest.raises(CalibrationError):
        calibrated(asked, asked, chosen.changed({"calibration_file": "nowhere.json"}))
    with pytest.raises(CalibrationError, match="names no tone table"):
        calibrated(asked, asked, chosen.changed({"calibration_file": ""}))
    for way in ("none", "upright", "slope_aware"):
        assert "set calibration = file" in calibrated(asked, asked, chosen.changed({"calibration": way}))[1][0]


@pytest.mark.parametrize("quality", ["standard", "fine"])
@pytest.mark.parametrize("pattern", ["default", "paper", "wave"])
def test_shipped_tables_hold_for_the_shipped_presets(pattern, quality):
    presets = [quality, *(["paper"] if pattern == "paper" else [])]
    chosen = PrintSettings().changed(preset_values(presets) | ({"pattern": "wave"} if pattern == "wave" else {}))
    made = shipped_table(chosen)
    assert made.provenance.differences(chosen) == []
    assert made.slant_deg.tolist() == list(range(0, 81, 10))
    assert made.reflectance[0, -1] - made.reflectance[0, 0] > (0.28 if pattern == "default" else 0.055)
    assert calibrated(np.array([0.2]), np.zeros(1), chosen)[1] == []


def test_ours_has_three_times_the_papers_range():
    both = (PrintSettings().changed(preset_values(presets)) for presets in ([], ["paper"]))
    ours, papers = (shipped_table(chosen).reflectance[0] for chosen in both)
    assert ours[-1] - ours[0] >= 3 * (papers[-1] - papers[0])


def test_settings_that_the_table_does_not_hold_for_are_told():
    _, notes = calibrated(np.zeros(1), np.zeros(1), PrintSettings(layer_height=0.15, wave_depth_max=0.9))
    assert len(notes) == 1 and "layer_height 0.15 instead of" in notes[0] and "wave" not in notes[0].split("(")[1][:60]
    # The nearest one of those that come with the program is taken.
    for height, nearest in ((0.15, 0.2), (0.21, 0.2), (0.24, 0.25), (0.3, 0.25)):
        table_used = shipped_table(PrintSettings(layer_height=height))
        assert table_used.provenance.settings["layer_height"] == nearest


def test_the_nearest_table_differs_in_the_fewest_settings_then_by_the_smallest_shares():
    settings = tone_settings(DEFAULT)

    def distance(**changes):
        return replace(PROVENANCE, settings=settings | changes).distance(DEFAULT)

    width, height = settings["extrusion_width"], settings["layer_height"]
    assert distance() == (0, 0)
    assert distance(layer_height=height * 2) == (1, pytest.approx(0.5)) == distance(layer_height=height / 2)
    assert distance(layer_height=height * 1.01, extrusion_width=width * 1.01) > distance(layer_height=height * 9)
    assert distance(layer_height=height * 1.1) < distance(extrusion_width=width * 1.2) < distance(pattern="another")


def test_every_pattern_has_a_table():
    setting = next(setting for setting in fields(PrintSettings) if setting.name == "pattern")
    tables = [shipped_table(PrintSettings(pattern=pattern)) for pattern in setting.metadata["choices"]]
    assert [table_used.provenance.settings["pattern"] for table_used in tables] == list(setting.metadata["choices"])


@pytest.mark.parametrize("quality", ["standard", "fine"])
@pytest.mark.parametrize("presets", [[], ["paper"], ["waves_set_back"], ["set_back"]])
def test_every_pattern_preset_has_its_table(presets, quality):
    chosen = PrintSettings().changed(preset_values([quality, *presets]))
    assert calibrated(np.zeros(1), np.zeros(1), chosen)[1] == []


def test_the_print_is_modulated_by_the_calibrated_tone_and_keeps_the_one_asked_for():
    solid = cylinder(radius=6, height=3, tone=0.75)
    plain, made = (generate(solid, PrintSettings(skirts=0, calibration=way)) for way in ("none", "slope_aware"))
    assert plain.outlines.tone == pytest.approx(0.75) and made.outlines.tone == pytest.approx(0.75)
    back = plain.outlines.set_back.max(), made.outlines.set_back.max()
    assert back[0] == pytest.approx(0.35 * 0.5, abs=1e-3)
    wanted = np.interp(0.75, np.linspace(0, 1, 513), inverse(shipped_table(DEFAULT), "compress")[0])
    assert back[1] == pytest.approx(0.35 * (2 * wanted - 1), abs=2e-3)

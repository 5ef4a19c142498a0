"""The commands `measure` and `build-table`, and what calibration does to a print that took no part in it."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.measuring import gonioreflectometer  # noqa: E402
from dualcolor.bridge.measuring.gonioreflectometer import measure, read_tile  # noqa: E402
from dualcolor.cli import main  # noqa: E402
from dualcolor.core.calibration.calibrate import shipped_table  # noqa: E402
from dualcolor.core.calibration.gamut_mapping import WHOLE_RANGE, targets  # noqa: E402
from dualcolor.core.calibration.sweep import read_sweep, sweep_path  # noqa: E402
from dualcolor.core.calibration.table import read_table  # noqa: E402
from dualcolor.core.calibration.tile import profile_tile, step_tile  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from PIL import Image  # noqa: E402


@pytest.fixture
def quick(monkeypatch):
    """Few samples; an empty Blender."""
    monkeypatch.setattr(gonioreflectometer, "FACE_ON_SAMPLES", 4)
    monkeypatch.setattr(gonioreflectometer, "SAMPLES", 1)
    monkeypatch.setattr(gonioreflectometer, "MM_PER_PIXEL", 0.25)
    bpy.ops.wm.read_factory_settings(use_empty=True)


@pytest.mark.parametrize("slant", [0.0, 60.0])
def test_calibrated_print_shows_the_tones_asked_for(quick, slant):
    """A profile that took no part in making the table, against the same print without calibration."""
    tone = np.array([1.0, 1.0, *np.linspace(1, 0, 9), 0.0, 0.0])
    tile = profile_tile(slant, 0.25, tone, 60.0)
    chosen = PrintSettings()
    row = int(slant / 10)
    dark, light = targets(shipped_table(chosen), "compress", np.array([0.0, 1.0]), WHOLE_RANGE)[row]
    error = {}
    for way in ("slope_aware", "none"):
        seen, _ = read_tile(tile, chosen.changed({"calibration": way}), 4.8, [(0.0, 0.0)])
        inner = slice(3, -3)  # off the ends, where the window averages over a kink
        error[way] = float(np.sqrt((((seen[:, 0] - dark) / (light - dark) - tone)[inner] ** 2).mean()))
    assert error["slope_aware"] < (0.02 if slant == 0 else 0.04)
    assert error["slope_aware"] < error["none"] / 2


def test_bars_of_light_lose_nothing_to_the_width_of_dark_lines(quick, monkeypatch):
    """Bars a millimeter wide reflect, in all, the mean of the two tones aimed at."""
    chosen = PrintSettings()
    at = np.linspace(-20.0, 20.0, 401)
    tone = np.where(np.floor(at / 2.0 + 1e-6) % 2 == 0, 0.5, 1.0)
    aimed = targets(shipped_table(chosen), "compress", np.array([0.5, 1.0]), (0.5, 1.0))[0]
    tile = profile_tile(0.0, 0.25, tone, 40.0)
    mean = {}
    for way in ("with", "without"):
        if way == "without":
            monkeypatch.setattr("dualcolor.core.job.wall_stages.widened", lambda lines, printed, set_back, _: set_back)
        seen, _ = read_tile(tile, chosen, 8.0, [(0.0, 0.0)])
        mean[way] = float(seen[100:-100, 0].mean())
    assert mean["with"] == pytest.approx(aimed.mean(), abs=0.006)
    assert mean["without"] < aimed.mean() - 0.008


def test_patches_agree_with_the_gradient_of_the_table(quick):
    tone = np.array([0.1, 0.6])
    seen, noise = read_tile(step_tile(0.0, 0.25, tone), PrintSettings(calibration="none"), 4.8, [(0.0, 0.0)])
    made = shipped_table(PrintSettings())
    assert seen[:, 0] == pytest.approx(np.interp(tone, made.tone, made.reflectance[0]), abs=0.02)
    assert (noise < 0.01).all()


def test_gamut_collapses_to_the_sides_and_keeps_its_bearings(quick, monkeypatch):
    """Nearly edge on from above or below a print is all one color or the other; it is the widest near face on."""
    monkeypatch.setattr(
        "dualcolor.bridge.measuring.gonioreflectometer.angles_of", lambda block: [(0.0, 0.0), (75.0, 0.0)]
    )
    sweep = measure(0.0, "phi", PrintSettings(pattern="wave"))
    assert sweep.angle_deg.tolist() == [0, 75]
    span = sweep.reflectance[-1] - sweep.reflectance[0]
    assert 0.05 < span[0] < 0.15
    assert sweep.provenance.settings["pattern"] == "wave" and "Blender" in sweep.provenance.source


def test_measure_goes_on_where_it_was_and_build_table_makes_table_and_maps(quick, tmp_path, capsys):
    out = tmp_path / "readings"
    assert main(["measure", "--slants", "0", "--blocks", "face", "--out", str(out)]) == 0
    path = sweep_path(out, 0, "face")
    before = path.stat().st_mtime_ns
    assert main(["measure", "--slants", "0", "--blocks", "face", "--out", str(out)]) == 0
    assert "done before" in capsys.readouterr().out
    assert path.stat().st_mtime_ns == before
    assert main(["measure", "--slants", "0", "--blocks", "face", "--out", str(out), "--set", "offset_max=0.3"]) == 1
    assert "measured otherwise" in capsys.readouterr().err
    assert main(["build-table", str(out)]) == 0
    table = read_table(out / "table.json")
    assert (table.reflectance >= 0).all() and table.slant_deg.tolist() == [0]
    assert table.reflectance[0] == pytest.approx(shipped_table(PrintSettings()).reflectance[0], abs=0.03)
    assert read_sweep(path).reflectance.shape == (25, 1)
    with Image.open(out / "gamut_maps.png") as maps:
        assert maps.size[1] > 150
    assert main(["build-table", str(tmp_path)]) == 1
    assert main(["measure", "--slants", "95", "--out", str(out)]) == 2
    assert main(["measure", "--blocks", "side", "--out", str(out)]) == 2

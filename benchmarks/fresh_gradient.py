"""A gradient that took no part in making the tone tables, printed without and with calibration and read.

    python benchmarks/fresh_gradient.py [--preset NAME …] [--slants DEG,DEG] [--write]

It runs the other way than the one the tables are made from, is steeper, and ends in even black and white. Prints the
RMSE of what is read against what is asked for, as a share of the mapped range; `--write` puts the table into
docs/calibration.md. About five minutes on two cores.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
import bpy  # noqa: E402
import numpy as np  # noqa: E402
from dualcolor.benchmarks.tables import replace_table  # noqa: E402
from dualcolor.bridge.measuring import gonioreflectometer  # noqa: E402
from dualcolor.bridge.measuring.gonioreflectometer import WINDOW_WAVES, read_tile  # noqa: E402
from dualcolor.bridge.quiet import quiet_stdout  # noqa: E402
from dualcolor.commands.measure import slants  # noqa: E402
from dualcolor.core.calibration.calibrate import table_for  # noqa: E402
from dualcolor.core.calibration.gamut_mapping import WHOLE_RANGE, printable_tones  # noqa: E402
from dualcolor.core.calibration.tile import profile_tile  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.settings.presets import preset_values  # noqa: E402

PAGE = ROOT / "docs" / "calibration.md"
PRESETS = ("set_back", "waves_set_back", "paper")
SLANTS = (0.0, 30.0, 60.0)
WIDTH_MM, EVEN_MM, PLACES = 60.0, 8.0, 41
SAMPLES = 128  # the whole range of the paper's waves is sixty times the noise of a reading for a table
HEAD = (
    "| preset | slant | error without | with | how many times | back, without | with | noise |",
    "|---|---|---|---|---|---|---|---|",
)


def main() -> int:
    """Print, read, compare."""
    parser = argparse.ArgumentParser(description="A gradient without and with tone calibration.")
    parser.add_argument("--preset", action="append", metavar="NAME", help="of the pattern; repeatable")
    parser.add_argument("--slants", type=slants, default=SLANTS, metavar="DEG,DEG,…")
    parser.add_argument("--write", action="store_true", help="replace the table in docs/calibration.md")
    args = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    gonioreflectometer.FACE_ON_SAMPLES = SAMPLES
    rows = []
    for preset in args.preset or PRESETS:
        for slant in args.slants:
            rows.append(row(preset, slant))
            print(rows[-1], flush=True)
    if args.write:
        replace_table(PAGE, "gradient", "\n".join([*HEAD, *rows, ""]))
    return 0


def row(preset: str, slant: float) -> str:
    """Of the table: a tile of one slant, printed twice."""
    settings = PrintSettings().changed(preset_values([preset]))
    error, back, noise = {}, {}, 0.0
    for way in ("none", settings.calibration):
        wanted, seen, unsure = reading(settings.changed({"calibration": way}), slant)
        error[way] = float(np.sqrt(((seen - wanted) ** 2).mean()))
        falls = np.diff(wanted) < 0
        back[way] = max(float(np.diff(seen)[falls].max()), 0.0)
        noise = max(noise, unsure)
    plain, made = error["none"], error[settings.calibration]
    steps = f"{back['none']:.3f} | {back[settings.calibration]:.3f}"
    return f"| `{preset}` | {slant:g}° | {plain:.3f} | {made:.3f} | {plain / made:.1f} | {steps} | {noise:.3f} |"


def reading(settings: PrintSettings, slant: float) -> tuple[np.ndarray, np.ndarray, float]:
    """What is asked for and what is read along the gradient, and the standard error; 0 and 1 are the mapped ends."""
    place = np.linspace(-WIDTH_MM / 2, WIDTH_MM / 2, PLACES)
    profile = np.clip(0.5 - place / (WIDTH_MM - 2 * EVEN_MM), 0.0, 1.0)
    tile = profile_tile(slant, settings.layer_height, profile, WIDTH_MM)
    window = WINDOW_WAVES * settings.wavelength
    with quiet_stdout():
        seen, noise = read_tile(tile, settings, window, [(0.0, 0.0)])
    table = table_for(settings)
    ends = np.array(WHOLE_RANGE)
    aimed = printable_tones(
        ends, np.array([slant]), table, WHOLE_RANGE, settings.changed({"calibration": "slope_aware"})
    )
    dark, light = aimed.target[0]
    inner = np.abs(place) <= (WIDTH_MM - window) / 2  # all that the window takes in is in the picture
    asked = windowed(place, profile, window)
    return asked[inner], ((seen[:, 0] - dark) / (light - dark))[inner], float(noise[inner].max() / (light - dark))


def windowed(place: np.ndarray, profile: np.ndarray, window: float) -> np.ndarray:
    """The profile averaged as the readings are: by a triangle of weights as wide as the window."""
    fine = np.linspace(-WIDTH_MM, WIDTH_MM, 2401)
    weight = np.clip(1 - np.abs(fine - place[:, None]) / (window / 2), 0.0, None)
    return np.asarray(weight @ np.interp(fine, place, profile) / weight.sum(axis=1))


if __name__ == "__main__":
    sys.exit(main())

"""The paper's Figure 8: pictures on plates without and with tone calibration, in each pattern preset.

    python benchmarks/calibrated_picture.py [IMAGE …] [--preset NAME …] [--out FILE] [--write]

Prints how well each shows its picture. The first picture goes into a file, aimed at, uncalibrated and calibrated;
`--write` puts the table into docs/calibration.md. A quarter of an hour on two cores.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
import bpy  # noqa: E402
import numpy as np  # noqa: E402
from dualcolor.benchmarks.tables import replace_table  # noqa: E402
from dualcolor.bridge.input.image_input import image_tone, load_image  # noqa: E402
from dualcolor.bridge.pictures.picture_print import picture_print  # noqa: E402
from dualcolor.bridge.quiet import quiet_stdout  # noqa: E402
from dualcolor.core.calibration.calibrate import table_for  # noqa: E402
from dualcolor.core.calibration.gamut_mapping import image_range, targets  # noqa: E402
from dualcolor.core.model import ToneImage  # noqa: E402
from dualcolor.core.pictures.match import averaged, correlation, enlarged, in_pixels  # noqa: E402
from dualcolor.core.pictures.shapes import fitted, picture_plate  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.settings.presets import preset_values  # noqa: E402
from dualcolor.core.texture.decode import srgb_from_linear  # noqa: E402
from PIL import Image, ImageDraw, ImageFont  # noqa: E402

IMAGES = tuple(ROOT.parent / "shared" / "data" / "images" / f"{name}.png" for name in ("camera", "astronaut", "text"))
PRESETS = {"paper": "waves (`paper`)", "waves_set_back": "shallow waves, set back (`waves_set_back`)",
           "set_back": "lines set back (`set_back`, default)"}  # fmt: skip
OUT, PAGE = ROOT / "docs" / "images" / "calibration.png", ROOT / "docs" / "calibration.md"
WIDTH_MM, HEIGHT_MM, THICKNESS_MM, MM_PER_PIXEL, SAMPLES = 30.0, 35.5, 2.0, 0.1, 16
WINDOW_MM = 2.0
SIGMA_MM = WINDOW_MM / np.sqrt(12)  # of a Gaussian that spreads a point as far as such a window
BORDER_MM = 4.0  # along the edges of a plate, which are lighter than its middle, whatever is printed
TITLE_HEIGHT = 22


@dataclass(frozen=True)
class Shown:
    """A plate, linear reflectances (H, W): what is aimed at, and what the print shows."""

    wanted: np.ndarray
    seen: np.ndarray

    def blurred(self) -> tuple[np.ndarray, np.ndarray]:
        """What is seen and what is aimed at, low-passed, without the border."""
        border = round(BORDER_MM / MM_PER_PIXEL)
        inner = (slice(border, -border),) * 2
        return low_pass(self.seen)[inner], low_pass(self.wanted)[inner]

    @property
    def error(self) -> float:
        """RMSE in L*."""
        seen, wanted = self.blurred()
        return float(np.sqrt(((lightness(seen) - lightness(wanted)) ** 2).mean()))

    @property
    def boxed_error(self) -> float:
        """The same after a moving average over the window, whose edges cut through the pattern."""
        border, window = round(BORDER_MM / MM_PER_PIXEL), in_pixels((WINDOW_MM, WINDOW_MM), MM_PER_PIXEL)
        inner = (slice(border, -border),) * 2
        seen, wanted = (lightness(averaged(each, window)[inner]) for each in (self.seen, self.wanted))
        return float(np.sqrt(((seen - wanted) ** 2).mean()))

    @property
    def agreement(self) -> float:
        """Pearson's correlation."""
        return correlation(*self.blurred())


def main() -> int:
    """Print the plates, compare and draw."""
    parser = argparse.ArgumentParser(description="Pictures without and with tone calibration.")
    parser.add_argument("images", type=Path, nargs="*", default=list(IMAGES), metavar="IMAGE")
    parser.add_argument("--preset", action="append", choices=PRESETS, metavar="NAME", help="of the pattern; repeatable")
    parser.add_argument("--out", type=Path, default=OUT, metavar="FILE", help="PNG file to write")
    parser.add_argument("--write", action="store_true", help="replace the table in docs/calibration.md")
    args = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    rows, strips = [], []
    for path in args.images:
        with quiet_stdout():
            tone = image_tone(load_image(path))
        for preset in args.preset or PRESETS:
            plain, made, white = plates(path.stem, tone, preset)
            rows.append(row(path, preset, plain, made))
            print(rows[-1], f"(by a window: {plain.boxed_error:.2f}, {made.boxed_error:.2f})", flush=True)
            if path == args.images[0] and preset != "waves_set_back":
                strips.append(strip(preset, plain, made, white))
    if strips:
        page = Image.new("L", (strips[0].width, sum(image.height for image in strips)), 255)
        for number, image in enumerate(strips):
            page.paste(image, (0, number * image.height))
        page.save(args.out, optimize=True)
    if args.write:
        replace_table(PAGE, "plates", "\n".join([*HEAD, *rows, ""]))
    return 0


HEAD = (
    "| picture | pattern | correlation without | with | tone error without | with | of it |",
    "|---|---|---|---|---|---|---|",
)


def row(path: Path, preset: str, plain: Shown, made: Shown) -> str:
    """Of the table."""
    errors = f"{plain.error:.2f} | {made.error:.2f} | {made.error / plain.error:.2f}"
    return f"| {path.stem} | {PRESETS[preset]} | {plain.agreement:.4f} | {made.agreement:.4f} | {errors} |"


def plates(name: str, tone: ToneImage, preset: str) -> tuple[Shown, Shown, float]:
    """A picture's print without and with calibration, and the reflectance of the lightest print."""
    settings = PrintSettings().changed(preset_values([preset]))
    plate = picture_plate(WIDTH_MM, HEIGHT_MM, THICKNESS_MM, settings)
    picture = fitted(tone, plate, auto_contrast=True)
    table = table_for(settings)
    shown = []
    for way in ("none", settings.calibration):
        with quiet_stdout():
            chosen = settings.changed({"calibration": way})
            made = picture_print(picture, plate, chosen, name, MM_PER_PIXEL, SAMPLES)
        asked = enlarged(picture.tone, made.photograph.shape)[::-1].ravel()
        wanted = targets(table, "compress", asked, image_range(asked, MM_PER_PIXEL**2))[0]
        shown.append(Shown(wanted.reshape(made.photograph.shape), made.photograph.astype(np.float64)))
    return shown[0], shown[1], float(table.reflectance[0, -1])


def low_pass(picture: np.ndarray) -> np.ndarray:
    """A picture seen through a Gaussian, beyond its edges as at them.

    Not through a window: its edges would let the pattern through where tones change, by up to half of an error.
    """
    margin = round(4 * SIGMA_MM / MM_PER_PIXEL)
    padded = np.pad(np.nan_to_num(picture, nan=float(np.nanmean(picture))), margin, mode="edge")
    up, across = (np.fft.fftfreq(size, MM_PER_PIXEL) for size in padded.shape)
    passed = np.exp(-2 * (np.pi * SIGMA_MM) ** 2 * (up[:, None] ** 2 + across**2))
    return np.asarray(np.fft.ifft2(np.fft.fft2(padded) * passed).real[margin:-margin, margin:-margin])


def lightness(reflectance: np.ndarray) -> np.ndarray:
    """CIE L* of reflectances."""
    return np.asarray(116 * np.cbrt(np.maximum(reflectance, 0.008856)) - 16)


def strip(preset: str, plain: Shown, made: Shown, white: float) -> Image.Image:
    """Aimed at, uncalibrated and calibrated side by side, as from where the pattern is too fine to be seen."""
    named = {f"{preset}: aimed at": plain.wanted, "uncalibrated": plain.seen, "calibrated": made.seen}
    pictures = {title: low_pass(picture) / white for title, picture in named.items()}
    height, width = plain.wanted.shape
    page = Image.new("L", (len(pictures) * (width + 8), height + TITLE_HEIGHT + 8), 255)
    draw, font = ImageDraw.Draw(page), ImageFont.load_default(15)
    for number, (title, picture) in enumerate(pictures.items()):
        pixels = np.rint(srgb_from_linear(np.clip(picture, 0.0, 1.0)) * 255).astype(np.uint8)
        page.paste(Image.fromarray(pixels), (number * (width + 8), TITLE_HEIGHT))
        draw.text((number * (width + 8), 2), title, fill=0, font=font)
    return page


if __name__ == "__main__":
    sys.exit(main())

"""The paper's Figure 8: a picture on a plate without and with tone calibration, in the paper's pattern and in ours.

    python benchmarks/calibrated_picture.py [IMAGE] [--out FILE]

Prints how well each shows the picture, and writes all of them side by side.
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
from dualcolor.bridge.image_input import image_tone, load_image  # noqa: E402
from dualcolor.bridge.picture_print import picture_print  # noqa: E402
from dualcolor.bridge.quiet import quiet_stdout  # noqa: E402
from dualcolor.core.calibration.calibrate import shipped_table  # noqa: E402
from dualcolor.core.calibration.gamut_mapping import image_range, targets  # noqa: E402
from dualcolor.core.model import ToneImage  # noqa: E402
from dualcolor.core.picture_match import averaged, enlarged, in_pixels  # noqa: E402
from dualcolor.core.picture_shapes import fitted, picture_plate  # noqa: E402
from dualcolor.core.presets import preset_values  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.texture.decode import srgb_from_linear  # noqa: E402
from PIL import Image, ImageDraw, ImageFont  # noqa: E402

IMAGE = ROOT.parent / "shared" / "data" / "images" / "camera.png"
OUT = ROOT / "docs" / "images" / "calibration.png"
WIDTH_MM, HEIGHT_MM, MM_PER_PIXEL, SAMPLES = 36.0, 36.0, 0.1, 40
LOW_PASS_MM = (2.0, 2.0)
TITLE_HEIGHT = 22


def main() -> int:
    """Print the plates, compare and draw."""
    parser = argparse.ArgumentParser(description="A picture without and with tone calibration.")
    parser.add_argument("image", type=Path, nargs="?", default=IMAGE, metavar="IMAGE")
    parser.add_argument("--out", type=Path, default=OUT, metavar="FILE", help="PNG file to write")
    args = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with quiet_stdout():
        tone = image_tone(load_image(args.image))
    rows = []
    for title, presets in (("waves", ["paper"]), ("set back", [])):
        settings = PrintSettings().changed(preset_values(presets) | {"texture_filter": "lanczos"})
        rows.append(row(title, tone, settings))
    width = max(image.width for image in rows)
    page = Image.new("L", (width, sum(image.height for image in rows)), 255)
    for number, image in enumerate(rows):
        page.paste(image, (0, number * image.height))
    page.save(args.out, optimize=True)
    return 0


def row(title: str, tone: ToneImage, settings: PrintSettings) -> Image.Image:
    """The picture that is aimed at, the print without and the print with calibration."""
    plate = picture_plate(WIDTH_MM, HEIGHT_MM, 2.0, settings)
    picture = fitted(tone, plate, auto_contrast=True)
    table = shipped_table(settings)
    if table is None:
        raise SystemExit("there is no tone table for this pattern")
    shown, wanted = {}, np.zeros((0, 0))
    for way in ("none", "slope_aware"):
        with quiet_stdout():
            made = picture_print(picture, plate, settings.changed({"calibration": way}), title, MM_PER_PIXEL, SAMPLES)
        asked = enlarged(picture.tone, made.photograph.shape)[::-1].ravel()
        shown_tones = image_range(asked, MM_PER_PIXEL**2)
        wanted = targets(table, "compress", asked, shown_tones)[0].reshape(made.photograph.shape)
        shown[way] = made.photograph.astype(np.float64)
        error = tone_error(shown[way], wanted)
        print(f"{title}, {way}: correlation {made.match.correlation:.4f}, tone error {error:.2f} in L*", flush=True)
    white = float(table.reflectance[0, -1])
    titles = {f"{title}: aimed at": wanted, "uncalibrated": shown["none"], "calibrated": shown["slope_aware"]}
    window = in_pixels(LOW_PASS_MM, MM_PER_PIXEL)  # as from where the pattern is too fine to be seen
    return side_by_side({name: averaged(picture, window) / white for name, picture in titles.items()})


def tone_error(seen: np.ndarray, wanted: np.ndarray) -> float:
    """RMSE in L* after averaging over 2 x 2 mm, more than that away from the edges."""
    window = in_pixels(LOW_PASS_MM, MM_PER_PIXEL)
    inner = tuple(slice(2 * size, -2 * size) for size in window)
    both = [lightness(averaged(values, window)[inner]) for values in (seen, wanted)]
    return float(np.sqrt(np.nanmean((both[0] - both[1]) ** 2)))


def lightness(reflectance: np.ndarray) -> np.ndarray:
    """CIE L* of reflectances."""
    return np.asarray(116 * np.cbrt(np.maximum(reflectance, 0.008856)) - 16)


def side_by_side(pictures: dict[str, np.ndarray]) -> Image.Image:
    """Linear pictures, 1 being white, with their titles."""
    height, width = next(iter(pictures.values())).shape
    page = Image.new("L", (len(pictures) * (width + 8), height + TITLE_HEIGHT + 8), 255)
    draw, font = ImageDraw.Draw(page), ImageFont.load_default(15)
    for number, (name, picture) in enumerate(pictures.items()):
        pixels = np.rint(srgb_from_linear(np.nan_to_num(picture, nan=1.0)) * 255).astype(np.uint8)
        page.paste(Image.fromarray(pixels), (number * (width + 8), TITLE_HEIGHT))
        draw.text((number * (width + 8), 2), name, fill=0, font=font)
    return page


if __name__ == "__main__":
    sys.exit(main())

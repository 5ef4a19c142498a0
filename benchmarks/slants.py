"""The paper's Figure 9: how a picture's resolution falls on walls that lean back, seen from one place and face on.

    python benchmarks/slants.py [--preset NAME] [--out FILE]

An 8 x 8 cm test object with stripes of 1 to 12 mm, slanted in steps of 10°. Prints and plots the finest stripes that
keep half of the contrast of the widest and do not turn into others. About five minutes on two cores.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
import bpy  # noqa: E402
import numpy as np  # noqa: E402
from dualcolor.bridge.measuring.gonioreflectometer import bare  # noqa: E402
from dualcolor.bridge.measuring.instrument import Face, mounted  # noqa: E402
from dualcolor.bridge.quiet import quiet_stdout  # noqa: E402
from dualcolor.core.calibration.tile import leaning_slab  # noqa: E402
from dualcolor.core.model import ToneImage  # noqa: E402
from dualcolor.core.pipeline import generate  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.settings.presets import preset_values  # noqa: E402
from dualcolor.core.texture.decode import srgb_from_linear  # noqa: E402
from PIL import Image, ImageDraw, ImageFont  # noqa: E402

OUT = ROOT / "docs" / "images" / "slants.png"
SIZE_MM, TEXEL_MM, MM_PER_PIXEL, SAMPLES = 80.0, 0.1, 0.4, 8
SLANTS = tuple(range(0, 81, 10))
PERIODS_MM = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0)
MARGIN_MM = 4.0
KEPT = 0.5
CELL, TEXT, EXPOSURE = 168, 14, 0.55


def main() -> int:
    """Print and photograph the test object in all slants, measure, draw."""
    parser = argparse.ArgumentParser(description="Resolution on walls that lean back.")
    parser.add_argument("--preset", action="append", default=[], metavar="NAME", help="repeatable")
    parser.add_argument("--out", type=Path, default=OUT, metavar="FILE", help="PNG file to write")
    args = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    settings = bare(PrintSettings().changed(preset_values(args.preset)))
    views, finest = [], []
    for slant in SLANTS:
        with quiet_stdout():
            fixed, face_on = photographs(slant, settings, 1.0, (-float(slant), 0.0))
            (inverted,) = photographs(slant, settings, -1.0, (0.0,))
        # What is alike in both is the pattern itself, which would pass for stripes as fine as its layers.
        finest.append(resolution(face_on - inverted))
        views.append((fixed, face_on))
        print(f"slant {slant}°: stripes of {finest[-1]:.1f} mm are resolved", flush=True)
    drawn(views, finest).save(args.out, optimize=True)
    return 0


def stripes(sign: float) -> ToneImage:
    """Columns of sine stripes, or of their negative, that run along the layers, the widest at the right, framed."""
    count = round(SIZE_MM / TEXEL_MM)
    at = (np.arange(count) + 0.5) * TEXEL_MM
    column = np.clip(((at - MARGIN_MM) / column_mm()).astype(np.int64), 0, len(PERIODS_MM) - 1)
    tone = 0.5 + 0.5 * sign * np.sin(2 * np.pi * at[:, None] / np.array(PERIODS_MM)[column])
    framed = (np.abs(at - SIZE_MM / 2) > SIZE_MM / 2 - MARGIN_MM)[:, None] | (np.abs(at - SIZE_MM / 2) > 36)[None, :]
    return ToneImage(np.where(framed, 1.0, tone).astype(np.float32), np.ones((count, count), dtype=np.float32))


def column_mm() -> float:
    """Width of a column of stripes."""
    return (SIZE_MM - 2 * MARGIN_MM) / len(PERIODS_MM)


def photographs(slant: float, settings: PrintSettings, sign: float, phis: tuple[float, ...]) -> list[np.ndarray]:
    """The object seen from some angles above its face, foreshortening undone."""
    result = generate(leaning_slab(SIZE_MM, SIZE_MM, slant, stripes(sign), f"Slant {slant}"), settings)
    up, back = math.cos(math.radians(slant)), math.sin(math.radians(slant))
    center = result.mesh.bounds[0] + np.array([SIZE_MM / 2, SIZE_MM / 2 * back, SIZE_MM / 2 * up])
    face = Face((float(center[0]), float(center[1]), float(center[2])), SIZE_MM, SIZE_MM, slant)
    with mounted(result.moves, settings, face) as stand:
        taken = [stand.photograph(phi_deg=phi, mm_per_pixel=MM_PER_PIXEL, samples=SAMPLES) for phi in phis]
    return [picture.astype(np.float64) for picture in taken]


def resolution(picture: np.ndarray) -> float:
    """Period of the finest stripes that are resolved, mm, read off between the columns.

    They keep half the amplitude of the widest and are half of all that varies; the rest is what stripes finer than
    the layers turn into.
    """
    at = (np.arange(len(picture)) + 0.5) * (SIZE_MM / len(picture))
    strength, purity = [], []
    for number, period in enumerate(PERIODS_MM):
        whole = math.floor((SIZE_MM - 2 * MARGIN_MM - 2) / period) * period
        rows = np.abs(at - SIZE_MM / 2) < whole / 2
        left = MARGIN_MM + number * column_mm() + 1
        columns = (at > left) & (at < left + column_mm() - 2)
        level = np.nanmean(picture[np.ix_(rows, columns)], axis=1)
        turn = np.exp(-2j * np.pi * at[rows] / period)
        strength.append(2 * abs(((level - level.mean()) * turn).mean()))
        purity.append(strength[-1] ** 2 / 2 / level.var())
    # As far down as all stripes keep it: stripes as fine as the layers can be in step with them and stand out again.
    share = np.minimum(np.array(strength) / strength[-1], purity)
    share = np.minimum.accumulate(share[::-1])[::-1]
    return float(np.interp(KEPT, share + np.arange(len(share)) * 1e-9, PERIODS_MM))


def drawn(views: list[tuple[np.ndarray, np.ndarray]], finest: list[float]) -> Image.Image:
    """Both rows of pictures and the plot below them."""
    page = Image.new("L", (len(SLANTS) * CELL, 2 * CELL + 260), 255)
    draw, font = ImageDraw.Draw(page), ImageFont.load_default(TEXT)
    for number, (slant, (fixed, face_on)) in enumerate(zip(SLANTS, views, strict=True)):
        tall = max(round((CELL - 8) * math.cos(math.radians(slant))), 4)
        page.paste(as_image(fixed).resize((CELL - 8, tall), Image.Resampling.BOX), (number * CELL, CELL - tall))
        page.paste(as_image(face_on).resize((CELL - 8, CELL - 8), Image.Resampling.BOX), (number * CELL, CELL + 8))
        draw.text((number * CELL, 2 * CELL + 4), f"{slant}°: {finest[number]:.1f} mm", fill=0, font=font)
    plot(draw, font, finest, (60, 2 * CELL + 40, len(SLANTS) * CELL - 60, 2 * CELL + 225))
    return page


def as_image(picture: np.ndarray) -> Image.Image:
    """Linear reflectance as gray."""
    encoded = srgb_from_linear(np.nan_to_num(picture, nan=EXPOSURE) / EXPOSURE)
    return Image.fromarray(np.rint(encoded * 255).astype(np.uint8))


def plot(
    draw: ImageDraw.ImageDraw, font: ImageFont.FreeTypeFont | ImageFont.ImageFont, finest: list[float],
    box: tuple[int, int, int, int],
) -> None:  # fmt: skip
    """Finest stripes against slant."""
    left, top, right, bottom = box
    draw.rectangle(box, outline=0)
    most = max(PERIODS_MM)
    for level in (2, 4, 6, 8, 10, 12):
        y = bottom - (bottom - top) * level / most
        draw.line((left, y, right, y), fill=210)
        draw.text((left - 8, y), f"{level}", fill=0, font=font, anchor="rm")
    points = [
        (left + (right - left) * slant / 80, bottom - (bottom - top) * value / most)
        for slant, value in zip(SLANTS, finest, strict=True)
    ]
    draw.line(points, fill=0, width=3)
    for (x, _), slant in zip(points, SLANTS, strict=True):
        draw.text((x, bottom + 4), f"{slant}°", fill=0, font=font, anchor="ma")
    draw.text((left + 10, top + 6), "finest stripes that are resolved, mm", fill=0, font=font)


if __name__ == "__main__":
    sys.exit(main())

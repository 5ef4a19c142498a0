"""Does the soft proof tell what the print will look like? A picture on plates, proofed, printed and compared.

    python benchmarks/soft_proof.py [IMAGE] [--out FILE]

Renders the proof of a plate from the very nodes that the viewport draws, and its predicted print strand by strand, and
prints how both agree after averaging over the pattern's period.
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
from dualcolor import registration  # noqa: E402
from dualcolor.benchmarks.proof_picture import proof_picture  # noqa: E402
from dualcolor.bridge.input.image_input import image_tone, load_image  # noqa: E402
from dualcolor.bridge.measuring.instrument import Face  # noqa: E402
from dualcolor.bridge.objects.picture_objects import add_picture_object  # noqa: E402
from dualcolor.bridge.pictures.picture_print import picture_print  # noqa: E402
from dualcolor.bridge.proof.soft_proof import show_proof  # noqa: E402
from dualcolor.bridge.quiet import quiet_stdout  # noqa: E402
from dualcolor.bridge.units import use_millimeters  # noqa: E402
from dualcolor.core.model import FloatArray, ToneImage  # noqa: E402
from dualcolor.core.pattern.modulation import PERIOD_LAYERS  # noqa: E402
from dualcolor.core.pictures.match import averaged, correlation, in_pixels  # noqa: E402
from dualcolor.core.pictures.shapes import PictureShape, fitted, picture_plate  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.settings.presets import preset_values  # noqa: E402
from dualcolor.core.texture.decode import srgb_from_linear  # noqa: E402
from PIL import Image  # noqa: E402

IMAGE = ROOT.parent / "shared" / "data" / "images" / "camera.png"
WIDTH_MM, HEIGHT_MM, THICKNESS_MM = 30.0, 35.5, 2.0
MM_PER_PIXEL, SAMPLES = 0.05, 4
PATTERNS = {"lines set back (default)": [], "waves set back": ["waves_set_back"], "waves (paper)": ["paper"]}
GAP = 8


def main() -> int:
    """Proof and print the plates and compare them."""
    parser = argparse.ArgumentParser(description="The soft proof of a picture against its predicted print.")
    parser.add_argument("image", type=Path, nargs="?", default=IMAGE, metavar="IMAGE")
    parser.add_argument("--out", type=Path, metavar="FILE", help="PNG file: proof and print, as they are and averaged")
    args = parser.parse_args()
    registration.register()
    print("| pattern | r | mean difference | proof, darkest to brightest | print |\n|---|---|---|---|---|")
    rows = [compared(args.image, title, presets) for title, presets in PATTERNS.items()]
    if args.out:
        page = np.concatenate([side_by_side(row) for row in rows])
        Image.fromarray(page).save(args.out, optimize=True)
    return 0


def compared(image: Path, title: str, presets: list[str]) -> list[FloatArray]:
    """Proof, print and both averaged; a row of the table is printed."""
    settings = PrintSettings().changed(preset_values(presets))
    plate = picture_plate(WIDTH_MM, HEIGHT_MM, THICKNESS_MM, settings)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    use_millimeters(bpy.context.scene)
    with quiet_stdout():
        picture = fitted(image_tone(load_image(image)), plate, auto_contrast=True)
        made = picture_print(picture, plate, settings, image.stem, MM_PER_PIXEL, SAMPLES)
        shown = proof_of(plate, picture, settings)
    period = PERIOD_LAYERS * settings.layer_height, made.match.period_mm
    window = in_pixels(period, MM_PER_PIXEL)
    pictures = [shown.astype(np.float64), made.photograph.astype(np.float64)]
    smooth = [averaged(each, window) for each in pictures]
    inner = tuple(slice(margin, -margin) for margin in window)  # as picture_match: nearer to them edges are seen too
    proof, printed = (each[inner] for each in smooth)
    ranges = [" to ".join(f"{value:.2f}" for value in np.nanpercentile(each, [1, 99])) for each in (proof, printed)]
    difference = float(np.nanmean(np.abs(proof - printed)))
    print(f"| {title} | {correlation(proof, printed):.4f} | {difference:.3f} | {ranges[0]} | {ranges[1]} |", flush=True)
    return [*pictures, *smooth]


def proof_of(plate: PictureShape, picture: ToneImage, settings: PrintSettings) -> FloatArray:
    """(H, W) reflectance that the proof of a plate's front shows."""
    obj = add_picture_object(picture, plate, "plate", settings)
    bpy.context.view_layer.update()
    show_proof(obj, settings)
    width, height = plate.size
    front = Face((0.0, float(plate.vertices[:, 1].min()), height / 2), width, height)
    return proof_picture(obj, front, MM_PER_PIXEL, SAMPLES)


def side_by_side(pictures: list[FloatArray]) -> np.ndarray:
    """Linear pictures as gray pixels, half of the light of a white sheet being white."""
    height = pictures[0].shape[0] + GAP
    page = np.full((height, sum(picture.shape[1] + GAP for picture in pictures)), 255, dtype=np.uint8)
    left = 0
    for picture in pictures:
        pixels = np.rint(srgb_from_linear(np.nan_to_num(picture, nan=1.0) * 2) * 255).astype(np.uint8)
        page[: picture.shape[0], left : left + picture.shape[1]] = pixels
        left += picture.shape[1] + GAP
    return page


if __name__ == "__main__":
    sys.exit(main())

"""One dislocation of the waves close up, in the paper's sampling and in ours:

    python benchmarks/seam_closeup.py [MESH] [--height-mm H] [--out FILE]

Prints a vase, or another model, in mid-gray with the preset `paper`, once with each sampling, and photographs the
prediction: the most visible dislocation of the paper's sampling, the same place with ours, and the most visible one
that ours has left.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, replace
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
import bpy  # noqa: E402
import numpy as np  # noqa: E402
from dualcolor.bridge.measuring.instrument import Face, photograph  # noqa: E402
from dualcolor.bridge.quiet import quiet_stdout  # noqa: E402
from dualcolor.core.analysis.analysis import Analysis, analyze  # noqa: E402
from dualcolor.core.analysis.surface_curves import surface_points  # noqa: E402
from dualcolor.core.contours.slant import slant_along  # noqa: E402
from dualcolor.core.model import FloatArray, SurfaceModel  # noqa: E402
from dualcolor.core.paths import Feature  # noqa: E402
from dualcolor.core.pipeline import generate  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.settings.presets import preset_values  # noqa: E402
from dualcolor.core.texture.decode import srgb_from_linear  # noqa: E402
from dualcolor.core.toolpaths.moves import Moves  # noqa: E402
from PIL import Image, ImageDraw, ImageFont  # noqa: E402
from sampling import obj_model  # noqa: E402

OUT = ROOT / "docs" / "images" / "seam_closeup.png"
WIDTH_MM, HEIGHT_MM, MM_PER_PIXEL, SAMPLES = 13.0, 10.0, 0.03, 12
AROUND_MM = 2.5  # seams so near belong to a dislocation
KEPT_MM = 12.0  # strands so near are printed
STEEPEST_DEG = 30.0  # from upright, of the walls that are looked at
FLAT_MM, FLAT_COSINE = 4.0, 0.8  # so far to either side the wall turns less than this
TITLE_HEIGHT, GAP, TICK = 24, 10, 9


@dataclass(frozen=True)
class Place:
    """A place on the surface: (3,) mm, and where its wall looks, degrees."""

    point: FloatArray
    azimuth_deg: float
    slant_deg: float
    error: float


def main() -> int:
    """Print, look for the places, photograph."""
    parser = argparse.ArgumentParser(description="A dislocation close up, in both samplings.")
    parser.add_argument("mesh", type=Path, nargs="?", metavar="MESH", help="of triangles (default: a vase)")
    parser.add_argument("--height-mm", type=float, default=80.0, metavar="H")
    parser.add_argument("--out", type=Path, default=OUT, metavar="FILE", help="PNG file to write")
    args = parser.parse_args()
    model = obj_model(args.mesh, args.height_mm) if args.mesh else vase()
    plain = PrintSettings().changed({**preset_values(["paper"]), "calibration": "none"})
    ours = plain.changed({"sampling": "optimized"})
    before, after = worst(analyze(model, plain)), worst(analyze(model, ours))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    views = [("the paper's sampling", plain, before), ("optimized, same place", ours, before)]
    views.append(("optimized, its most visible seam", ours, after))
    page(model, views).save(args.out, optimize=True)
    return 0


def vase() -> SurfaceModel:
    """A vase that swells and narrows again, 40 mm high."""
    height = np.linspace(0.0, 40.0, 81)
    radius = 15.0 + 4.0 * np.sin(2 * np.pi * height / 50.0)
    turn = np.linspace(0.0, 2 * np.pi, 240, endpoint=False)
    rings = np.stack([np.outer(radius, np.cos(turn)), np.outer(radius, np.sin(turn)),
                      np.repeat(height, len(turn)).reshape(len(height), -1)], axis=2)  # fmt: skip
    ring, side = (grid.ravel() for grid in np.mgrid[0 : len(height) - 1, 0 : len(turn)])
    low, beside = ring * len(turn) + side, ring * len(turn) + (side + 1) % len(turn)
    wall = np.column_stack([low, beside, beside + len(turn), low + len(turn)]).ravel()
    bottom, top = np.arange(len(turn))[::-1], np.arange(len(turn)) + (len(height) - 1) * len(turn)
    count = np.concatenate([np.full(len(low), 4), np.full(2, len(turn))])
    start = np.concatenate([[0], np.cumsum(count)])
    none = np.full(len(count), -1, dtype=np.int64)
    return SurfaceModel(rings.reshape(-1, 3), start, np.concatenate([wall, bottom, top]), None, None, none, (), "vase")


def worst(found: Analysis) -> Place:
    """The birth or death with the greatest seam errors around it, on a wall that stands nearly upright and flat."""
    assert found.errors and found.traced
    lines, samples, plane = found.lines, found.samples, found.layers.plane
    slant = slant_along(lines, found.mesh)
    at = np.flatnonzero(found.traced.birth | found.traced.death)
    point = lines.locate(samples.arc[at])[0]
    clear = np.abs(slant[point]) < STEEPEST_DEG
    for aside in (-FLAT_MM, FLAT_MM):
        loop = samples.loop[at]
        begin, length = lines.arc_start[loop], lines.length[loop]
        beside = lines.locate(begin + (samples.arc[at] + aside - begin) % length, loop)[0]
        clear &= np.einsum("ij,ij->i", lines.normal[beside], lines.normal[point]) > FLAT_COSINE
    at, point = at[clear], point[clear]
    here = surface_points(lines, plane, samples.arc[at], samples.loop[at])
    arc = found.errors.arc
    probes = surface_points(lines, plane, arc, np.searchsorted(lines.arc_start, arc, side="right") - 1)
    error = np.nan_to_num(found.errors.error)
    near = [error[((probes - place) ** 2).sum(axis=1) < AROUND_MM**2].sum() for place in here]
    best = int(np.argmax(near))
    x, y = lines.normal[point[best]]
    azimuth = float(np.degrees(np.arctan2(x, -y)))
    print(
        f"{found.settings.sampling}: {here[best].round(1).tolist()}, summed error {near[best]:.1f} of {len(at)} places"
    )
    return Place(here[best], azimuth, float(slant[point[best]]), float(near[best]))


def page(model: SurfaceModel, views: list[tuple[str, PrintSettings, Place]]) -> Image.Image:
    """The photographs side by side, with their titles; ticks at the edges point to the place."""
    pictures = []
    printed: dict[str, Moves] = {}
    for title, settings, place in views:
        if settings.sampling not in printed:
            printed[settings.sampling] = generate(model, settings).moves
        face = Face(tuple(place.point.tolist()), WIDTH_MM, HEIGHT_MM, place.slant_deg, place.azimuth_deg)
        with quiet_stdout():
            seen = photograph(around(printed[settings.sampling], place.point), settings, face,
                              mm_per_pixel=MM_PER_PIXEL, samples=SAMPLES, light="lamp")  # fmt: skip
        pixels = np.rint(srgb_from_linear(np.clip(np.nan_to_num(seen, nan=1.0), 0, 1)) * 255).astype(np.uint8)
        pictures.append((title, Image.fromarray(pixels)))
    width, height = pictures[0][1].size
    sheet = Image.new("L", (len(pictures) * (width + GAP) - GAP, height + TITLE_HEIGHT + TICK), 255)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(15)
    for number, (title, picture) in enumerate(pictures):
        left = number * (width + GAP)
        sheet.paste(picture, (left, TITLE_HEIGHT))
        draw.text((left, 2), title, fill=0, font=font)
        middle, bottom = left + width // 2, TITLE_HEIGHT + height
        draw.polygon([(middle - TICK, bottom + TICK), (middle + TICK, bottom + TICK), (middle, bottom)], fill=0)
    return sheet


def around(moves: Moves, place: FloatArray) -> Moves:
    """The moves with strands only near a place."""
    near = ((moves.position - place) ** 2).sum(axis=1) < KEPT_MM**2
    feature = np.where(near | ~moves.extrudes, moves.feature, int(Feature.TRAVEL))
    return replace(moves, feature=feature, filament=np.where(near, moves.filament, 0.0))


if __name__ == "__main__":
    sys.exit(main())

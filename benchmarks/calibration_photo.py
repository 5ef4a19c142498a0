"""A photograph of the calibration tile by a tilted camera in uneven light, read: against the instrument's table.

    python benchmarks/calibration_photo.py [--preset NAME] [--light soft] [--photo FILE.png] [--tilt DEG]

The tile is printed in the computer and rendered by Cycles: a perspective camera that stands above and beside the tile's
normal and is held askew, a lamp that is nearer to one end of the tile than to the other, 8-bit sRGB. About half a
minute on two cores.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
import bpy  # noqa: E402
import numpy as np  # noqa: E402
from dualcolor.bridge.measuring.gonioreflectometer import bare  # noqa: E402
from dualcolor.bridge.measuring.instrument import Face, mounted  # noqa: E402
from dualcolor.bridge.pictures.plastics import diffuse_material  # noqa: E402
from dualcolor.bridge.quiet import quiet_stdout  # noqa: E402
from dualcolor.core.calibration.calibrate import shipped_table  # noqa: E402
from dualcolor.core.calibration.marks import find_marks  # noqa: E402
from dualcolor.core.calibration.photo_table import patch_means, read_wedge, wedge_table  # noqa: E402
from dualcolor.core.calibration.photograph import read_photograph  # noqa: E402
from dualcolor.core.calibration.step_wedge import patches, references, wedge_plate, wedge_settings  # noqa: E402
from dualcolor.core.pictures.shapes import surface_of  # noqa: E402
from dualcolor.core.pipeline import generate  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.settings.presets import preset_values  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402

DISTANCE_MM, TURN_DEG, ROLL_DEG = 320.0, 8.0, 4.0
LIGHTS = {
    "even": ((-100.0, -80.0, 60.0), 200.0, 0.0),
    "soft": ((-100.0, -80.0, 60.0), 200.0, 0.6),
    "hard": ((-140.0, -190.0, 130.0), 20.0, 0.6),
}
"""Of each the lamp's place and size, mm, and its share of the light; the rest comes from all sides."""
EXPOSURE = 0.45


def main() -> int:
    """Print, photograph, read, compare."""
    parser = argparse.ArgumentParser(description="A calibration photograph put through the reader.")
    parser.add_argument("--preset", action="append", default=[], metavar="NAME", help="repeatable")
    parser.add_argument("--light", choices=tuple(LIGHTS), default="soft", help="from all sides, as from a window near "
                        "by, or as from a bulb")  # fmt: skip
    parser.add_argument("--photo", type=Path, metavar="FILE.png", help="keep the photograph")
    parser.add_argument(
        "--tilt", type=float, default=10.0, metavar="DEG", help="of the camera, above the tile's normal"
    )
    parser.add_argument("--width", type=int, default=1000, metavar="PIXELS")
    parser.add_argument("--samples", type=int, default=8)
    args = parser.parse_args()
    settings = wedge_settings(PrintSettings().changed(preset_values(args.preset)))
    with tempfile.TemporaryDirectory() as folder:
        path = args.photo or Path(folder) / "photograph.png"
        begin = time.monotonic()
        with quiet_stdout():
            photograph(path, settings, args.light, args.tilt, args.width, args.samples)
        print(f"photographed in {time.monotonic() - begin:.0f} s")
        error, fall_off, notes = errors(path, settings)
    print(f"light: {fall_off:.0%} at the dark end of the bright one")
    rmse = float(np.sqrt((error**2).mean()))
    print(f"greatest difference to the instrument's table {np.abs(error).max():.3f}, RMSE {rmse:.3f}")
    print(np.round(error, 3), *notes, sep="\n")
    return 0


def photograph(path: Path, settings: PrintSettings, light: str, tilt_deg: float, width: int, samples: int) -> None:
    """Print the tile, take its picture.

    Args:
        path: of the PNG.
        settings: of the print.
        light: of `LIGHTS`.
        tilt_deg: of the camera, above the tile's normal.
        width: of the picture, pixels.
        samples: of each pixel.
    """
    plate, picture = wedge_plate(settings)
    result = generate(surface_of(plate, picture, settings.background_tone, "Tile"), bare(settings))
    low, high = result.mesh.bounds
    front = Face(((low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2), *plate.size)
    with mounted(result.moves, settings, front):
        scene = bpy.data.scenes["Instrument"]
        _add_wall(scene, high[1] - low[1])
        _add_lamp(scene, *LIGHTS[light])
        _aim(scene, tilt_deg, plate.size[0])
        render = scene.render
        render.resolution_x, render.resolution_y = width, round(width * 0.62)
        render.image_settings.file_format = "PNG"
        render.image_settings.color_mode, render.image_settings.color_depth = "RGB", "8"
        render.film_transparent = False
        scene.view_settings.view_transform = "Standard"
        scene.view_settings.exposure = math.log2(EXPOSURE)
        scene.cycles.samples = samples
        render.filepath = str(path)
        bpy.ops.render.render(write_still=True, scene=scene.name)


def errors(path: Path, settings: PrintSettings) -> tuple[np.ndarray, float, list[str]]:
    """What the table lacks of the instrument's, the light's least share of its most, what the reader says."""
    table = shipped_table(settings)
    photo = read_photograph(path)
    marks = find_marks(photo, settings)
    reading = read_wedge(photo, marks, settings)
    white = patch_means(photo, marks, patches(settings))[0][references()[0]]
    made = wedge_table(reading, settings, table, None, path.name)
    return (
        made.reflectance[0] - np.interp(made.tone, table.tone, table.reflectance[0]),
        float(white.min() / white.max()),
        reading.notes,
    )


def _add_wall(scene: bpy.types.Scene, thickness: float) -> None:
    """Gray paper behind the tile."""
    mesh = bpy.data.meshes.new("wall")
    mesh.from_pydata([(-500, thickness, -500), (500, thickness, -500), (500, thickness, 500), (-500, thickness, 500)],
                     [], [(0, 1, 2, 3)])  # fmt: skip
    mesh.materials.append(diffuse_material("paper", 0.5, 1.0, 1.0))
    scene.collection.objects.link(bpy.data.objects.new("wall", mesh))


def _add_lamp(scene: bpy.types.Scene, place: tuple[float, float, float], size: float, share: float) -> None:
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 1.0 - share
    lamp = bpy.data.lights.new("lamp", "AREA")
    lamp.size = size
    distance = math.dist(place, (0, 0, 0))
    cosine = -place[1] / distance
    lamp.energy = share * math.pi**2 * distance**2 / cosine  # the tile's middle gets that share of the light
    made = bpy.data.objects.new("lamp", lamp)
    made.matrix_world = _looking(Vector(place), 0.0)
    scene.collection.objects.link(made)


def _aim(scene: bpy.types.Scene, tilt_deg: float, width: float) -> None:
    tilt, turn = math.radians(tilt_deg), math.radians(TURN_DEG)
    away = Vector((math.sin(turn) * math.cos(tilt), -math.cos(turn) * math.cos(tilt), math.sin(tilt)))
    camera = scene.camera
    camera.data.type, camera.data.sensor_fit = "PERSP", "HORIZONTAL"
    camera.data.clip_start, camera.data.clip_end = 1.0, 5000.0
    camera.data.angle = 2 * math.atan(width * 0.62 / DISTANCE_MM)
    camera.matrix_world = _looking(away * DISTANCE_MM, ROLL_DEG)


def _looking(place: Vector, roll_deg: float) -> Matrix:
    """At the origin, from a place."""
    turned = (-place).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    return Matrix.Translation(place) @ turned @ Matrix.Rotation(math.radians(roll_deg), 4, "Z")


if __name__ == "__main__":
    sys.exit(main())

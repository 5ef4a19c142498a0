"""A Cycles picture of the predicted print, taken in a small studio that is gone afterwards."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ..core.errors import OutputError, PrintError
from ..core.files import write_file
from ..core.model import FloatArray
from ..core.toolpaths.moves import Feature
from .curves import STRANDS_KEY, new_curves, read_strands, set_drawing
from .studio import add_backdrop, add_camera, add_lights, camera_axes

BESIDE_THE_OBJECT = (Feature.TOWER, Feature.SKIRT, Feature.SUPPORT, Feature.SUPPORT_INTERFACE)
STUDIO_SIZE = 100.0


def render_prediction(
    collection: bpy.types.Collection,
    path: str | PathLike[str],
    resolution: tuple[int, int] = (900, 900),
    samples: int = 64,
    azimuth_deg: float = -30.0,
    elevation_deg: float = 18.0,
    whole_plate: bool = False,
) -> None:
    """Render the strands of a preview to a PNG file; the scenes, the view and the settings stay as they are.

    Args:
        collection: made by `build_preview`.
        path: of the picture.
        resolution: width and height in pixels.
        samples: of each pixel at most; even surfaces get as few as 8.
        azimuth_deg: where the camera stands: 0 in front (-Y), positive to the right of it.
        elevation_deg: how far above the horizon it stands.
        whole_plate: with the cleaning tower, the skirt and the supports; otherwise the object alone.

    Raises:
        PrintError: there are no strands to show.
        OutputError: the file cannot be written.
    """
    if not Path(path).absolute().parent.is_dir():
        raise OutputError(f"{path} cannot be written, its folder does not exist", "choose another path")
    with leaving_no_trace(), tempfile.TemporaryDirectory() as folder:
        scene = bpy.data.scenes.new("Predicted Print")
        points = _copy_strands(collection, scene, whole_plate)
        axes = camera_axes(math.radians(azimuth_deg), math.radians(elevation_deg))
        add_camera(scene, points, axes, resolution)
        add_backdrop(scene, points, axes)
        add_lights(scene, axes)
        picture = Path(folder) / "picture.png"
        _set_output(scene, picture, resolution, samples)
        bpy.ops.render.render(write_still=True, scene=scene.name)
        write_file(path, picture.read_bytes())


def _copy_strands(collection: bpy.types.Collection, scene: bpy.types.Scene, whole_plate: bool) -> FloatArray:
    """Put copies of the wanted strands into the scene and return (N, 3) points of them all in world coordinates.

    The copies are scaled to one size, for rods of a tenth of a millimetre in a scene of metres are too thin for the
    renderer's single precision: it would add specks of light.
    """
    wanted = []
    for shown in [held for held in collection.objects if held.get(STRANDS_KEY)]:
        points, counts, radius, labels = read_strands(shown)
        chosen = whole_plate | ~np.isin(labels["feature"], BESIDE_THE_OBJECT)
        of_point = np.repeat(chosen, counts)
        if of_point.any():
            wanted.append((shown, points[of_point], counts[chosen], radius[of_point]))
    if not wanted:
        raise PrintError("there are no strands to render", "generate the toolpath first")
    matrices = [np.array(shown.matrix_world) for shown, *_ in wanted]
    world = [
        points @ matrix[:3, :3].T + matrix[:3, 3] for (_, points, *_), matrix in zip(wanted, matrices, strict=True)
    ]
    factor = STUDIO_SIZE / float(np.linalg.norm(np.ptp(np.concatenate(world), axis=0)))
    for (shown, points, counts, radius), matrix in zip(wanted, matrices, strict=True):
        data = new_curves(shown.name, points * factor, counts, radius * factor, {})
        data.materials.append(shown.data.materials[0])
        copy = bpy.data.objects.new(shown.name, data)
        matrix[:3, 3] *= factor
        copy.matrix_world = Matrix(matrix.tolist())
        scene.collection.objects.link(copy)
    return np.concatenate(world) * factor


def _set_output(scene: bpy.types.Scene, path: Path, resolution: tuple[int, int], samples: int) -> None:
    render = scene.render
    render.engine = "CYCLES"
    render.filepath, render.image_settings.file_format = str(path), "PNG"
    render.image_settings.color_mode = "RGB"
    render.resolution_x, render.resolution_y = resolution
    render.resolution_percentage = 100
    render.use_compositing = render.use_sequencer = False
    scene.view_settings.view_transform, scene.view_settings.look = "Standard", "None"
    set_drawing(scene)
    cycles = scene.cycles
    cycles.device, cycles.samples = "CPU", samples
    cycles.use_adaptive_sampling, cycles.adaptive_threshold, cycles.adaptive_min_samples = True, 0.1, 8
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 4, 4, 2
    try:
        cycles.denoiser, cycles.use_denoising = "OPENIMAGEDENOISE", True
    except TypeError:  # this build of Blender has no denoiser, and so no such name in the list
        cycles.use_denoising = False


@contextmanager
def leaving_no_trace() -> Iterator[None]:
    """Remove every datablock that comes into being inside."""
    kinds = ("scenes", "objects", "hair_curves", "meshes", "cameras", "lights", "worlds", "materials", "images")
    before = {kind: set(getattr(bpy.data, kind)) for kind in kinds}
    try:
        yield
    finally:
        for kind in kinds:
            held = getattr(bpy.data, kind)
            for made in set(held) - before[kind]:
                held.remove(made)

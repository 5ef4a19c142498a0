"""Cycles pictures of the predicted print, taken in a small studio that is removed afterwards."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ...core.errors import PrintError
from ...core.model import FloatArray, SurfaceModel
from ...core.paths import Feature
from ...core.pictures.viewing import Picture
from ..mesh_data import in_world
from ..strands.scrubber import strands_in
from ..strands.strand_curves import read_strands, set_drawing
from ..units import mm_per_unit
from .painted import painted_model
from .render_rods import render_rods
from .studio import Studio

BESIDE_THE_OBJECT = (
    Feature.TOWER,
    Feature.SKIRT,
    Feature.SUPPORT,
    Feature.SUPPORT_INTERFACE,
    Feature.BRIM,
    Feature.RAFT,
    Feature.OOZE_SHIELD,
)
"""Features that are not of the object; all others are."""

STUDIO_SIZE = 100.0
_RENDER_SECONDS = 0.5  # between looks whether a render has ended
_KINDS = ("scenes", "objects", "hair_curves", "meshes", "cameras", "lights", "worlds", "materials", "images")


class RenderStoppedError(Exception):
    """The user has stopped Blender's render."""


class Photographer:
    """Strands in the studio; made by `photographer`. Its pictures are generators that yield while they wait.

    Attributes:
        mm_per_pixel: at the middle of the object, of the latest picture.
    """

    def __init__(
        self, scene: bpy.types.Scene, studio: Studio, painted: bpy.types.Object | None, mm: float, in_window: bool
    ) -> None:
        self._scene, self._studio, self._painted, self._mm = scene, studio, painted, mm
        self._in_window, self._path = in_window, Path(scene.render.filepath)
        self._strands = [held for held in scene.objects if held.type == "CURVES"]
        self.mm_per_pixel = 0.0

    def picture(
        self, azimuth_deg: float, elevation_deg: float, *, steady: bool = False, painted: bool = False
    ) -> Generator[None, None, Picture]:
        """(H, W, 3) uint8 what the camera sees.

        Args:
            azimuth_deg: where the camera stands: 0 in front (-Y), positive to the right of it.
            elevation_deg: how far above the horizon it stands.
            steady: from the same distance whatever the azimuth.
            painted: of the model with its own tones, instead of its strands.

        Raises:
            ValueError: the model was not given.
            RenderStoppedError: by the user.
            PrintError: Blender renders something else.
        """
        if painted and self._painted is None:
            raise ValueError("the photographer was not given the model")
        self.mm_per_pixel = self._mm * self._studio.look(azimuth_deg, elevation_deg, steady)
        for held in self._strands:
            held.hide_render = painted
        if self._painted:
            self._painted.hide_render = not painted
        from PIL import Image

        self._path.unlink(missing_ok=True)
        yield from _rendered(self._scene, self._in_window)
        if not self._path.is_file():
            raise RenderStoppedError
        with Image.open(self._path) as image:
            return np.asarray(image.convert("RGB"))


@contextmanager
def photographer(
    collection: bpy.types.Collection,
    resolution: tuple[int, int],
    samples: int,
    whole_plate: bool = False,
    model: SurfaceModel | None = None,
    background: float = 0.5,
    in_window: bool = False,
) -> Iterator[Photographer]:
    """The strands of a preview set up in a scene of their own that is removed afterwards; nothing else is changed.

    Args:
        collection: made by `build_preview`.
        resolution: width and height in pixels.
        samples: of each pixel at most; even surfaces get as few as 8.
        whole_plate: with the cleaning tower, the skirt and the supports; otherwise the object alone.
        model: what the strands were made from, to be shown with its own tones.
        background: tone where nothing is painted on the model.
        in_window: as Blender's own Render Image does it: the picture is seen as it gets clearer, the windows answer,
            Esc stops it. Needs them to be drawn between the yields.

    Raises:
        PrintError: there are no strands to show.
    """
    import tempfile

    unit, folder = mm_per_unit(bpy.context.scene), Path(tempfile.mkdtemp())
    with leaving_no_trace(folder) as all_is_made:
        scene = bpy.data.scenes.new("Predicted Print")
        scene.render.filepath = str(folder / "picture.png")
        points, factor = _copy_strands(collection, scene, whole_plate)
        painted = painted_model(model, background, factor / unit) if model else None
        if painted:
            scene.collection.objects.link(painted)
        _set_output(scene, resolution, samples)
        studio = Studio(scene, points, resolution)
        if in_window:  # where the user may work meanwhile
            all_is_made()
        yield Photographer(scene, studio, painted, unit / factor, in_window)


def _rendered(scene: bpy.types.Scene, in_window: bool) -> Generator[None, None, None]:
    """Render a scene to its file, which is not there if the user stops it."""
    if not in_window:
        bpy.ops.render.render(write_still=True, scene=scene.name)
        return
    if "CANCELLED" in bpy.ops.render.render("INVOKE_DEFAULT", write_still=True, scene=scene.name):
        raise PrintError("Blender is rendering something else", "render the print when that has ended")
    while bpy.app.is_job_running("RENDER"):
        yield


def _copy_strands(
    collection: bpy.types.Collection, scene: bpy.types.Scene, whole_plate: bool
) -> tuple[FloatArray, float]:
    """Put copies of the wanted strands into the scene; (N, 3) all their points there, and the scale of the copies.

    The copies are scaled to one size, for rods of a tenth of a millimeter in a scene of meters are too thin for the
    renderer's single precision: it would add specks of light.
    """
    wanted = []
    for shown in strands_in(collection):
        points, counts, radius, labels = read_strands(shown)
        chosen = whole_plate | ~np.isin(labels["feature"], BESIDE_THE_OBJECT)
        of_point = np.repeat(chosen, counts)
        if of_point.any():
            wanted.append((shown, points[of_point], counts[chosen], radius[of_point]))
    if not wanted:
        raise PrintError("there are no strands to render", "generate the toolpath first")
    matrices = [np.array(shown.matrix_world) for shown, *_ in wanted]
    world = [in_world(points, matrix) for (_, points, *_), matrix in zip(wanted, matrices, strict=True)]
    factor = STUDIO_SIZE / float(np.linalg.norm(np.ptp(np.concatenate(world), axis=0)))
    for (shown, points, counts, radius), matrix in zip(wanted, matrices, strict=True):
        rods = render_rods(shown, points * factor, counts, radius * factor, scene)
        copy = bpy.data.objects.new(shown.name, rods)
        matrix[:3, 3] *= factor
        copy.matrix_world = Matrix(matrix.tolist())
        scene.collection.objects.link(copy)
    return np.concatenate(world) * factor, factor


def _set_output(scene: bpy.types.Scene, resolution: tuple[int, int], samples: int) -> None:
    render = scene.render
    render.engine, render.use_persistent_data = "CYCLES", True
    render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGB"
    render.resolution_x, render.resolution_y = resolution
    render.resolution_percentage = 100
    render.use_compositing = render.use_sequencer = False
    scene.view_settings.view_transform, scene.view_settings.look = "Standard", "None"
    set_drawing(scene)
    cycles = scene.cycles
    cycles.device, cycles.samples = _device(), samples
    cycles.use_adaptive_sampling, cycles.adaptive_threshold, cycles.adaptive_min_samples = True, 0.1, 8
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 4, 4, 2
    try:
        cycles.denoiser, cycles.use_denoising = "OPENIMAGEDENOISE", True
    except TypeError:  # this build of Blender has no denoiser, and so no such name in the list
        cycles.use_denoising = False


def _device() -> str:
    """GPU if the preferences of Cycles offer one, otherwise CPU."""
    addon = bpy.context.preferences.addons.get("cycles")
    chosen = addon.preferences if addon else None
    if chosen is None or getattr(chosen, "compute_device_type", "NONE") == "NONE":
        return "CPU"
    return "GPU" if any(device.use and device.type != "CPU" for device in chosen.devices) else "CPU"


@contextmanager
def leaving_no_trace(folder: Path | None = None) -> Iterator[Callable[[], None]]:
    """Remove every datablock that is created inside, and a folder; what is being rendered still, once that has ended.

    So it is when the extension is disabled, or Blender closed, while it renders. What is created after a call of the
    function that it gives stays.
    """
    before, made = _datablocks(), None

    def all_is_made() -> None:
        nonlocal made
        made = _datablocks() - before

    try:
        yield all_is_made
    finally:
        made = _datablocks() - before if made is None else made
        if (seconds := _removed(made, folder)) is not None:
            bpy.app.timers.register(partial(_removed, made, folder), first_interval=seconds)


def _removed(made: set[tuple[str, int]], folder: Path | None) -> float | None:
    """Remove datablocks and a folder, or say in how many seconds it is to be tried again.

    Blender would wait for the end of a render whose scene is taken away, and the render for Blender.
    """
    if bpy.app.is_job_running("RENDER"):
        return _RENDER_SECONDS
    for kind in _KINDS:
        held = getattr(bpy.data, kind)
        for each in [each for each in held if (kind, each.session_uid) in made]:
            held.remove(each)
    if folder:
        shutil.rmtree(folder, ignore_errors=True)
    return None


def _datablocks() -> set[tuple[str, int]]:
    """All that there is of the kinds that a studio is made of."""
    return {(kind, each.session_uid) for kind in _KINDS for each in getattr(bpy.data, kind)}

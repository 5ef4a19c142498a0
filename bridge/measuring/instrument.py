"""The measuring camera: linear pictures of strands in even light (paper, section 6.1).

The gonioreflectometer stands before a flat face of the print. At φ = θ = 0 it looks along the face's normal; φ lifts it
above the face and θ turns it to the right, about the up direction in the face.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ...core.errors import PrintError
from ...core.model import Float32Array, FloatArray
from ...core.records import dataclass
from ...core.settings import PrintSettings
from ...core.strands.settling import settled
from ...core.strands.strands import strands
from ...core.toolpaths.moves import Moves
from ..pictures.render import BESIDE_THE_OBJECT, leaving_no_trace
from ..pictures.render_rods import render_rods
from ..pictures.studio import camera_axes
from ..strands.strand_curves import draws_straight, read_strands, set_drawing, strand_objects

_LAMP_SHARE = 0.5
_LAMP_FROM_NORMAL_RAD = math.radians(45.0)
_LAMP_SIZE_RAD = math.radians(10.0)
_BOUNCES = 8
_ROUNDNESS_LEVELS = 13  # steps of 2 % of the diameter: with few of them tones would jump from one to the next


@dataclass(frozen=True)
class Face:
    """The flat rectangle that the camera measures.

    Attributes:
        center: (3,) mm, in the coordinates of the moves.
        width: mm, along the layers.
        height: mm, up the face.
        slant_deg: 0 an upright face, towards 90 one that looks up.
        azimuth_deg: where it looks: 0 to the front (-Y), positive to the right (+X).
    """

    center: tuple[float, float, float]
    width: float
    height: float
    slant_deg: float = 0.0
    azimuth_deg: float = 0.0

    @property
    def axes(self) -> FloatArray:
        """(3, 3), rows are the face's right, its up and its outward normal."""
        return camera_axes(math.radians(self.azimuth_deg), math.radians(self.slant_deg))


def view_axes(face: Face, phi_deg: float, theta_deg: float) -> FloatArray:
    """(3, 3), rows are the camera's right, its up, and the direction from the face to it."""
    sp, cp = math.sin(math.radians(phi_deg)), math.cos(math.radians(phi_deg))
    st, ct = math.sin(math.radians(theta_deg)), math.cos(math.radians(theta_deg))
    lifted = np.array([[1.0, 0.0, 0.0], [0.0, cp, -sp], [0.0, sp, cp]])
    turned = np.array([[ct, 0.0, -st], [0.0, 1.0, 0.0], [st, 0.0, ct]])
    return lifted @ turned @ face.axes


def photograph(
    moves: Moves,
    settings: PrintSettings,
    face: Face,
    *,
    phi_deg: float = 0.0,
    theta_deg: float = 0.0,
    mm_per_pixel: float = 0.1,
    samples: int = 16,
    light: str = "even",
) -> Float32Array:
    """One picture of a face of a print; see `Stand.photograph`. For several, `mounted` sets the scene up only once."""
    with mounted(moves, settings, face, light) as stand:
        return stand.photograph(phi_deg=phi_deg, theta_deg=theta_deg, mm_per_pixel=mm_per_pixel, samples=samples)


class Stand:
    """A print before the camera; made by `mounted`."""

    def __init__(self, scene: bpy.types.Scene, face: Face, reach: float) -> None:
        self._scene, self._face, self._reach = scene, face, reach

    def photograph(
        self,
        *,
        phi_deg: float = 0.0,
        theta_deg: float = 0.0,
        mm_per_pixel: float = 0.1,
        samples: int = 16,
        seed: int = 0,
    ) -> Float32Array:
        """A picture of the face with foreshortening undone: a pixel is `mm_per_pixel` of the face both ways.

        If only one of the angles is not 0; turned both ways, the picture is also sheared.

        Args:
            phi_deg: above the face's normal, within ±90 exclusive.
            theta_deg: to the right of it, within ±90 exclusive.
            mm_per_pixel: on the face.
            samples: of each pixel.
            seed: of the noise; the same seed gives the same picture.

        Returns:
            (H, W) float32 linear reflectance, row 0 at the top: a white surface that is lit like any other reads its
            reflectance, 0.8 for a matt one of 0.8. NaN where the camera looks past the print.
        """
        scene, face = self._scene, self._face
        render = scene.render
        render.resolution_x = max(round(face.width / mm_per_pixel), 1)
        render.resolution_y = max(round(face.height / mm_per_pixel), 1)
        flat_x, flat_y = math.cos(math.radians(theta_deg)), math.cos(math.radians(phi_deg))
        # The rectangle is covered exactly, so pixels are not quite square.
        across, up = flat_x * face.width / render.resolution_x, flat_y * face.height / render.resolution_y
        render.pixel_aspect_x, render.pixel_aspect_y = max(across / up, 1.0), max(up / across, 1.0)
        axes = view_axes(face, phi_deg, theta_deg)
        camera = scene.camera
        camera.data.ortho_scale = face.width * flat_x
        camera.matrix_world = _matrix(axes, axes[2] * 2 * self._reach)
        _set_samples(scene, samples, seed)
        return _developed(scene)


@contextmanager
def mounted(moves: Moves, settings: PrintSettings, face: Face, light: str = "even") -> Iterator[Stand]:
    """A print set up before the camera, in a scene of its own that is removed afterwards; nothing else is changed.

    Only the object itself is: tower, skirt and supports are left out.

    Args:
        moves: of the print.
        settings: sag and black_tool are used.
        face: what to look at.
        light: "even" from all directions, or "lamp": half of it comes from one side, 45° above the face.

    Raises:
        PrintError: the print has no strands.
    """
    laid = settled(strands(moves), settings.sag)
    laid = laid.selected(~np.isin(laid.feature, BESIDE_THE_OBJECT))
    if not len(laid):
        raise PrintError("there are no strands to photograph", "generate the toolpath first")
    with leaving_no_trace():
        scene = bpy.data.scenes.new("Instrument")
        center = np.array(face.center)
        for made in strand_objects(laid, settings.black_tool, 1.0, -center, levels=_ROUNDNESS_LEVELS):
            if not draws_straight(scene):
                made.data = render_rods(made, *read_strands(made)[:3], scene)
            scene.collection.objects.link(made)
        reach = float(np.linalg.norm(laid.points - center, axis=1).max()) + face.width + face.height
        yield stand_before(scene, face, reach, light)


def stand_before(scene: bpy.types.Scene, face: Face, reach: float, light: str = "even") -> Stand:
    """Put the camera and the light into a scene.

    Args:
        scene: what it holds stands so that the middle of the face is the origin.
        face: what to look at.
        reach: nothing is farther from the origin.
        light: see `mounted`.
    """
    _add_camera(scene, reach)
    _add_light(scene, face, light)
    _set_output(scene)
    return Stand(scene, face, reach)


def _add_camera(scene: bpy.types.Scene, reach: float) -> None:
    data = bpy.data.cameras.new("Instrument")
    data.type, data.sensor_fit = "ORTHO", "HORIZONTAL"
    data.clip_start, data.clip_end = reach / 100, 4 * reach
    scene.camera = bpy.data.objects.new("Instrument", data)
    scene.collection.objects.link(scene.camera)


def _add_light(scene: bpy.types.Scene, face: Face, light: str) -> None:
    """Light under which a matt plane in the face reads its reflectance."""
    share = _LAMP_SHARE if light == "lamp" else 0.0
    world = bpy.data.worlds.new("Instrument")
    if world.node_tree is None:  # Blender 5 gives every world its nodes and warns about this line
        world.use_nodes = True
    nodes = world.node_tree.nodes
    nodes.clear()
    dome, output = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    dome.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    dome.inputs["Strength"].default_value = 1.0 - share
    world.node_tree.links.new(dome.outputs["Background"], output.inputs["Surface"])
    world.cycles.sampling_method = "NONE"  # even light is found by any ray: none need be aimed
    scene.world = world
    if not share:
        return
    lamp = bpy.data.lights.new("Instrument", "SUN")
    lamp.energy, lamp.angle = share * math.pi / math.cos(_LAMP_FROM_NORMAL_RAD), _LAMP_SIZE_RAD
    right, up, out = face.axes
    toward = math.cos(_LAMP_FROM_NORMAL_RAD) * out + math.sin(_LAMP_FROM_NORMAL_RAD) * (up - right) / math.sqrt(2)
    side = np.cross(up, toward) / np.linalg.norm(np.cross(up, toward))
    made = bpy.data.objects.new("Instrument", lamp)
    made.matrix_world = _matrix(np.stack([side, np.cross(toward, side), toward]), np.zeros(3))
    scene.collection.objects.link(made)


def _set_output(scene: bpy.types.Scene) -> None:
    """Plain linear values: no tone mapping, no denoiser, the same number of samples everywhere."""
    render = scene.render
    render.engine, render.resolution_percentage = "CYCLES", 100
    render.film_transparent, render.use_persistent_data = True, True
    render.use_compositing = render.use_sequencer = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode, render.image_settings.color_depth = "RGBA", "32"
    scene.view_settings.view_transform, scene.view_settings.look = "Raw", "None"
    set_drawing(scene)
    cycles = scene.cycles
    cycles.device, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", False, False
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = _BOUNCES
    cycles.sample_clamp_indirect = 0.0  # a clamp would take light away


def _set_samples(scene: bpy.types.Scene, samples: int, seed: int) -> None:
    """All samples but the very first: that is the middle of every pixel, and where pixels keep step with the layers
    all of them would hit the strands alike."""
    cycles = scene.cycles
    cycles.samples, cycles.sample_offset, cycles.seed = samples + 1, 1, seed
    if hasattr(cycles, "use_sample_subset"):  # since Blender 5.0
        cycles.use_sample_subset, cycles.sample_subset_length = True, samples


def _developed(scene: bpy.types.Scene) -> Float32Array:
    """(H, W) the rendered picture; Blender gives float pictures only by way of a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.exr"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True, scene=scene.name)
        image = bpy.data.images.load(str(path))
        width, height = image.size
        pixels = np.empty(width * height * 4, dtype=np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    rgba = pixels.reshape(height, width, 4)[::-1]
    covered = rgba[..., 3] > 0
    seen: Float32Array = np.full((height, width), np.nan, dtype=np.float32)
    seen[covered] = rgba[covered, :3].mean(axis=1) / rgba[covered, 3]
    return seen


def _matrix(axes: FloatArray, place: FloatArray) -> Matrix:
    """The matrix of an object at a place, with the rows of `axes` as its axes x, y, z."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = axes.T, place
    return Matrix(matrix.tolist())

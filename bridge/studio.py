"""The studio of the predicted print: camera, backdrop and soft white light, all sized to the object."""

from __future__ import annotations

import math

import bpy
import numpy as np
from mathutils import Matrix

from ..core.model import FloatArray
from .plastics import diffuse_material

_HALF_ANGLE_RAD = math.radians(11.0)
_MARGIN = 0.86
_BACKDROP_REFLECTANCE = 0.55
_DOME_RADIANCE = 0.42
_KEY_RADIANCE = 2.3
_KEY_EDGE = -0.1


def camera_axes(azimuth_rad: float, elevation_rad: float) -> FloatArray:
    """(3, 3): rows are the camera's right, its up, and the direction from the object to it."""
    ca, sa, ce, se = math.cos(azimuth_rad), math.sin(azimuth_rad), math.cos(elevation_rad), math.sin(elevation_rad)
    return np.array([[ca, sa, 0.0], [-sa * se, ca * se, ce], [sa * ce, -ca * ce, se]])


def camera_place(points: FloatArray, axes: FloatArray, half_width: float, half_height: float) -> FloatArray:
    """(3,) nearest place from which a camera sees all points.

    Each side of its pyramid of view is a half-space that must hold all points; where the pair left-right or top-bottom
    is the tighter one it sets the distance, and the other pair is centred.

    Args:
        points: (N, 3).
        axes: rows right, up, backward.
        half_width: tangent of half the horizontal angle of view.
        half_height: tangent of half the vertical one.
    """
    right, up, back = (points @ axes.T).T
    low_x, high_x = (right + back * half_width).max(), (right - back * half_width).min()
    low_y, high_y = (up + back * half_height).max(), (up - back * half_height).min()
    distance = max((low_x - high_x) / (2 * half_width), (low_y - high_y) / (2 * half_height))
    return np.array([(low_x + high_x) / 2, (low_y + high_y) / 2, distance]) @ axes


def add_camera(scene: bpy.types.Scene, points: FloatArray, axes: FloatArray, resolution: tuple[int, int]) -> None:
    """A camera that frames the points."""
    width, height = resolution
    wide, long = math.tan(_HALF_ANGLE_RAD), max(resolution)
    data = bpy.data.cameras.new("Studio")
    data.sensor_fit, data.angle = "AUTO", 2 * _HALF_ANGLE_RAD
    place = camera_place(points, axes, wide * _MARGIN * width / long, wide * _MARGIN * height / long)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    data.clip_start, data.clip_end = size / 1000, size * 100
    scene.camera = _placed(scene, data, place, axes)


def add_backdrop(scene: bpy.types.Scene, points: FloatArray, axes: FloatArray) -> None:
    """A floor under the points that bends up behind them into a wall, as in a photographer's studio."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.linalg.norm(high - low))
    right = axes[0]
    behind = np.cross((0.0, 0.0, 1.0), right)
    turn = np.linspace(0.0, math.pi / 2, 24)
    bend, far = 3.0 * size, 3.0 * size
    along = np.concatenate([[-20 * size], far + bend * np.sin(turn), [far + bend]])
    up = np.concatenate([[0.0], bend * (1 - np.cos(turn)), [20 * size]])
    middle = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2] - size * 1e-3])
    profile = middle + along[:, None] * behind + up[:, None] * (0.0, 0.0, 1.0)
    sides = np.concatenate([profile - right * 20 * size, profile + right * 20 * size])
    n = len(profile)
    faces = [(i, i + n, i + n + 1, i + 1) for i in range(n - 1)]
    mesh = bpy.data.meshes.new("Backdrop")
    mesh.from_pydata(sides.tolist(), [], faces)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), dtype=bool))
    mesh.materials.append(diffuse_material("Backdrop", _BACKDROP_REFLECTANCE, 1.0, 1.0))
    scene.collection.objects.link(bpy.data.objects.new("Backdrop", mesh))


def add_lights(scene: bpy.types.Scene, axes: FloatArray) -> None:
    """A white dome that is brighter above the camera's left shoulder, as with a large soft key light.

    All light comes from the dome, which has no edges: so rays find it by themselves, and nothing is spent on aiming
    shadow rays at lamps. That halves the time.
    """
    level = axes[2] * (1.0, 1.0, 0.0)
    key = level / np.linalg.norm(level) - 0.9 * axes[0] + (0.0, 0.0, 1.2)
    world = bpy.data.worlds.new("Studio")
    if world.node_tree is None:  # Blender 5 gives every world its nodes and warns about this line
        world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    direction = nodes.new("ShaderNodeTexCoord")
    toward = nodes.new("ShaderNodeVectorMath")
    toward.operation = "DOT_PRODUCT"
    toward.inputs[1].default_value = tuple(key / np.linalg.norm(key))
    strength = nodes.new("ShaderNodeMapRange")
    strength.interpolation_type = "SMOOTHSTEP"
    strength.inputs["From Min"].default_value, strength.inputs["From Max"].default_value = _KEY_EDGE, 1.0
    strength.inputs["To Min"].default_value, strength.inputs["To Max"].default_value = _DOME_RADIANCE, _KEY_RADIANCE
    dome = nodes.new("ShaderNodeBackground")
    output = nodes.new("ShaderNodeOutputWorld")
    links.new(direction.outputs["Generated"], toward.inputs[0])
    links.new(toward.outputs["Value"], strength.inputs["Value"])
    links.new(strength.outputs["Result"], dome.inputs["Strength"])
    links.new(dome.outputs["Background"], output.inputs["Surface"])
    world.cycles.sampling_method = "NONE"
    scene.world = world


def _placed(
    scene: bpy.types.Scene, data: bpy.types.Camera | bpy.types.Light, place: FloatArray, axes: FloatArray
) -> bpy.types.Object:
    """An object of the data in the scene whose axes x, y, z are the rows of `axes`."""
    made = bpy.data.objects.new(data.name, data)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = axes.T, place
    made.matrix_world = Matrix(matrix.tolist())
    scene.collection.objects.link(made)
    return made

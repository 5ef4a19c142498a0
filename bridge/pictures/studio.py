"""The studio of the predicted print: camera, backdrop and soft white light, all sized to the object."""

from __future__ import annotations

import math

import bpy
import numpy as np
from mathutils import Matrix

from ...core.model import FloatArray
from .plastics import diffuse_material

_HALF_ANGLE_RAD = math.radians(11.0)
_MARGIN = 0.86
_BACKDROP_REFLECTANCE = 0.55
_DOME_RADIANCE = 0.42
_KEY_RADIANCE = 2.3
_KEY_EDGE = -0.1
_RING = 48  # points around an object that turns


def camera_axes(azimuth_rad: float, elevation_rad: float) -> FloatArray:
    """(3, 3): rows are the camera's right, its up, and the direction from the object to it."""
    ca, sa, ce, se = math.cos(azimuth_rad), math.sin(azimuth_rad), math.cos(elevation_rad), math.sin(elevation_rad)
    return np.array([[ca, sa, 0.0], [-sa * se, ca * se, ce], [sa * ce, -ca * ce, se]])


def camera_place(points: FloatArray, axes: FloatArray, half_width: float, half_height: float) -> FloatArray:
    """(3,) nearest place from which a camera sees all points.

    Each side of its pyramid of view is a half-space that must hold all points; where the pair left-right or top-bottom
    is the tighter one it sets the distance, and the other pair is centered.

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


def swept(points: FloatArray) -> FloatArray:
    """(M, 3) points around the space that some points need when they turn about their upright middle line."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = np.hypot(*(points[:, :2] - middle[:2]).T)
    low, size = points[:, 2].min(), max(float(np.ptp(points[:, 2])), 1e-9)
    level = np.minimum((points[:, 2] - low) / size * 32, 31).astype(np.int64)
    widest = np.zeros(32)
    np.maximum.at(widest, level, radius)
    turn = np.linspace(0.0, 2 * math.pi, _RING, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    heights = low + size / 32 * np.array([np.arange(32), np.arange(1, 33)])
    flat = middle[:2] + widest[:, None, None] * ring
    return np.concatenate([np.dstack([flat, np.repeat(z[:, None], _RING, axis=1)]).reshape(-1, 3) for z in heights])


class Studio:
    """Camera, backdrop and light in a scene, which turn around the object together."""

    def __init__(self, scene: bpy.types.Scene, points: FloatArray, resolution: tuple[int, int]) -> None:
        """Set it up around (N, 3) points, for pictures of so many pixels in width and height."""
        self._scene, self._points, self._resolution = scene, points, resolution
        self._swept: FloatArray | None = None
        size = float(np.linalg.norm(np.ptp(points, axis=0)))
        data = bpy.data.cameras.new("Studio")
        data.sensor_fit, data.angle = "AUTO", 2 * _HALF_ANGLE_RAD
        data.clip_start, data.clip_end = size / 1000, size * 100
        scene.camera = bpy.data.objects.new("Studio", data)
        self._backdrop = _backdrop(points, size)
        for made in (scene.camera, self._backdrop):
            scene.collection.objects.link(made)
        self._key = _dome(scene)

    def look(self, azimuth_deg: float, elevation_deg: float, steady: bool = False) -> float:
        """Turn to a side and frame the object.

        Args:
            azimuth_deg: where the camera stands: 0 in front (-Y), positive to the right of it.
            elevation_deg: how far above the horizon it stands.
            steady: keep the distance from which the object fits the picture from all azimuths.

        Returns:
            Size of a pixel at the middle of the object, in the scene's units.
        """
        azimuth = math.radians(azimuth_deg)
        axes = camera_axes(azimuth, math.radians(elevation_deg))
        points = self._points
        if steady:
            self._swept = points = swept(points) if self._swept is None else self._swept
        width, height = self._resolution
        wide, long = math.tan(_HALF_ANGLE_RAD), max(self._resolution)
        place = camera_place(points, axes, wide * _MARGIN * width / long, wide * _MARGIN * height / long)
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = axes.T, place
        self._scene.camera.matrix_world = Matrix(matrix.tolist())
        self._backdrop.rotation_euler[2] = azimuth
        level = axes[2] * (1.0, 1.0, 0.0)
        key = level / np.linalg.norm(level) - 0.9 * axes[0] + (0.0, 0.0, 1.2)
        self._key.default_value = tuple(key / np.linalg.norm(key))
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        return float((place - middle) @ axes[2]) * 2 * wide / long


def _backdrop(points: FloatArray, size: float) -> bpy.types.Object:
    """A floor under the points that bends up behind them into a wall, as in a photographer's studio."""
    low, high = points.min(axis=0), points.max(axis=0)
    turn = np.linspace(0.0, math.pi / 2, 24)
    bend, far = 3.0 * size, 3.0 * size
    along = np.concatenate([[-20 * size], far + bend * np.sin(turn), [far + bend]])
    up = np.concatenate([[0.0], bend * (1 - np.cos(turn)), [20 * size]])
    n = len(along)
    across = np.repeat([-20 * size, 20 * size], n)
    corners = np.column_stack([across, np.tile(along, 2), np.tile(up, 2)])
    faces = [(i, i + n, i + n + 1, i + 1) for i in range(n - 1)]
    mesh = bpy.data.meshes.new("Backdrop")
    mesh.from_pydata(corners.tolist(), [], faces)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), dtype=bool))
    mesh.materials.append(diffuse_material("Backdrop", _BACKDROP_REFLECTANCE, 1.0, 1.0))
    made = bpy.data.objects.new("Backdrop", mesh)
    made.location = (*((low + high) / 2)[:2], low[2] - size * 1e-3)
    return made


def _dome(scene: bpy.types.Scene) -> bpy.types.NodeSocket:
    """A white dome that is brighter on one side, as with a large soft key light; returns where to.

    All light comes from the dome, which has no edges: so rays find it by themselves, and nothing is spent on aiming
    shadow rays at lamps. That halves the time.
    """
    world = bpy.data.worlds.new("Studio")
    if world.node_tree is None:  # Blender 5 gives every world its nodes and warns about this line
        world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    direction = nodes.new("ShaderNodeTexCoord")
    toward = nodes.new("ShaderNodeVectorMath")
    toward.operation = "DOT_PRODUCT"
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
    return toward.inputs[1]

"""The sample that the program makes itself: a bust of Blender's Suzanne in a calico coat."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

from ...core.model import Float32Array
from ...core.texture.decode import srgb_from_linear
from ..materials import new_material, picture_node
from ..paint.ambient_occlusion import occlusion
from ..paint.unwrap import unwrap
from ..units import use_millimeters

NAME = "Suzanne"
HEIGHT_MM = 60.0
AO_SAMPLES = 20
IMAGE_SIZE = 1024
SUBDIVISIONS = 2
CHIN_CUT = -0.94  # heights in the primitive's own units, in which the head reaches from -0.98 to 0.98
NECK_TOP = -0.2

WHITE, GINGER, BLACK = np.array([[0.86, 0.83, 0.78], [0.45, 0.19, 0.055], [0.018, 0.016, 0.015]], dtype=np.float32)
"""Linear RGB of the coat."""


def make_sample() -> bpy.types.Object:
    """Replace what is open by the sample: 60 mm tall, watertight, unwrapped, its coat and shading in an image.

    Raises:
        PrintError: xatlas is not installed.
    """
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    use_millimeters(bpy.context.scene)
    obj = bpy.data.objects.new(NAME, _bust())
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    unwrap(obj, "xatlas")
    node = _image_node(obj)
    position = _baked(node, "POSITION")
    shade = occlusion(obj, (IMAGE_SIZE, IMAGE_SIZE), samples=AO_SAMPLES)
    node.image = _image(coat(position.reshape(-1, 3) / HEIGHT_MM).reshape(position.shape) * shade[..., None])
    return obj


def _bust() -> bpy.types.Mesh:
    """Suzanne subdivided, her eyes and sockets closed, her chin cut flat and a neck put under her head."""
    work = bmesh.new()
    work.from_mesh(_smooth_head())
    bmesh.ops.holes_fill(work, edges=[edge for edge in work.edges if edge.is_boundary], sides=0)
    everything = [*work.verts, *work.edges, *work.faces]
    bmesh.ops.bisect_plane(
        work, geom=everything, plane_co=(0, 0, CHIN_CUT), plane_no=(0, 0, -1), clear_outer=True, dist=1e-6
    )
    bmesh.ops.holes_fill(work, edges=[edge for edge in work.edges if edge.is_boundary], sides=0)
    middle = Matrix.Translation((0, 0.05, (CHIN_CUT + NECK_TOP) / 2))
    bmesh.ops.create_cone(
        work,
        cap_ends=True,
        segments=96,
        radius1=0.55,
        radius2=0.35,
        depth=NECK_TOP - CHIN_CUT,
        matrix=middle,
    )
    bmesh.ops.recalc_face_normals(work, faces=work.faces)
    top = max(vertex.co.z for vertex in work.verts)
    stand = Matrix.Scale(HEIGHT_MM / (top - CHIN_CUT), 4) @ Matrix.Translation((0, 0, -CHIN_CUT))
    bmesh.ops.transform(work, matrix=stand, verts=work.verts)
    bmesh.ops.triangulate(work, faces=work.faces)
    mesh = bpy.data.meshes.new(NAME)
    work.to_mesh(mesh)
    work.free()
    return mesh


def _smooth_head() -> bpy.types.Mesh:
    bpy.ops.mesh.primitive_monkey_add(size=2)
    head = bpy.context.object
    modifier = head.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = SUBDIVISIONS
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(head.evaluated_get(depsgraph))
    bpy.data.objects.remove(head)
    return mesh


def _image_node(obj: bpy.types.Object) -> bpy.types.ShaderNodeTexImage:
    """A material on the object whose base color is an image, still to be set; the node is the one to bake into."""
    material = new_material("Calico coat")
    obj.data.materials.append(material)
    return picture_node(material)


def _baked(node: bpy.types.ShaderNodeTexImage, kind: str) -> Float32Array:
    """(H, W, 3) what Cycles bakes of the active object into a picture, one sample a texel."""
    bpy.context.scene.render.engine = "CYCLES"
    bpy.context.scene.cycles.samples = 1
    node.image = bpy.data.images.new(kind, IMAGE_SIZE, IMAGE_SIZE, float_buffer=True, is_data=True)
    bpy.ops.object.bake(type=kind, margin=8, margin_type="EXTEND", use_clear=True)
    pixels = np.empty(IMAGE_SIZE * IMAGE_SIZE * 4, dtype=np.float32)
    node.image.pixels.foreach_get(pixels)
    bpy.data.images.remove(node.image)
    return pixels.reshape(IMAGE_SIZE, IMAGE_SIZE, 4)[..., :3]


def _image(linear: Float32Array) -> bpy.types.Image:
    """A packed byte image of linear colors (H, W, 3)."""
    rgba = np.ones((*linear.shape[:2], 4), dtype=np.float32)
    rgba[..., :3] = srgb_from_linear(np.clip(linear, 0.0, 1.0))
    image = bpy.data.images.new("Calico coat", linear.shape[1], linear.shape[0])
    image.pixels.foreach_set(rgba.ravel())
    image.pack()
    return image


def coat(points: Float32Array) -> Float32Array:
    """Linear RGB (N, 3) of a calico cat at points (N, 3), in lengths of the body: white, ginger and black patches."""
    ginger = _patches(points, seed=11, share=0.05)
    black = _patches(points, seed=5, share=0.05)
    color = WHITE + (GINGER - WHITE) * ginger[:, None]
    return color + (BLACK - color) * black[:, None]


def _patches(points: Float32Array, seed: int, share: float) -> Float32Array:
    """(N,) 0 to 1: large spots with ragged edges; the greater `share`, the more is covered."""
    field = value_noise(points * 3.2, seed) + 0.22 * value_noise(points * 13.0, seed + 1)
    return np.clip((field - (0.61 + 0.11) + share) / 0.03 + 0.5, 0.0, 1.0)


def value_noise(points: Float32Array, seed: int) -> Float32Array:
    """(N,) smooth noise from 0 to 1 at points (N, 3): random values on the integer lattice, blended smoothly."""
    size = 16
    lattice = np.random.default_rng(seed).random((size, size, size)).astype(np.float32)
    cell = np.floor(points)
    share = (points - cell).astype(np.float32).T
    x, y, z = share * share * (3.0 - 2.0 * share)
    near = cell.astype(np.int32).T % size
    far = (near + 1) % size
    along_x = {
        (j, k): lattice[near[0], row, slab] * (1 - x) + lattice[far[0], row, slab] * x
        for j, row in enumerate((near[1], far[1]))
        for k, slab in enumerate((near[2], far[2]))
    }
    below, above = (along_x[0, k] * (1 - y) + along_x[1, k] * y for k in (0, 1))
    noise: Float32Array = below * (1 - z) + above * z
    return noise

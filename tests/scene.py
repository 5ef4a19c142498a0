"""Small Blender scenes for tests, each fresh."""

import itertools

import bpy
import numpy as np
from dualcolor.bridge.input.mesh_input import surface_model
from dualcolor.bridge.units import use_millimeters
from dualcolor.core.settings import PrintSettings

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
CUBE_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]

DATA_KINDS = ("scenes", "collections", "objects", "hair_curves", "meshes", "cameras", "lights", "worlds", "materials")


def fresh(millimeters=True):
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    if millimeters:
        use_millimeters(bpy.context.scene)


def add_mesh(vertices, faces, name="thing"):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices).tolist(), [], faces)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    return obj


def add_box(size=(1, 1, 1), name="box"):
    """A box with a corner at the origin; outward faces: -x, +x, -y, +y, -z, +z."""
    return add_mesh(CUBE * np.array(size), CUBE_FACES, name)


def add_uvs(obj, value=None, name="UVMap"):
    layer = obj.data.uv_layers.new(name=name)
    uv = np.tile([[0, 0], [1, 0], [1, 1], [0, 1]], (len(obj.data.polygons), 1)) if value is None else value
    layer.uv.foreach_set("vector", np.broadcast_to(uv, (len(obj.data.loops), 2)).astype(np.float32).ravel())
    return layer


def flat_image(rgba, name="picture", size=4, is_float=False, is_data=False):
    image = bpy.data.images.new(name, size, size, alpha=True, float_buffer=is_float, is_data=is_data)
    image.pixels.foreach_set(np.tile(np.array(rgba, dtype=np.float32), size * size))
    return image


def add_material(obj, image=None, color=None, shader="BSDF_PRINCIPLED"):
    """A material with a picture or a plain color; returns it and its node tree."""
    material = bpy.data.materials.new("material")
    if material.node_tree is None:
        material.use_nodes = True  # before Blender 5
    tree = material.node_tree
    node = next(each for each in tree.nodes if each.type == "BSDF_PRINCIPLED")
    if shader != "BSDF_PRINCIPLED":
        node = tree.nodes.new(shader)
        tree.links.new(node.outputs[0], tree.get_output_node("ALL").inputs["Surface"])
    socket = node.inputs[0]
    if color is not None:
        socket.default_value = color
    if image is not None:
        picture = tree.nodes.new("ShaderNodeTexImage")
        picture.image = image
        tree.links.new(picture.outputs["Color"], socket)
    obj.data.materials.append(material)
    return material, tree


def give_by_nodes(obj, material):
    """Have Geometry Nodes give all faces a material, which is then in no slot of the object."""
    group = bpy.data.node_groups.new("give", "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    node = group.nodes.new("GeometryNodeSetMaterial")
    node.inputs["Material"].default_value = material
    group.links.new(group.nodes.new("NodeGroupInput").outputs[0], node.inputs["Geometry"])
    group.links.new(node.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    obj.modifiers.new("Give", "NODES").node_group = group


def model_of(obj, image=None, **settings):
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return surface_model(obj, depsgraph, PrintSettings(**settings), image)


def volume(model):
    """Signed volume of the closed polygons, mm³: positive when they face outward."""
    total = 0.0
    for start, end in zip(model.polygon_start[:-1], model.polygon_start[1:], strict=True):
        corners = model.vertices[model.corner_vertex[start:end]]
        for b, c in itertools.pairwise(corners):
            total += np.dot(corners[0], np.cross(b, c)) / 6
    return total


def extent(model):
    return np.ptp(model.vertices, axis=0)


def datablocks() -> dict[str, list[str]]:
    """Names of all data of the kinds that a job may add, by kind."""
    return {kind: sorted(held.name for held in getattr(bpy.data, kind)) for kind in DATA_KINDS}

"""The soft proof of a flat face as numbers, to be compared with a photograph of the print."""

from __future__ import annotations

import bpy
import numpy as np
from dualcolor.bridge.input.printed_materials import is_proof
from dualcolor.bridge.measuring.instrument import Face, stand_before
from dualcolor.bridge.pictures.render import leaving_no_trace
from dualcolor.bridge.proof.proof_nodes import SHOWN
from dualcolor.core.model import Float32Array
from mathutils import Matrix, Vector


def proof_picture(obj: bpy.types.Object, face: Face, mm_per_pixel: float, samples: int = 4) -> Float32Array:
    """What the proof shows of a face, rendered by Cycles from the same nodes that the viewport draws.

    Args:
        obj: an object that is shown as it will print, in a scene of millimeters.
        face: the rectangle to look at, where the object stands.
        mm_per_pixel: on the face.
        samples: of each pixel.

    Returns:
        (H, W) reflectance, the mean of red, green and blue where the face is marked as too flat; row 0 at the top, NaN
        where the camera looks past the object.
    """
    with leaving_no_trace():
        copy = obj.copy()
        for slot in copy.material_slots:
            if is_proof(slot.material):
                slot.material = _shining(slot.material)
        copy.matrix_world = Matrix.Translation([-place for place in face.center]) @ obj.matrix_world
        scene = bpy.data.scenes.new("Soft Proof")
        scene.collection.objects.link(copy)
        corners = np.array([copy.matrix_world @ Vector(corner) for corner in obj.bound_box])
        reach = float(np.linalg.norm(corners, axis=1).max()) + face.width + face.height
        return stand_before(scene, face, reach).photograph(mm_per_pixel=mm_per_pixel, samples=samples)


def _shining(proof: bpy.types.Material) -> bpy.types.Material:
    """The same material with its color as emission instead of lit."""
    made = proof.copy()
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shine = nodes.new("ShaderNodeEmission")
    links.new(nodes[SHOWN].outputs[0], shine.inputs["Color"])
    links.new(shine.outputs["Emission"], made.node_tree.get_output_node("ALL").inputs["Surface"])
    return made

"""The soft proof: an object shown as it will print while it is painted, and afterwards exactly as it was.

Proof materials are laid over the object's own by way of its material slots, which hold one for the mesh and one for the
object: the own materials, the mesh and its attributes are not touched, and other objects with the same mesh keep their
looks. What a slot held before is stored in the proof material itself, so it survives saving the file.
"""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import replace

import bpy
import numpy as np

from ...core.analysis.soft_proof import ProofTable, proof_settings, proof_table, proof_window, repeats, tone_range
from ...core.errors import PrintError
from ...core.settings import PrintSettings
from ..input.base_color import BaseColor, base_color, chosen_color, color_layer, picture_layer
from ..input.mesh_input import surface_model
from ..input.printed_materials import COVERED_KEY, PROOF_KEY, is_proof, printed_materials
from ..units import mm_per_unit
from .proof_nodes import ACROSS, BACKGROUND, GRADIENT, RESPONSE, STRIPES, UP, Paint, proof_material, set_number

_NO_SLOT = "NONE"
_RANGE_KEY, _STATE_KEY, _NOTES_KEY = "dualcolor_range", "dualcolor_state", "dualcolor_notes"
_GRADIENT_MM = 25.0  # over which a picture's U and V change by some tenths
_STRIPES_MM = 3.0


def is_proofed(obj: bpy.types.Object) -> bool:
    """Whether an object is shown as it will print."""
    return any(is_proof(slot.material) for slot in obj.material_slots)


def show_proof(obj: bpy.types.Object, settings: PrintSettings) -> None:
    """Show a mesh object as it will print; an existing proof is updated to its present paint.

    Raises:
        PrintError: it has no surface, a picture is missing or has no UV map, or the tone table cannot be read.
    """
    depsgraph = bpy.context.evaluated_depsgraph_get()
    model = surface_model(obj, depsgraph, settings, obj.dualcolor.image)
    shown = tone_range(model, settings)
    table = proof_table(settings, shown)
    paints = [Paint(source, repeats(model)) for source in _sources(obj)]
    hide_proof(obj)
    response = _response_image(f"{obj.name} Soft Proof", table)
    response[_RANGE_KEY] = shown
    _cover(obj, paints, response)
    _set_numbers(obj, settings)
    _tell(response, table, _state(settings))


def hide_proof(obj: bpy.types.Object) -> None:
    """Show an object as it was; what was made for the proof is deleted."""
    proofs = _proofs(obj)
    images = {_response(proof) for proof in proofs}
    bare = any(proof[PROOF_KEY] == _NO_SLOT for proof in proofs)
    for slot in obj.material_slots:
        proof = slot.material
        if is_proof(proof):
            slot.material = proof.get(COVERED_KEY)
            slot.link = "OBJECT" if proof[PROOF_KEY] == "OBJECT" else "DATA"
    if bare and list(obj.data.materials) == [None] and not _proofs_of_twins(obj):
        obj.data.materials.clear()
    for proof in proofs:
        if not proof.users:
            bpy.data.materials.remove(proof)
    for image in filter(None, images):
        if not image.users:
            bpy.data.images.remove(image)


def hide_all_proofs() -> None:
    """Show all objects as they were."""
    for obj in bpy.data.objects:
        if is_proofed(obj):
            hide_proof(obj)


def follow_settings(obj: bpy.types.Object, settings: PrintSettings, undone: bool = False) -> None:
    """Bring the proof of an object, if it has one, up to its settings; a problem becomes its note.

    Args:
        obj: the object.
        settings: its settings.
        undone: they come from undo, which brings back all but the pixels of images.
    """
    proofs = _proofs(obj)
    response = next((image for image in map(_response, proofs) if image), None)
    if response is None or (response.get(_STATE_KEY) == _state(settings) and not undone):
        return
    try:
        table = proof_table(settings, tuple(response[_RANGE_KEY]))
    except PrintError as problem:
        response[_NOTES_KEY] = [str(problem)]
        return
    _fill(response, table)
    _set_numbers(obj, settings)
    _tell(response, table, _state(settings))


def follow_paint(obj: bpy.types.Object, settings: PrintSettings) -> None:
    """Make the proof of an object, if it has one, anew: of another picture, by other UVs, in other units."""
    if not is_proofed(obj):
        return
    with suppress(PrintError):  # what cannot be shown now stays as it was, and generating tells why
        show_proof(obj, settings)


def proof_notes(obj: bpy.types.Object) -> list[str]:
    """Notes about an object's proof."""
    images = filter(None, map(_response, _proofs(obj)))
    return [str(note) for image in images for note in image.get(_NOTES_KEY, ())][:3]


def _proofs(obj: bpy.types.Object) -> list[bpy.types.Material]:
    """The proof materials in an object's slots, each once."""
    return list(dict.fromkeys(slot.material for slot in obj.material_slots if is_proof(slot.material)))


def _proofs_of_twins(obj: bpy.types.Object) -> list[bpy.types.Material]:
    """The proof materials of other objects with the same mesh."""
    twins = (other for other in bpy.data.objects if other.data == obj.data and other != obj)
    return [proof for twin in twins for proof in _proofs(twin)]


def _response(proof: bpy.types.Material) -> bpy.types.Image | None:
    node = proof.node_tree.nodes.get(RESPONSE) if proof.node_tree else None
    return node.image if node else None


def _sources(obj: bpy.types.Object) -> list[BaseColor]:
    """Where each slot's tone comes from, at least one; as `mesh_input.surface_model` decides it."""
    mesh, image = obj.data, obj.dualcolor.image
    colors = [base_color(material) for material in printed_materials(obj)] or [BaseColor()]
    if image:
        colors = [chosen_color(colors, image, mesh)] * len(colors)
    pictured = any(color.image for color in colors)
    found = []
    for color in colors:
        if color.image:
            found.append(replace(color, uv_map=picture_layer(color, mesh).name))
        elif layer := color_layer(color, mesh, pictured):
            found.append(BaseColor(attribute=layer.name))
        else:
            found.append(BaseColor(color=color.color if pictured else None))
    return found


def _cover(obj: bpy.types.Object, paints: list[Paint], response: bpy.types.Image) -> None:
    """Lay proof materials over those of an object."""
    bare = not obj.material_slots or any(proof[PROOF_KEY] == _NO_SLOT for proof in _proofs_of_twins(obj))
    if not obj.material_slots:
        obj.data.materials.append(None)
    made: dict[tuple[object, ...], bpy.types.Material] = {}
    for slot, paint in zip(obj.material_slots, paints, strict=True):
        link = _NO_SLOT if bare else slot.link
        slot.link = "OBJECT"
        covered = slot.material
        while is_proof(covered):  # left over where the slot was turned to the mesh's material by hand
            covered = covered.get(COVERED_KEY)
        key = paint, link, covered
        if key not in made:
            proof = made[key] = proof_material(f"{obj.name} Soft Proof", paint, response)
            proof[PROOF_KEY] = link
            if covered:
                proof[COVERED_KEY] = covered
        slot.material = made[key]


def _response_image(name: str, table: ProofTable) -> bpy.types.Image:
    rows, columns = table.reflectance.shape
    image = bpy.data.images.new(name, columns, rows, alpha=False, float_buffer=True, is_data=True)
    image.use_half_precision = False
    _fill(image, table)
    return image


def _fill(image: bpy.types.Image, table: ProofTable) -> None:
    pixels = np.ones((*table.reflectance.shape, 4), dtype=np.float32)
    pixels[..., :3] = table.reflectance[..., None]
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()


def _set_numbers(obj: bpy.types.Object, settings: PrintSettings) -> None:
    unit = mm_per_unit(bpy.context.scene)
    across, up = proof_window(settings)
    lengths = {ACROSS: across, UP: up, GRADIENT: _GRADIENT_MM, STRIPES: _STRIPES_MM}
    numbers = {name: length / unit for name, length in lengths.items()} | {BACKGROUND: settings.background_tone}
    for proof in _proofs(obj):
        for name, value in numbers.items():
            set_number(proof, name, value)


def _tell(response: bpy.types.Image, table: ProofTable, state: str) -> None:
    response[_STATE_KEY], response[_NOTES_KEY] = state, list(table.notes)


def _state(settings: PrintSettings) -> str:
    return json.dumps(proof_settings(settings))

"""What is painted on the models, as the options of `add_stand` ask for it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..core.progress import drained
from ..core.settings import PrintSettings

if TYPE_CHECKING:
    import bpy


def chosen_pictures(
    objects: Sequence[bpy.types.Object], args: argparse.Namespace, settings: PrintSettings
) -> tuple[list[bpy.types.Image | None], list[str]]:
    """UV maps for the meshes that want some, and the picture to print on each object, None for its own.

    Returns:
        The pictures, and warnings about what they do not show.

    Raises:
        PrintError: a picture cannot be read, a mesh cannot be unwrapped or its material not baked.
    """
    from ..bridge.input.image_input import load_image
    from ..bridge.input.printed_materials import printed_materials
    from ..bridge.paint.material_bake import material_bake_steps
    from ..bridge.paint.unwrap import unwrap

    meshes = [each for each in dict.fromkeys(objects) if each.type == "MESH"]  # one may be named twice
    for mesh in meshes if args.unwrap else ():
        if not mesh.data.uv_layers:
            unwrap(mesh, args.unwrap)
    pictures = dict.fromkeys(objects, load_image(args.texture) if args.texture else None)
    warnings = []
    for mesh in meshes if args.bake_material else ():
        if any(printed_materials(mesh)):
            texel_mm, tone = settings.layer_height / 2, settings.background_tone
            pictures[mesh], note = drained(material_bake_steps(mesh, texel_mm, tone, settings.printer))
            warnings += [f"warning: {mesh.name}: {note}"] if note else []
    return [pictures[each] for each in objects], warnings

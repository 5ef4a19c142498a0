"""What an operator does to the 3D view that it was called from, so that its result is seen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np

from ..bridge.bed import bounds_mm
from ..bridge.input.mesh_input import WITH_SURFACE
from ..bridge.units import mm_per_unit

_AWAY = 1.3  # lengths of the object, from which a view with the usual lens sees all of it


def frame_selected(context: bpy.types.Context) -> None:
    """Fill the view with what is selected, which may be a dot in it; outside of a 3D view nothing happens."""
    if context.area is None or context.area.type != "VIEW_3D":
        return
    region = next((region for region in context.area.regions if region.type == "WINDOW"), None)
    with context.temp_override(region=region):
        if bpy.ops.view3d.view_selected.poll():
            bpy.ops.view3d.view_selected()


def frame_in_other_views(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Have the 3D views of all other workspaces look at an object that is much smaller or larger than what was there.

    A view that is left as it was may be inside it.
    """
    areas = [area for screen in bpy.data.screens for area in screen.areas]
    _frame([area for area in areas if area != context.area], [obj], mm_per_unit(context.scene))


def show_imported(context: bpy.types.Context, made: bpy.types.Collection) -> None:
    """Show the strands of a file in the 3D views of the window, where they may be a dot, and in the sidebar.

    None is selected, only one active: what is selected is drawn in the color of the selection.
    """
    if context.mode != "OBJECT" or not made.objects:
        return
    for obj in context.selected_objects:
        obj.select_set(False)
    context.view_layer.objects.active = made.objects[0]
    _frame(list(context.screen.areas) if context.screen else [], list(made.objects), mm_per_unit(context.scene))


def _frame(areas: Sequence[bpy.types.Area], objects: Sequence[bpy.types.Object], unit: float) -> None:
    """Have the 3D views among some areas see all of some objects, from where they look."""
    low, high = bounds_mm(objects) / unit
    for view in (area.spaces.active.region_3d for area in areas if area.type == "VIEW_3D"):
        view.view_location, view.view_distance = (low + high) / 2, _AWAY * float(np.linalg.norm(high - low))


def show_added(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Show an object with a picture that was added; the first one of a scene in all workspaces."""
    show_pictures(context)
    frame_selected(context)
    if not any(other.type in WITH_SURFACE for other in context.scene.objects if other != obj):
        frame_in_other_views(context, obj)


def make_active(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Have an object active and selected, if it is in the view layer."""
    if obj.name in context.view_layer.objects:
        context.view_layer.objects.active = obj
        obj.select_set(True)


def show_in_local_views(context: bpy.types.Context, source: bpy.types.Object, made: bpy.types.Collection) -> None:
    """Have the objects of a collection seen in the views that show only some objects, the source among them."""
    areas = [area for window in context.window_manager.windows for area in window.screen.areas]
    for space in (area.spaces.active for area in areas if area.type == "VIEW_3D"):
        if space.local_view and source.local_view_get(space):
            for shown in made.objects:
                shown.local_view_set(space, True)


def show_pictures(context: bpy.types.Context) -> None:
    """Have a solid view show the pictures on objects instead of one color for each material."""
    if context.area is None or context.area.type != "VIEW_3D":
        return
    shading = context.space_data.shading
    if shading.type == "SOLID" and shading.color_type == "MATERIAL":
        shading.color_type = "TEXTURE"


def show_file(context: bpy.types.Context, path: Path) -> None:
    """Show a picture that was saved in an image editor that is open, else in a window of its own, as renders are."""
    image = bpy.data.images.load(str(path), check_existing=True)
    image.reload()
    areas = [area for window in context.window_manager.windows for area in window.screen.areas]
    area = next((area for area in areas if area.type == "IMAGE_EDITOR"), None)
    if area is None:
        bpy.ops.wm.window_new()
        area = context.window_manager.windows[-1].screen.areas[0]
        area.type = "IMAGE_EDITOR"
    area.spaces.active.image = image
    area.tag_redraw()

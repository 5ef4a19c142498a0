"""Restores the looks of objects that are drawn as bounds although no strands stand in their place.

They are copies of an object that was printed, or linked from its file, or their strands have been deleted by hand.
"""

from __future__ import annotations

import bpy

from .preview import DISPLAY_KEY, SOURCE_KEY, companions_of, is_print_shown, show_bounds

_counted: dict[str, tuple[int, int]] = {}


def give_back_looks() -> None:
    """Find such objects in the file and restore them."""
    sources = [held.get(SOURCE_KEY) for held in bpy.data.collections]
    sources = [held for held in sources if isinstance(held, bpy.types.Object) and is_print_shown(held)]
    printed = {each for source in sources for each in (source, *companions_of(source))}
    for obj in bpy.data.objects:
        if DISPLAY_KEY in obj and obj not in printed:
            show_bounds(obj, False)


@bpy.app.handlers.persistent
def _after_update(*_: object) -> None:
    """Called after every change; only a changed number of objects, by copying or deleting, is looked into."""
    count = len(bpy.data.objects), len(bpy.data.collections)
    if _counted.get("objects") != count:
        _counted["objects"] = count
        give_back_looks()


@bpy.app.handlers.persistent
def _after_load(*_: object) -> None:
    """What is linked comes from its file anew."""
    give_back_looks()


def register() -> None:
    """Start watching the number of objects."""
    bpy.app.handlers.depsgraph_update_post.append(_after_update)
    bpy.app.handlers.load_post.append(_after_load)


def unregister() -> None:
    """Stop watching."""
    bpy.app.handlers.depsgraph_update_post.remove(_after_update)
    bpy.app.handlers.load_post.remove(_after_load)
    _counted.clear()

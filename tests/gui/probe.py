"""Run by Blender at its start: answers the questions of window.py, so that a test sees what its mouse and keys did.

A question is a Python expression in the file QUESTION; its value is written as JSON. Nothing here changes the scene.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from pathlib import Path
from typing import Any

import bpy

USED_BY_QUESTIONS = (sys, os)
FOLDER = Path(os.environ["DUALCOLOR_PROBE"])
SECONDS = 0.02


def area_of(kind: str) -> tuple[bpy.types.Window, bpy.types.Area] | None:
    """The largest area of a kind, in whichever window."""
    found = [(window, area) for window in bpy.context.window_manager.windows for area in window.screen.areas]
    found = [(window, area) for window, area in found if area.type == kind]
    return max(found, key=lambda pair: pair[1].width * pair[1].height, default=None)


def box(kind: str, region_kind: str) -> list[int] | None:
    """Left, top, right, bottom of a region on the screen."""
    found = area_of(kind)
    if found is None:
        return None
    window, area = found
    region = next(each for each in area.regions if each.type == region_kind)
    left = window.x + region.x
    bottom = int(os.environ["DUALCOLOR_SCREEN_HEIGHT"]) - window.y - region.y  # the screen's Y points down
    return [left, bottom - region.height, left + region.width, bottom]


def button() -> str:
    """Identifier of the operator or the property under the mouse in the sidebar; empty if there is none.

    Blender tells it nowhere but through what Ctrl+C copies.
    """
    found = area_of("VIEW_3D")
    if found is None:
        return ""
    window, area = found
    region = next(each for each in area.regions if each.type == "UI")
    with bpy.context.temp_override(window=window, area=area, region=region):
        manager = bpy.context.window_manager
        for copy in (bpy.ops.ui.copy_python_command_button, bpy.ops.ui.copy_data_path_button):
            manager.clipboard = ""
            if copy.poll() and copy() == {"FINISHED"}:
                return manager.clipboard.removeprefix("bpy.ops.").partition("(")[0]
    return ""


def tab() -> str:
    """The tab of the sidebar that is open."""
    found = area_of("VIEW_3D")
    return next(region.active_panel_category for region in found[1].regions if region.type == "UI") if found else ""


def _answer() -> float:
    question = FOLDER / "question"
    if question.exists():
        text = question.read_text(encoding="utf-8")
        question.unlink()
        try:
            found: dict[str, Any] = {"value": eval(text)}  # the test is the only one who asks
        except Exception:  # a timer that raises would be removed, and the test would wait: it is told instead
            found = {"error": traceback.format_exc()}
        (FOLDER / "answer.part").write_text(json.dumps(found), encoding="utf-8")
        (FOLDER / "answer.part").rename(FOLDER / "answer")
    return SECONDS


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(_answer, persistent=True)

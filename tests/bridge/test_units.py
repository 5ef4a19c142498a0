"""Scenes in millimeters."""

import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.units import mm_per_unit, use_millimeters  # noqa: E402


def grids():
    areas = [area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D"]
    return [area.spaces.active.overlay.grid_scale for area in areas]


def test_the_grid_of_all_views_has_lines_a_millimeter_apart_unless_it_is_finer(scene):
    view = next(area for area in bpy.data.screens["Layout"].areas if area.type == "VIEW_3D")
    view.spaces.active.overlay.grid_scale = 1e-4
    use_millimeters(scene)
    assert mm_per_unit(scene) == 1.0
    assert len(grids()) > 1 and min(grids()) == pytest.approx(1e-4)
    assert sum(grid == pytest.approx(1e-3) for grid in grids()) == len(grids()) - 1

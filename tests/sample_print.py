"""A small print made by hand, for tests that need strands but no slicing."""

from types import SimpleNamespace

import numpy as np
from dualcolor.core.model import TriangleMesh
from dualcolor.core.paths import Feature
from dualcolor.core.settings import PrintSettings
from dualcolor.core.toolpaths.moves import Moves

SIDE, LAYERS, STEP = 10.0, 8, 0.25


def cube_mesh() -> TriangleMesh:
    half = SIDE / 2
    corners = np.array([[x, y, z] for x in (-half, half) for y in (-half, half) for z in (0, LAYERS * STEP)])
    faces = np.array([[0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    return TriangleMesh(corners, faces, np.zeros((4, 3, 2)), np.full((4, 3), np.nan), np.full(4, -1))


def square_print() -> SimpleNamespace:
    """Square outlines in alternating tools, 8 layers, and a tower line 20 mm beside them on each layer."""
    half = SIDE / 2 - 0.2
    ring = np.array([[-half, -half], [half, -half], [half, half], [-half, half], [-half, -half]])
    points = np.concatenate([ring, [[20, -5], [20, 5]]])
    feature = [Feature.TRAVEL] + [Feature.OUTER_WALL] * 4 + [Feature.TRAVEL, Feature.TOWER]
    rows = len(points) * LAYERS
    layer = np.repeat(np.arange(LAYERS), len(points))
    features = np.tile(np.array(feature, dtype=np.int64), LAYERS)
    laid = features != Feature.TRAVEL
    position = np.column_stack([np.tile(points, (LAYERS, 1)), (layer + 1) * STEP])
    moves = Moves(position, layer % 2, features, layer, laid * 0.4, laid * STEP, np.full(rows, 30.0), laid * 1.0)
    return SimpleNamespace(
        settings=PrintSettings(), name="Cube", mesh=cube_mesh(), moves=moves, report={"layers": LAYERS}, warnings=[]
    )

"""Every mesh of the test data, small: GPX has nothing to say, our X3G is what it makes, and the audit is silent."""

from pathlib import Path

import pytest
from dualcolor.benchmarks.x3g import DATA, compared, height_of, meshes, model_of, tower_box
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.gpx import installed

HEIGHT_MM = 12.0
SETTINGS = PrintSettings(support_enable=True)
FOUND = meshes(DATA)


@pytest.mark.skipif(not FOUND, reason="the folder ../shared/data with the test meshes is not here")
def test_all_kinds_of_meshes_are_there():
    assert len(FOUND) >= 17
    assert {path.suffix for path in FOUND} == {".glb", ".obj", ".ply", ".stl"}


@pytest.mark.parametrize("path", FOUND, ids=lambda path: path.stem)
def test_mesh(path: Path):
    pytest.importorskip("bpy")
    if not installed():
        pytest.skip("gpx is not installed")
    model = model_of(path, HEIGHT_MM if height_of(path) else None)
    result = generate(model, SETTINGS)
    found = compared(result)
    assert found.diagnostics == []
    assert found.equal_moves == found.moves > 100
    assert found.same_heaters
    assert found.same_bytes
    # The tower ends below tips that are too thin to print.
    assert found.tool_changes == result.report["tool_changes"] < result.report["layers"]
    # The branches are so thin that only their foot is printed, in one color.
    assert (tower_box(result) is not None) == (found.tool_changes > 0) == (path.stem != "branches_70")
    assert found.findings == []

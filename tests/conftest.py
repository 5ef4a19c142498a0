"""Make the repository importable as the package `dualcolor`, and find the test data where it lies."""

import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
DATA = ROOT.parent / "shared" / "data"
# The same examples everywhere and every time; `pytest --hypothesis-profile=search` looks for others.
KIND = {
    "deadline": None,
    "database": None,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
}
settings.register_profile("repeatable", derandomize=True, **KIND)
settings.register_profile("search", derandomize=False, **KIND)
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real meshes and images; tests that need it are skipped where it is not."""
    if not DATA.is_dir():
        pytest.skip("the folder ../shared/data with the test meshes is not here")
    return DATA


@pytest.fixture
def scene():
    """An empty Blender scene, the current one; tests that need it are skipped without the module `bpy`."""
    bpy = pytest.importorskip("bpy")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


@pytest.fixture
def registered():
    """The extension, in a scene of its own, which is empty and in millimeters."""
    pytest.importorskip("bpy")
    import dualcolor
    from dualcolor.tests.scene import fresh

    fresh()
    dualcolor.register()
    yield
    dualcolor.unregister()

"""Run the tests of all that touches Blender, in a real Blender or with a module bpy of another version.

    blender -b --factory-startup --python-exit-code 1 --python tests/run_in_blender.py -- [pytest's arguments]
    python tests/run_in_blender.py -- [pytest's arguments]

Its Python must have pytest, hypothesis, shapely and Pillow. Paths among the arguments replace the choice of tests.
"""

import os
import re
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parent


def files_with_blender() -> list[str]:
    """The test files in which Blender's module is named, or the fixture that makes a scene."""
    named = re.compile(r"\b(bpy|scene)\b")
    files = (path for path in sorted(TESTS.rglob("test_*.py")) if path.parent.name != "gui")
    return [str(path) for path in files if named.search(path.read_text(encoding="utf-8"))]


arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
files = [] if any(Path(argument).exists() for argument in arguments) else files_with_blender()
status = pytest.main(["--rootdir", str(TESTS.parent), "-p", "no:cacheprovider", "-rs", *arguments, *files])
sys.stdout.flush()
sys.stderr.flush()
# The module of Blender 4.5 may wait for itself for ever when the interpreter ends.
os._exit(int(status))

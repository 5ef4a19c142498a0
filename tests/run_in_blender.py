"""Run the test-suite inside a real Blender, whose Python must have pytest, hypothesis, shapely and Pillow.

blender -b --factory-startup --python-exit-code 1 --python tests/run_in_blender.py -- [pytest's arguments]
"""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
status = pytest.main(["--rootdir", str(ROOT), "-p", "no:cacheprovider", *(arguments or [str(ROOT / "tests")])])
if status:
    raise SystemExit(int(status))

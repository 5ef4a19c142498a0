"""GPX, the converter from G-code to the printer's X3G, as a judge of files."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path


def installed() -> str:
    """Where GPX is, "" if it is not installed."""
    return shutil.which("gpx") or ""


def convert(path: str | os.PathLike[str], machine: str = "r2x") -> list[str]:
    """Convert a G-code file, by default for the Replicator 2X, and return what GPX complains about, one line each.

    Without `-v` GPX prints nothing but diagnostics. The X3G is left beside the G-code. Skips the test without GPX.
    """
    program = installed()
    if not program:
        import pytest

        pytest.skip("gpx is not installed")
    gcode = Path(path)
    x3g = gcode.with_suffix(".x3g")
    command = [program, "-I", "-g", "-m", machine, gcode, x3g]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    lines = [line for line in (run.stdout + run.stderr).splitlines() if line.strip()]
    if run.returncode or not x3g.exists():
        lines.append(f"gpx ended with {run.returncode}")
    return lines

"""Load this folder as the package `dualcolor` outside Blender, whatever the folder itself is called."""

from __future__ import annotations

import importlib.util
import os
import signal
import sys
from io import TextIOWrapper
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parent
PACKAGE = "dualcolor"


def load_package() -> ModuleType:
    """Import the extension's root as `dualcolor`, so that `dualcolor.core` and the rest can be imported."""
    if PACKAGE in sys.modules:
        return sys.modules[PACKAGE]
    spec = importlib.util.spec_from_file_location(PACKAGE, ROOT / "__init__.py", submodule_search_locations=[str(ROOT)])
    if spec is None or spec.loader is None:
        raise ImportError(f"{ROOT} holds no __init__.py")
    package = importlib.util.module_from_spec(spec)
    sys.modules[PACKAGE] = package
    spec.loader.exec_module(package)
    return package


def open_standard_streams() -> None:
    """Give the process the standard streams that it was started without: a file opened later would take their place.

    What a terminal's encoding lacks is shown as a question mark.
    """
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
    sys.stdout = sys.stdout or open(os.devnull, "w")  # noqa: SIM115  (None where there was no stream)
    sys.stderr = sys.stderr or open(os.devnull, "w")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")


def main() -> int:
    """Run the command line."""
    open_standard_streams()
    interrupt = signal.getsignal(signal.SIGINT)
    if interrupt is signal.default_int_handler:  # else it is ignored, as in a job in the background
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl+C while modules are imported: no traceback
    load_package()
    from dualcolor.cli import main as run

    signal.signal(signal.SIGINT, interrupt)
    return int(run(sys.argv[1:]))


if __name__ == "__main__":
    sys.exit(main())

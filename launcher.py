"""Load this folder as the package `dualcolor` outside Blender, whatever the folder itself is called."""

from __future__ import annotations

import importlib.util
import sys
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


def main() -> int:
    """Run the command line."""
    load_package()
    from dualcolor.cli import main as run

    return int(run(sys.argv[1:]))


if __name__ == "__main__":
    sys.exit(main())

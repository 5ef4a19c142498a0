"""docs/architecture.md and the tree: what it names is there, and modules import what it says they import."""

import ast
import re

import pytest

from launcher import ROOT

PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
LAYERS = ("core", "bridge")


def test_every_path_is_there():
    paths = re.findall(r"`([\w/]+(?:\.py|/))`", PAGE)
    assert len(paths) > 60
    for path in paths:
        places = [ROOT / path, ROOT / "core" / path]
        assert any(place.exists() for place in places) or ("/" not in path and any(ROOT.glob(f"*/**/{path}"))), path


def ranks():
    """The place of each folder and module of the core in the page's list."""
    rows = re.search(r"in its own:\n\n((?:    .*\n)+)", PAGE)[1].splitlines()
    return {
        name: place for place, name in enumerate(name for row in rows for name in re.split(" {2,}", row.strip())[:-1])
    }


def imported(path):
    """What a module of the core imports from the core, as the page names it."""
    package = path.relative_to(ROOT).with_suffix("").parts
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            parts = [*package[: -node.level], *(node.module.split(".") if node.module else ())]
            yield parts[1] if len(parts) > 1 else node.names[0].name


@pytest.mark.parametrize(
    "path", sorted((ROOT / "core").rglob("*.py")), ids=lambda path: path.relative_to(ROOT).as_posix()
)
def test_modules_of_the_core_import_only_what_comes_before_them(path):
    rank = ranks()
    rank |= {name.removesuffix("/").removesuffix(".py"): place for name, place in rank.items()}
    inside = path.relative_to(ROOT / "core").parts[0].removesuffix(".py")
    if inside == "__init__":
        return
    for name in imported(path):
        assert name == inside or rank[name] < rank[inside], f"{inside} imports {name}"


def test_nothing_of_the_core_or_the_bridge_points_back():
    outer = {"core": {"bridge", "operators", "panels", "commands"}, "bridge": {"operators", "panels", "commands"}}
    for layer in LAYERS:
        for path in (ROOT / layer).rglob("*.py"):
            package = path.relative_to(ROOT).with_suffix("").parts
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ImportFrom) and node.level >= len(package):
                    first = (node.module or node.names[0].name).split(".")[0]
                    assert first not in outer[layer], path

"""The package that users install: what is in it, and that it installs, works and goes without a trace."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from launcher import ROOT

pytest.importorskip("bpy")


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if "site-packages" not in str(sys.modules["bpy"].__file__):
        pytest.skip("the tool that builds packages is looked for in the bpy module")
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, str(ROOT / "tools" / "package.py"), "--out", str(folder), "--only-without-wheels"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (found,) = folder.glob("*.zip")
    return found


def test_package_holds_what_runs_and_nothing_else(package: Path) -> None:
    names = zipfile.ZipFile(package).namelist()
    assert {"blender_manifest.toml", "__init__.py", "cli.py", "LICENSE", "THIRD_PARTY.md"} <= set(names)
    assert any(name.startswith("presets/printer/") for name in names)
    folders = {name.split("/")[0] for name in names if "/" in name}
    assert folders == {"core", "bridge", "operators", "panels", "commands", "presets"}
    assert not [name for name in names if "__pycache__" in name or name.endswith(".pyc")]


def test_every_module_of_the_repository_is_in_the_package(package: Path) -> None:
    names = set(zipfile.ZipFile(package).namelist())
    for folder in ("core", "bridge", "operators", "panels", "commands"):
        modules = {path.relative_to(ROOT).as_posix() for path in (ROOT / folder).rglob("*.py")}
        assert modules <= names


def test_installs_prints_and_leaves_no_trace(package: Path, tmp_path: Path) -> None:
    places = {"BLENDER_USER_RESOURCES": str(tmp_path / "user"), "HOME": str(tmp_path)}
    command = [sys.executable, str(Path(__file__).with_name("installed_extension.py")), str(package)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **places})
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads(done.stdout.strip().splitlines()[-1])
    assert found["before"] == found["disabled"] == []
    assert found["installed"] == found["again"] != []
    assert found["bytes"] > 10_000

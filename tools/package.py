"""Build the extension's packages into dist/: one for each platform, one for all, one without wheels.

    python tools/package.py [--out DIR] [--only-without-wheels]

The tool that validates and builds is Blender's own; it comes with bpy. The package without wheels is for Blenders whose
Python has the libraries already.
"""

from __future__ import annotations

import argparse
import importlib.util
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WHEELS = ROOT / "tools" / "wheels.txt"
SHIPPED = ("blender_manifest.toml", "LICENSE", "THIRD_PARTY.md", "README.md", "CHANGELOG.md")
FOLDERS = ("core", "bridge", "operators", "panels", "commands", "presets")
PYTHONS = ("3.11", "3.13")
INTEL_MACS = ("macosx_11_0_x86_64", *(f"macosx_10_{minor}_x86_64" for minor in range(15, 8, -1)))
# Blender's names of platforms, and the tags of wheels that run there.
PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_24_x86_64", "manylinux2014_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_11_0_arm64",),
    "macos-x64": INTEL_MACS,
}


def main() -> int:
    """Build, validate and list the packages."""
    parser = argparse.ArgumentParser(description="Build the extension's packages.")
    parser.add_argument("--out", type=Path, default=ROOT / "dist", metavar="DIR", help="folder of the packages")
    parser.add_argument("--only-without-wheels", action="store_true", help="leave the libraries out, download nothing")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        source = Path(scratch) / "dualcolor"
        copy_source(source)
        validate(source)
        bare = args.out / f"dualcolor-{version()}-without_wheels.zip"
        build(source, "--output-filepath", str(bare))
        if not args.only_without_wheels:
            add_wheels(source)
            validate(source)
            build(source, "--output-dir", str(args.out))
            build(source, "--output-dir", str(args.out), "--split-platforms")
    for package in sorted(args.out.glob(f"dualcolor-{version()}*.zip")):
        print(f"{package} ({package.stat().st_size / 1e6:.1f} MB)")
    return 0


def version() -> str:
    """The extension's version, from its manifest."""
    return str(tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))["version"])


def copy_source(target: Path) -> None:
    """Copy what runs inside Blender, and nothing else, into an empty folder."""
    target.mkdir()
    sources = [*ROOT.glob("*.py"), *(ROOT / name for name in SHIPPED)]
    for path in sources:
        if path.name != "launcher.py":
            shutil.copy2(path, target)
    for name in FOLDERS:
        shutil.copytree(ROOT / name, target / name, ignore=shutil.ignore_patterns("__pycache__", ".*"))


def add_wheels(source: Path) -> None:
    """Download the libraries for all platforms and Pythons, and declare them in the copy's manifest."""
    for tags in PLATFORMS.values():
        for python in PYTHONS:
            platforms = [argument for tag in tags for argument in ("--platform", tag)]
            run(sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps",
                "--only-binary=:all:", "--python-version", python, *platforms, "--dest", str(source / "wheels"),
                "--requirement", str(WHEELS))  # fmt: skip
    names = sorted(path.name for path in (source / "wheels").glob("*.whl"))
    lines = [f"platforms = {list(PLATFORMS)}", "wheels = [", *(f'    "./wheels/{name}",' for name in names), "]", ""]
    manifest = source / "blender_manifest.toml"
    head, table, tail = manifest.read_text(encoding="utf-8").partition("[permissions]")
    manifest.write_text(head + "\n".join(lines).replace("'", '"') + "\n" + table + tail, encoding="utf-8")


def validate(source: Path) -> None:
    """Have Blender's tool check the copy."""
    run(sys.executable, str(blender_tool()), "validate", str(source))


def build(source: Path, *arguments: str) -> None:
    """Have Blender's tool make the packages."""
    run(sys.executable, str(blender_tool()), "build", "--source-dir", str(source), *arguments)


def blender_tool() -> Path:
    """Blender's command for extensions, inside the bpy that is installed.

    Raises:
        SystemExit: there is no bpy.
    """
    found = importlib.util.find_spec("bpy")
    places = list(Path(found.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")) if (
        found and found.origin) else []  # fmt: skip
    if not places:
        raise SystemExit("error: bpy is not installed: run 'make environment' first")
    return places[0]


def run(*command: str) -> None:
    """Run a command quietly; show what it said only if it fails.

    Raises:
        SystemExit: it failed.
    """
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"error: {' '.join(command[:4])} … failed\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    sys.exit(main())

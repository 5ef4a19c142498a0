"""Write docs/settings.md from the declarations in core/settings/; run it with the environment's Python."""

from __future__ import annotations

import sys
from dataclasses import fields
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
from dualcolor.core.settings import PrintSettings  # noqa: E402

REFERENCE = ROOT / "docs" / "settings.md"
TITLES = {
    "printer": "Printer",
    "print": "Print",
    "pattern": "Pattern",
    "texture": "Texture",
    "filament": "Filament and temperature",
    "preview": "Predicted print",
}
HEAD = """# Settings

Made from the declarations in `core/settings/`; do not edit by hand. Every setting can be given with `--set name=value`,
in a JSON file with `--settings FILE.json`, and in the sidebar, which shows the same names.
"""


def reference() -> str:
    """The whole page."""
    parts = [HEAD]
    declared = fields(PrintSettings)
    for group, title in TITLES.items():
        parts.append(f"\n## {title}\n")
        parts.append("| name | default | limits | what it does |\n|---|---|---|---|")
        parts += [_row(setting) for setting in declared if setting.metadata["group"] == group]
    return "\n".join(parts) + "\n"


def _row(setting) -> str:  # type: ignore[no-untyped-def]
    about = setting.metadata
    unit = f" {about['unit']}" if about["unit"] else ""
    default = setting.default if not isinstance(setting.default, bool) else str(setting.default).lower()
    if about["choices"]:
        limits = ", ".join(f"`{choice}`" for choice in about["choices"])
    elif about["low"] is not None:
        limits = f"{about['low']:g} to {about['high']:g}{unit}"
    else:
        limits = "true, false" if isinstance(setting.default, bool) else ""
    return f"| `{setting.name}` | {default}{unit} | {limits} | {about['description']} |"


if __name__ == "__main__":
    REFERENCE.write_text(reference(), encoding="utf-8")

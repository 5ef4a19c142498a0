"""Measured tables in Markdown files: each lies between two comments that name it, so that the text around it stays."""

from __future__ import annotations

from pathlib import Path


def replace_table(path: Path, name: str, table: str) -> None:
    """Put a table between `<!-- NAME begins -->` and `<!-- NAME ends -->` of a Markdown file.

    Args:
        path: of the file.
        name: of the table.
        table: Markdown that ends with a line break.

    Raises:
        ValueError: the file has no such comments.
    """
    text = path.read_text(encoding="utf-8")
    begin, end = f"<!-- {name} begins -->\n", f"<!-- {name} ends -->"
    before, after = text.index(begin) + len(begin), text.index(end)
    path.write_text(text[:before] + table + text[after:], encoding="utf-8")

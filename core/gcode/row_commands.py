"""Commands between the moves, of heaters and fan, by the row of the moves where they stand."""

from __future__ import annotations

from ..records import dataclass

LinesByRow = dict[int, list[str]]


@dataclass(frozen=True)
class RowCommands:
    """Lines of text by row.

    Attributes:
        before: those before the row, and before its tool change if there is one.
        after: those after its tool change; only rows that begin a layer or change the tool have any.
    """

    before: LinesByRow
    after: LinesByRow

    @staticmethod
    def joined(parts: list[RowCommands]) -> RowCommands:
        """All of them; at one row in the order of the parts."""
        return RowCommands(_merged([part.before for part in parts]), _merged([part.after for part in parts]))


def _merged(parts: list[LinesByRow]) -> LinesByRow:
    lines: LinesByRow = {}
    for part in parts:
        for row, more in part.items():
            lines[row] = lines.get(row, []) + more
    return lines

"""The print in order: the table of moves that time, preview and files are made from."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..paths import Feature
from ..records import dataclass


@dataclass(frozen=True)
class Moves:
    """The print in order: row i moves the nozzle from position i - 1 to position i. M rows.

    A row either travels (no filament), retracts (filament < 0, with a motion where it wipes) or primes (no motion,
    filament > 0), both of feature RETRACT, or extrudes (motion and filament > 0). Where `tool` differs from the row
    before, the tool is changed before the row; that row is a travel.

    Attributes:
        position: (M, 3) float64 mm, of the active nozzle.
        tool: (M,) int64, 0 or 1.
        feature: (M,) int64, a `Feature`.
        layer: (M,) int64.
        width: (M,) float64 mm, 0 where nothing is extruded.
        height: (M,) float64 mm, layer height, 0 where nothing is extruded.
        speed: (M,) float64 mm/s, along the path; of the filament where nothing moves.
        filament: (M,) float64 mm of filament fed during the row, negative in a retraction.
    """

    position: FloatArray
    tool: IntArray
    feature: IntArray
    layer: IntArray
    width: FloatArray
    height: FloatArray
    speed: FloatArray
    filament: FloatArray

    @property
    def extrudes(self) -> BoolArray:
        """(M,) bool, rows that lay down a strand."""
        return np.asarray((self.filament > 0) & (self.feature != Feature.RETRACT))

    @staticmethod
    def blank(rows: int) -> Moves:
        """A table that is to be filled: each column in one piece, as it is read, and all in one block.

        The system has larger pages for large blocks.
        """
        block = np.empty((10, rows))
        return Moves(block[:3].T, *block[7:].view(np.int64), *block[3:7])

    def rows(self, chosen: slice | IntArray) -> Moves:
        """Some of the rows."""
        return Moves(*(getattr(self, column.name)[chosen] for column in fields(Moves)))

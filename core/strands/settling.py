"""How strands lie when they have cooled: oval on material, rounder and sagging over air."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..paths import Feature
from ..ragged import starts
from .spans import unsupported_distance
from .strands import Strands

_PIECE = 0.25  # mm between the points of a line over air, at least where it begins to be
_HIDDEN_PIECE = 0.5  # mm, of sparse infill, which makes up most of what hangs in the air
_TOUCHING = 0.01  # mm; lines side by side are a half width away from one between them, give or take the last digit
_ROUNDING = 0.02  # of a piece: lengths of round numbers are cut alike whatever their last digit
_SAG_OF_1_MM = (3 * 1040 * 9.81 * 1.0 * 1e-12 / (128 * 1e4)) ** (1 / 3) * 1e3  # see `sag_depth`


def settled(laid: Strands, sag: float) -> Strands:
    """The strands as they lie when they have cooled: on material an oval, over air rounder and lower.

    A point is over air where its center line lies outside the strands of the layer below (`unsupported_distance`).
    There the strand becomes a circle by the time nothing of it is above them any more, and sinks as `sag_depth` says.
    Both follow from a distance that has no jumps, so the strand has none either. Long lines over air get more points.
    What a line gains in length by sinking it loses in width: its volume stays.

    Args:
        laid: strands as the nozzle went.
        sag: mm, the most that any strand sinks.
    """
    if not len(laid):
        return laid
    dense, left = _subdivided(laid)
    free = unsupported_distance(dense.points, dense.start, dense.layer, dense.width)
    over_air = free > _TOUCHING
    # A line that rests on material needs no points between its ends, one that is round all over only every second.
    wanted = (left == 0) | (_or_next_to(over_air) & ((left % 2 == 0) | _or_next_to(free < dense.width / 2)))
    rows = np.flatnonzero(wanted)
    start = starts(wanted)[dense.start]
    points, width, free = dense.points.take(rows, axis=0), dense.width[rows], free[rows]
    roundness = _eased(free / (width / 2))
    flat = _steps(points)
    points[:, 2] -= sag_depth(free, sag)
    sunk = _steps(points)
    lengthened = sunk > flat
    lengthened[start[:-1]] = False
    width[lengthened] *= flat[lengthened] / sunk[lengthened]
    return replace(
        dense, points=points, start=start, width=width, roundness=roundness, unsupported=free, row=dense.row[rows]
    )


def sag_depth(free: FloatArray, most: float) -> FloatArray:
    """How far a strand sinks, mm, where it is `free` mm away from what carries it; at most `most` mm.

    A thread of length L = 2·free between two supports hangs as a parabola of depth s under the tension
    T = ρ·g·A·L² / (8·s), and that tension draws a viscous thread, T = 3·μ·A·(rate of strain), where the strain is
    8/3·(s/L)². So s³ = 3·ρ·g·t·L⁴ / (128·μ) after the time t for which it stays soft: the depth grows with L^(4/3).
    ABS just out of the nozzle (ρ = 1040 kg/m³, μ = 10 kPa·s, soft for about a second) sinks 0.6 mm in a span of 10 mm,
    and 0.03 mm in one of 1 mm. The limit stands for what this leaves out: neighbors in the same layer that the strand
    sticks to, and the nozzle's pull.
    """
    if most <= 0:
        return np.zeros(len(free))
    depth: FloatArray = most * np.tanh(_SAG_OF_1_MM * (2 * free) ** (4 / 3) / most)
    return depth


def _subdivided(laid: Strands) -> tuple[Strands, IntArray]:
    """The strands with points between those that are far apart, and (N,) how many steps are left to an old one."""
    lengths = _steps(laid.points)
    lengths[laid.start[:-1]] = 0.0
    piece = np.where(laid.feature == Feature.INFILL, _HIDDEN_PIECE, _PIECE)
    pieces = np.maximum(np.ceil(lengths / np.repeat(piece, np.diff(laid.start)) - _ROUNDING), 1).astype(np.int64)
    start = starts(pieces)
    left = np.repeat(start[1:] - 1, pieces) - np.arange(start[-1])
    step = np.diff(laid.points, axis=0, prepend=laid.points[:1]) / pieces[:, None]
    points = np.repeat(laid.points, pieces, axis=0)
    points -= left[:, None] * np.repeat(step, pieces, axis=0)
    width, row = np.repeat(laid.width, pieces), np.repeat(laid.row, pieces)
    return replace(laid, points=points, start=start[laid.start], width=width, row=row), left


def _steps(points: FloatArray) -> FloatArray:
    """(N,) mm from the point before, 0 for the first."""
    lengths = np.zeros(len(points))
    step = np.diff(points, axis=0)
    lengths[1:] = np.sqrt(np.einsum("ij,ij->i", step, step))
    return lengths


def _or_next_to(marked: BoolArray) -> BoolArray:
    """(N,) points that are marked or have a marked neighbor."""
    spread = marked.copy()
    spread[1:] |= marked[:-1]
    spread[:-1] |= marked[1:]
    return spread


def _eased(share: FloatArray) -> FloatArray:
    """From 0 to 1 without a bend at either end."""
    clipped = np.clip(share, 0.0, 1.0)
    eased: FloatArray = clipped * clipped * (3.0 - 2.0 * clipped)
    return eased

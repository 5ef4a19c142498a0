"""Lines moved away from an outline: how far they go before they fold over themselves."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from .along_loops import cross, dot, filtered, previous, steps

# At tips sharper than the line, where the inset line would fold back, the inset is halved, UNFOLDINGS times at most. A
# step folds back if it keeps less than the share UNFOLDED of its length in its own direction.
UNFOLDINGS, UNFOLDED = 5, 0.2
# In a bend a line may be moved by this share of the distance at which its rays meet, less a gap in mm: tips thinner
# than twice the gap could cross themselves once the polyline is simplified within the chord tolerance.
BEND_SHARE, TIP_GAP = 0.95, 0.08
# Points added to the search around tips, where inset points lie closer together than elsewhere.
TIP_POINTS = 4
# Of two rays that cross, both end before the crossing if the shorter one has at least this share of the longer one.
NEARER = 0.9


def inset(
    points: FloatArray, normal: FloatArray, depth: FloatArray, start: IntArray, kernel: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray | float]:
    """An outline moved inwards, less far where it would fold back on itself.

    Args:
        points: (2, N) mm, of closed loops.
        normal: (2, N) unit vectors out of them.
        depth: (N,) mm.
        start: (M + 1,) offsets of the loops.
        kernel: low-pass that smooths the reduced depth at a fold into that of its neighbors.

    Returns:
        (2, N) mm, the points; (2, N) mm, the step from each to the next; and 0 to 1, (N,) or one for all, the share of
        room left for a wave: 0 where the inset had to be halved.
    """
    along = steps(points, start)
    least = UNFOLDED * dot(along, along)
    base, wanted = points - normal * depth, depth
    step = steps(base, start)
    for _ in range(UNFOLDINGS):
        turned = dot(step, along) < least
        if not turned.any():
            break
        folded = turned.astype(np.float64)
        ends = np.maximum(folded, previous(folded, start))
        depth = depth * (1 - 0.5 * np.minimum(2 * len(kernel) * filtered(ends, start, kernel), 1.0))
        base = points - normal * depth
        step = steps(base, start)
    unbent = 1.0 if depth is wanted else np.clip(2 * depth / np.maximum(wanted, 1e-9) - 1, 0.0, 1.0)
    return base, step, unbent


def bend_room(
    points: FloatArray,
    square: FloatArray,
    normal: FloatArray,
    turning: FloatArray,
    way: int,
    start: IntArray,
    reach: float,
) -> FloatArray:
    """How far points of lines may be moved, all at once, before they meet on the inside of a bend.

    Each point moves along a ray. Where two rays cross, the one with the longer way to the crossing has to stop there.

    Args:
        points: (2, N) mm, of closed loops.
        square: (N,) mm², squared length of the step from each to the next.
        normal: (2, N) unit vectors.
        turning: (N,) mm, by which a step gets longer, times its length, per millimeter moved along the normals.
        way: 1 where points move along the normals, -1 against them.
        start: (M + 1,) offsets of the loops.
        reach: mm, the farthest that a line is moved.

    Returns:
        (N,) mm, at most `reach`.
    """
    room, longest = np.full(points.shape[1], reach), (reach + TIP_GAP) / BEND_SHARE
    sharp = np.flatnonzero(turning * (-way * longest) > square)
    if not len(sharp):
        return room
    # Points farther apart than twice the length of their rays cannot meet; around tips they lie closer together.
    span = np.arange(int(np.ceil(2 * longest / np.sqrt(square.max()))) + TIP_POINTS)
    near = np.zeros(points.shape[1], dtype=bool)
    near[_along(sharp[:, None], -span, start)] = True
    this = np.flatnonzero(near)[:, None]
    other = _along(this, span + 1, start)
    own, others = normal.take(this, axis=1), normal.take(other, axis=1)
    apart, turn = points.take(other, axis=1) - points.take(this, axis=1), way * cross(own, others)
    turn[np.abs(turn) < 1e-9] = np.inf
    ways, others_ways = cross(apart, others) / turn, cross(apart, own) / turn
    pair, step = np.nonzero((np.minimum(ways, others_ways) > 0) & (NEARER * np.maximum(ways, others_ways) < longest))
    this, other, ways, others_ways = this[pair, 0], other[pair, step], ways[pair, step], others_ways[pair, step]
    for index, own_way, beside in ((this, ways, others_ways), (other, others_ways, ways)):
        last = own_way >= NEARER * beside
        np.minimum.at(room, index[last], np.maximum(BEND_SHARE * own_way[last] - TIP_GAP, 0.0))
    return room


def _along(point: IntArray, step: IntArray, start: IntArray) -> IntArray:
    """(Q, K) the points that are `step` (K,) steps farther along their loops than points (Q, 1)."""
    loop = np.searchsorted(start, point, side="right") - 1
    begin = start[loop]
    return np.asarray(begin + (point - begin + step) % (start[loop + 1] - begin))

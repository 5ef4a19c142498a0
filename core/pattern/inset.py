"""Lines moved away from an outline: how far they go before they fold over themselves."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from .along_loops import cross, dot, filtered, previous, steps

# Where the line would fold back by its inset, at tips sharper than the line, the inset is halved, at most so often.
UNFOLDINGS, UNFOLDED = 5, 0.2
# In a bend a line may be moved by this share of the way on which its points meet, and ends so far before, mm: a tip is
# no thinner than twice this, or the polyline within the chord tolerance of it would cross itself.
BEND_SHARE, TIP_GAP = 0.95, 0.08
# So many points more are looked at around tips, where the inset ones lie closer together than elsewhere.
TIP_POINTS = 4
# Of two rays that cross, both end before it where one comes to it after at least this share of the other's way.
NEARER = 0.9


def inset(
    points: FloatArray, normal: FloatArray, depth: FloatArray, start: IntArray, kernel: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray | float]:
    """An outline moved inwards, by less where it would turn back on itself.

    Args:
        points: (2, N) mm, of closed loops.
        normal: (2, N) unit vectors out of them.
        depth: (N,) mm.
        start: (M + 1,) offsets of the loops.
        kernel: low-pass, by which what is less at a fold goes over into what is beside it.

    Returns:
        (2, N) mm, from each to the next (2, N) mm, and 0 to 1, (N,) or one for all, how much room for a wave such a tip
        leaves: none where the inset had to be halved.
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
    """How far points of lines may be moved before they meet others that are moved too, on the inside of a bend.

    Each moves on a ray; of two rays that cross, the one on which the crossing is farther away ends before it.

    Args:
        points: (2, N) mm, of closed loops.
        square: (N,) mm², of how far it is from each to the next.
        normal: (2, N) unit vectors.
        turning: (N,) mm, along the step, by which neighbours get farther apart that move a millimetre along them.
        way: 1 where points move along the normals, -1 against them.
        start: (M + 1,) offsets of the loops.
        reach: mm, as far as anything is moved.

    Returns:
        (N,) mm, at most `reach`.
    """
    room, longest = np.full(points.shape[1], reach), (reach + TIP_GAP) / BEND_SHARE
    sharp = np.flatnonzero(turning * (-way * longest) > square)
    if not len(sharp):
        return room
    # Points farther apart than twice the length of their rays are out of reach; around tips they lie closer together.
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
    """(Q, K) points that many steps farther along their loops than points (Q, 1)."""
    loop = np.searchsorted(start, point, side="right") - 1
    begin = start[loop]
    return np.asarray(begin + (point - begin + step) % (start[loop + 1] - begin))

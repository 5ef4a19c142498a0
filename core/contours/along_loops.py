"""Values along closed loops: differences to neighbors, and low-pass filters.

Coordinates are rows here, (2, N): arithmetic on long rows is several times as fast as on N pairs.
"""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray


def rows(points: FloatArray) -> FloatArray:
    """(2, N) of points (N, 2)."""
    return np.stack([points[:, 0], points[:, 1]])


def steps(values: FloatArray, start: IntArray) -> FloatArray:
    """(…, N) difference from each value to the next one of its loop; `start` (M + 1,) are offsets, no loop is empty."""
    step = np.empty_like(values)
    np.subtract(values[..., 1:], values[..., :-1], out=step[..., :-1])
    last = start[1:] - 1
    step[..., last] = values[..., start[:-1]] - values[..., last]
    return step


def around(values: FloatArray, start: IntArray) -> FloatArray:
    """(…, N) difference from the value before each one to the one after it; every loop has two or more."""
    step, first, last = np.empty_like(values), start[:-1], start[1:] - 1
    np.subtract(values[..., 2:], values[..., :-2], out=step[..., 1:-1])
    step[..., first] = values[..., first + 1] - values[..., last]
    step[..., last] = values[..., first] - values[..., last - 1]
    return step


def previous(values: FloatArray, start: IntArray) -> FloatArray:
    """(…, N) the value before each one of its loop; no loop is empty."""
    before = np.empty_like(values)
    before[..., 1:] = values[..., :-1]
    before[..., start[:-1]] = values[..., start[1:] - 1]
    return before


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """(N,) of vectors (2, N)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1])


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """(N,) of vectors (2, N)."""
    return np.asarray(a[0] * b[1] - a[1] * b[0])


def gaussian(sigma: float) -> FloatArray:
    """Weights of a Gaussian with this standard deviation (in samples), cut at three of them; they sum to 1."""
    reach = int(np.ceil(3 * sigma))
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / max(sigma, 1e-9)) ** 2)
    return np.asarray(weight / weight.sum())


def box(reach: int) -> FloatArray:
    """(2 reach + 1,) equal weights of a value and `reach` neighbors on both sides; they sum to 1."""
    return np.full(2 * reach + 1, 1 / (2 * reach + 1))


def filtered(values: FloatArray, start: IntArray, kernel: FloatArray) -> FloatArray:
    """Convolve values (N,) or (D, N) around each closed loop with a symmetric kernel of odd length.

    Args:
        values: of N points.
        start: (M + 1,) offsets of the loops; no loop is empty.
        kernel: (2 R + 1,) weights, three at least.
    """
    if not values.size:
        return values
    reach, long = len(kernel) // 2, values.shape[-1]
    # Near the ends of a loop the plain convolution mixes in other loops; these values are computed again, cyclically.
    around = start[:-1, None] + np.arange(-2 * reach, 2 * reach) % np.diff(start)[:, None]
    smooth = np.empty_like(values)
    for row, low_passed in zip(np.atleast_2d(values), np.atleast_2d(smooth), strict=True):
        low_passed[:] = np.convolve(row, kernel)[reach : reach + long]
        near = np.convolve(row.take(around).ravel(), kernel, "same").reshape(around.shape)
        low_passed[around[:, reach : 3 * reach]] = near[:, reach : 3 * reach]
    return smooth

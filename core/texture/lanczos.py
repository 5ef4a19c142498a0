"""Reduces a picture to the resolution of the print, once, by a Lanczos filter."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, Float32Array, FloatArray

_LEAST_COVERAGE = 0.05  # below this the negative lobes outweigh the covered texels


def texel_spacing(corners: FloatArray, texels: FloatArray) -> tuple[float, float]:
    """Median width and height of a texel on the object, in mm, over the faces weighted by their area.

    Args:
        corners: (T, 3, 3) mm of the faces.
        texels: (T, 3, 2) texels, the same corners in the picture.

    Returns:
        mm per texel along u and along v: the lengths of the columns of each face's Jacobian. (inf, inf) where no face
        has an area in the picture, so that nothing is reduced.
    """
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p, q = texels[:, 1] - texels[:, 0], texels[:, 2] - texels[:, 0]
    determinant = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    area = np.linalg.norm(np.cross(first, second), axis=1)
    sound = (np.abs(determinant) > 1e-9) & (area > 0)
    if not sound.any():
        return np.inf, np.inf
    inverse = 1.0 / determinant[sound, None]
    first, second, p, q, area = first[sound], second[sound], p[sound], q[sound], area[sound]
    along_u = np.linalg.norm((first * q[:, 1:] - second * p[:, 1:]) * inverse, axis=1)
    along_v = np.linalg.norm((second * p[:, :1] - first * q[:, :1]) * inverse, axis=1)
    return _median(along_u, area), _median(along_v, area)


def reduced(
    paint: Float32Array, alpha: Float32Array, covered: BoolArray, scale: tuple[float, float]
) -> tuple[Float32Array, Float32Array]:
    """Reduce a picture; texels outside the charts have no weight unless there is nothing else.

    Args:
        paint: (H, W) tone times alpha.
        alpha: (H, W).
        covered: (H, W) texels that a chart covers.
        scale: new width and height as a share of the old; the picture is never enlarged.

    Returns:
        (h, w) paint and alpha.
    """
    height, width = paint.shape
    size = max(1, round(width * min(scale[0], 1.0))), max(1, round(height * min(scale[1], 1.0)))
    if size == (width, height):
        return paint, alpha
    plain = resized(paint, size), resized(alpha, size)
    if covered.all():
        paint, alpha = plain
    else:
        weight = covered.astype(np.float32)
        share = resized(weight, size)
        sound = share > _LEAST_COVERAGE
        divisor = np.where(sound, share, np.float32(1.0))
        paint = np.where(sound, resized(paint * weight, size) / divisor, plain[0])
        alpha = np.where(sound, resized(alpha * weight, size) / divisor, plain[1])
    alpha = np.clip(alpha, 0.0, 1.0)
    return np.clip(paint, 0.0, alpha), alpha  # no tone above 1


def resized(
    image: Float32Array, size: tuple[int, int], box: tuple[float, float, float, float] | None = None
) -> Float32Array:
    """A picture (H, W) of another size.

    Args:
        image: any values.
        size: new width and height.
        box: left, upper, right and lower border of the part that is taken, pixels; None takes all.
    """
    from PIL import Image

    picture = Image.fromarray(np.ascontiguousarray(image)).resize(size, Image.Resampling.LANCZOS, box=box)
    return np.asarray(picture, dtype=np.float32)


def _median(values: FloatArray, weights: FloatArray) -> float:
    """The value with half of the weight on either side."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(reached, reached[-1] / 2)]])

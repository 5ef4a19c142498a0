"""Photographs of the step wedge whose truth is known: warped, unevenly lit, with the pattern's own structure."""

import numpy as np
from dualcolor.core.calibration.homography import projected, square_to
from dualcolor.core.calibration.step_wedge import COLUMNS, MARKS, ROWS, patches, quarter_tones
from dualcolor.core.texture.decode import srgb_from_linear

FRAME = 0.5  # of a patch, around the grid


def marks_in(corners):
    """(4, 2) where the marks are if the tile's outer corners are these."""
    size = np.array([COLUMNS, ROWS]) + 2 * FRAME
    return projected(square_to(np.asarray(corners, dtype=float)), (MARKS + FRAME) / size)


def light_on_wedge(shape, corners, response, settings, contrast=0.3, fall_off=0.5, ground=0.6, veil=0.0):
    """(H, W) linear light.

    Args:
        shape: (H, W).
        corners: (4, 2) pixels of the tile's outer corners, clockwise from its upper left.
        response: reflectance of a tone, as a function.
        settings: of the print.
        contrast: of the strands about the mean.
        fall_off: how much darker the far side is.
        ground: reflectance of what the tile lies on.
        veil: light that is added everywhere.
    """
    row, column = np.indices(shape)
    pixel = np.stack([column.ravel(), row.ravel()], axis=1) + 0.5
    size = np.array([COLUMNS, ROWS]) + 2 * FRAME
    place = projected(np.linalg.inv(square_to(np.asarray(corners, dtype=float))), pixel) * size - FRAME
    quarter = np.floor(2 * place).astype(int)
    on_grid = ((quarter >= 0) & (quarter < (2 * COLUMNS, 2 * ROWS))).all(axis=1)
    on_tile = ((place > -FRAME) & (place < (COLUMNS + FRAME, ROWS + FRAME))).all(axis=1)
    at = np.clip(quarter, 0, (2 * COLUMNS - 1, 2 * ROWS - 1))
    tone = np.where(on_grid, quarter_tones()[at[:, 1], at[:, 0]], 0.5)
    mm = patches(settings)
    x, y = place[:, 0] * mm.width, place[:, 1] * mm.height
    layer = np.floor(y / settings.layer_height).astype(int)
    strand = np.where(layer % 2, 1, -1) * np.where((layer + 1) // 2 % 2, 1, -1) * np.cos(2 * np.pi * x / 1.37)
    reflectance = np.where(on_tile, response(tone) * (1 + contrast * strand), ground)
    wide = shape[1]
    far = np.hypot(pixel[:, 0] / wide - 0.1, pixel[:, 1] / wide - 0.1)
    return (reflectance * (1.0 / (1.0 + fall_off * far**2 * 2)) + veil).reshape(shape)


def developed(light, noise=0.004, seed=0):
    """(H, W, 3) uint8, sRGB, with the noise of a camera."""
    noisy = light * (1 + np.random.default_rng(seed).normal(scale=noise, size=light.shape))
    return np.repeat(np.rint(srgb_from_linear(noisy) * 255).astype(np.uint8)[..., None], 3, axis=2)

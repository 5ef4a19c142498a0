"""Layers on which a stroke may change the tone: all on which it does."""

from concurrent.futures import Future
from dataclasses import replace

import numpy as np
import pytest
from dualcolor.core.job.repainted import other_layers, repainted_layers
from dualcolor.core.job.wall_stages import painted_tone
from dualcolor.core.mesh.plate import plate
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.model import ToneImage
from dualcolor.core.settings import PrintSettings
from dualcolor.core.texture.pyramid import build_pyramids
from dualcolor.tests.pattern_stages import lines_of
from dualcolor.tests.solids import cylinder

SETTINGS, LAYERS = PrintSettings(pattern="offset"), 24


def pictures(rng, sizes, least_alpha):
    sizes = [(size, rng.uniform(least_alpha, 1, size)) for size in sizes]
    return [ToneImage(rng.random(size, dtype=np.float32), alpha.astype(np.float32)) for size, alpha in sizes]


def stroked(image, rng, of_alpha):
    column = image.alpha.copy() if of_alpha else image.tone.copy()
    row, left = (int(rng.integers(0, side - 1)) for side in column.shape)
    column[row : row + rng.integers(1, 9), left : left + rng.integers(1, 9)] *= 0.5
    return replace(image, **{"alpha" if of_alpha else "tone": column})


@pytest.mark.parametrize("repeat", [1.0, 2.3])
@pytest.mark.parametrize("size", [(64, 48), (300, 410), (7, 5)])
@pytest.mark.parametrize("least_alpha", [0.0, 1.0])
def test_no_layer_whose_tone_changes_is_missed(repeat, size, least_alpha):
    rng = np.random.default_rng(size[0])
    images = pictures(rng, [size, (50, 64)], least_alpha)
    parts = [cylinder(5, 6, 32, x=20 * number, textures=(image,)) for number, image in enumerate(images)]
    model = plate([replace(part, corner_uv=part.corner_uv * repeat - 0.2) for part in parts], SETTINGS)
    mesh, lines = triangulate(model, SETTINGS), lines_of(model, SETTINGS)

    def known(these):
        made = Future()
        made.set_result(build_pyramids(mesh, these, 0.5, "trilinear"))
        return made, painted_tone(made.result(), lines, SETTINGS)

    former, few = model.textures, 0
    _, tone = known(former)
    for number in range(6):
        one = number % 2
        new = tuple(stroked(image, rng, number > 3) if place == one else image for place, image in enumerate(former))
        made, after = known(new)
        maybe = repainted_layers(new, made, lines, LAYERS, former)
        truly = other_layers((after,), lines, LAYERS, (tone,))
        assert truly.any() and (maybe is None or not (truly & ~maybe).any())
        few += maybe is not None and maybe.mean() < 0.5
        former, tone = new, after
    assert few or size[0] < 10 or repeat > 1


def test_what_is_not_told_by_tiles():
    rng = np.random.default_rng(0)
    (image,) = pictures(rng, [(64, 64)], 1.0)
    model = cylinder(5, 6, 32, textures=(image,))
    mesh, lines, made = triangulate(model, SETTINGS), lines_of(model, SETTINGS), Future()
    made.set_result(build_pyramids(mesh, (image,), 0.5, "trilinear"))
    assert not repainted_layers((image,), made, lines, LAYERS, (ToneImage(image.tone.copy(), image.alpha),)).any()
    veiled = stroked(image, rng, True)
    larger = ToneImage(np.ones((64, 65), dtype=np.float32), np.ones((64, 65), dtype=np.float32))
    for others in ((veiled,), (larger,), (), (image, image)):
        assert repainted_layers((image,), made, lines, LAYERS, others) is None
    made = Future()
    made.set_result(build_pyramids(mesh, (image,), 0.5, "lanczos"))
    assert repainted_layers((image,), made, lines, LAYERS, (stroked(image, rng, False),)) is None

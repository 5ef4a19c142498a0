"""Whatever picture is given: tones between black and white wherever they are asked for, or one sentence."""

from pathlib import Path

import numpy as np
import pytest
from dualcolor.core.errors import PrintError
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.model import ToneImage
from dualcolor.core.settings import PrintSettings
from dualcolor.core.texture.decode import tone_image
from dualcolor.core.texture.lookup import tone_at
from dualcolor.core.texture.pyramid import build_pyramids
from dualcolor.tests.robustness.strategies import examples, pixels, soups
from dualcolor.tests.solids import surface
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

pytestmark = pytest.mark.filterwarnings("error::RuntimeWarning")  # numpy's, which a user would see
WALL = np.array([[0, 0, 0], [10, 0, 0], [10, 0, 10], [0, 0, 10], [5, 4, 0]], dtype=float)
FACES = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2], [4, 0, 3], [4, 3, 2], [0, 4, 1]])
UVS = arrays(
    np.float64, (len(FACES) * 3, 2), elements=st.one_of(st.floats(0, 1), st.floats(), st.sampled_from([0.0, 0.5, 1.0]))
)
FOOTPRINTS = st.sampled_from([0.1, 0.5, 20.0])
FILTERS = st.sampled_from(["trilinear", "lanczos"])
SHARES = np.random.default_rng(1).dirichlet([1, 1, 1], (len(FACES), 9))


def tones_on_the_wall(image, uv, footprint, texture_filter, background=0.5):
    """At nine places of each face, and at its corners."""
    mesh = triangulate(surface(WALL, FACES, uv, (image,)), PrintSettings())
    pyramids = build_pyramids(mesh, (image,), footprint, texture_filter)
    shares = np.concatenate([SHARES, np.broadcast_to(np.eye(3), (len(FACES), 3, 3))], axis=1)
    face = np.repeat(np.arange(len(FACES)), shares.shape[1])
    at = np.einsum("fqc,fcd->fqd", shares, mesh.face_uv).reshape(-1, 2)
    return tone_at(pyramids, face, at, np.full(len(face), np.nan), background)


@given(pixels(), st.booleans(), st.booleans())
@examples(150)
def test_any_pixels_are_tones(rgba, encoded, premultiplied):
    image = tone_image(rgba, encoded, premultiplied)
    assert image.tone.shape == image.alpha.shape == rgba.shape[:2]
    for values in (image.tone, image.alpha):
        assert values.dtype == np.float32 and ((values >= 0) & (values <= 1)).all()
    assert not image.alpha[~np.isfinite(rgba).all(axis=2)].any()


@given(pixels(), UVS, FOOTPRINTS, FILTERS, st.floats(0, 1))
@examples(80)
def test_any_map_of_any_picture_gives_tones(rgba, uv, footprint, texture_filter, background):
    tone = tones_on_the_wall(tone_image(rgba, True), uv, footprint, texture_filter, background)
    assert ((tone >= 0) & (tone <= 1)).all()


@given(st.integers(1, 40), st.integers(1, 40), st.floats(0, 1, width=32), UVS, FOOTPRINTS, FILTERS)
@examples(80)
def test_an_even_picture_is_even_however_it_is_mapped(height, width, value, uv, footprint, texture_filter):
    uv = np.where(np.isfinite(uv), np.clip(uv, -3, 3), 0.0)
    even = ToneImage(np.full((height, width), value, np.float32), np.ones((height, width), np.float32))
    np.testing.assert_allclose(tones_on_the_wall(even, uv, footprint, texture_filter), value, atol=1e-5)


@given(soups(), pixels(), FOOTPRINTS, FILTERS, st.integers(0, 99))
@examples(60)
def test_any_mesh_takes_any_picture(model, rgba, footprint, texture_filter, seed):
    uv = np.random.default_rng(seed).uniform(-0.5, 1.5, (len(model.corner_vertex), 2))
    image = tone_image(rgba, False)
    try:
        mesh = triangulate(surface(model.vertices, model.corner_vertex.reshape(-1, 3), uv, (image,)), PrintSettings())
    except PrintError:
        return
    pyramids = build_pyramids(mesh, (image,), footprint, texture_filter)
    face = np.arange(len(mesh.faces))
    tone = tone_at(pyramids, face, mesh.face_uv.mean(axis=1), np.full(len(face), np.nan), 0.5)
    assert ((tone >= 0) & (tone <= 1)).all()


KINDS = [
    *((mode, "png") for mode in ("1", "L", "LA", "P", "RGB", "RGBA", "I;16")),
    *(("L", "jpg"), ("RGB", "jpg"), ("RGB", "tif"), ("F", "tif"), ("RGBA", "webp"), ("RGB", "bmp"), ("RGBA", "tga")),
]


def drawn(mode, width, height, seed):
    """A picture of noise."""
    random = np.random.default_rng(seed)
    if mode in ("I;16", "F"):
        values = random.integers(0, 65536, (height, width))
        return Image.fromarray(values.astype(np.uint16) if mode == "I;16" else (values / 50_000).astype(np.float32))
    return Image.fromarray(random.integers(0, 256, (height, width, 4)).astype(np.uint8)).convert(mode)


@pytest.fixture
def folder(scene, tmp_path):
    """For files of pictures that Blender loads."""
    return tmp_path


@given(st.sampled_from(KINDS), st.integers(1, 40), st.integers(1, 40), st.integers(0, 99), st.floats(0, 2))
@examples(60)
def test_any_file_of_a_picture_is_read_or_refused(folder, kind, width, height, seed, share):
    """Whole for a share of 1 and more, else cut short."""
    import bpy
    from dualcolor.bridge.input.image_input import image_tone, load_image

    mode, suffix = kind
    path = Path(folder) / f"picture.{suffix}"
    drawn(mode, width, height, seed).save(path)
    data = path.read_bytes()
    path.write_bytes(data[: max(1, int(share * len(data)))])
    try:
        image = load_image(path)
        found = image_tone(image)
        bpy.data.images.remove(image)
    except PrintError as problem:
        assert share < 1 and "\n" not in str(problem)
        return
    assert found.tone.shape == (height, width)
    assert ((found.tone >= 0) & (found.tone <= 1)).all() and ((found.alpha >= 0) & (found.alpha <= 1)).all()

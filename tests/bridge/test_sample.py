"""The sample: a watertight bust with a coat, the same every time."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

import bmesh  # noqa: E402
from dualcolor.bridge.objects import sample  # noqa: E402
from dualcolor.tests.scene import extent, model_of  # noqa: E402


@pytest.fixture(scope="module")
def suzanne():
    """The sample with a small picture and coarse shading, for speed, and its model."""
    pytest.importorskip("xatlas")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sample, "IMAGE_SIZE", 256)
        patch.setattr(sample, "AO_SAMPLES", 2)
        patch.setattr(sample, "SUBDIVISIONS", 1)
        obj = sample.make_sample()
        return obj.name, model_of(obj), _bmesh_facts(obj)


def _bmesh_facts(obj):
    work = bmesh.new()
    work.from_mesh(obj.data)
    facts = all(edge.is_manifold for edge in work.edges), work.calc_volume(signed=True)
    base = sum(face.calc_area() for face in work.faces if face.normal.z < -0.999 and face.calc_center_median().z < 0.01)
    work.free()
    return *facts, base


def test_it_is_watertight_and_stands_flat_at_60_mm(suzanne):
    _, model, (manifold, volume, base) = suzanne
    assert manifold and volume > 50_000
    assert extent(model)[2] == pytest.approx(60, abs=1e-3)
    assert model.vertices[:, 2].min() == pytest.approx(0, abs=1e-4)
    assert base > 400  # mm² on the bed


def test_every_face_has_its_place_in_the_picture(suzanne):
    _, model, _ = suzanne
    assert len(model.textures) == 1 and (model.polygon_texture == 0).all()
    assert model.corner_uv.min() >= 0 and model.corner_uv.max() <= 1
    texels = np.floor(model.corner_uv * 256).astype(int).clip(0, 255)
    assert model.textures[0].alpha[texels[:, 1], texels[:, 0]].min() == 1


def test_the_coat_is_mostly_white_with_black_and_gray_patches(suzanne):
    _, model, _ = suzanne
    uv = model.corner_uv.reshape(-1, 3, 2).mean(axis=1)
    a, b, c = np.swapaxes(model.vertices[model.corner_vertex.reshape(-1, 3)], 0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    texels = np.floor(uv * 256).astype(int).clip(0, 255)
    tone = model.textures[0].tone[texels[:, 1], texels[:, 0]]
    share = [
        float(area[chosen].sum() / area.sum()) for chosen in (tone < 0.1, (tone > 0.1) & (tone < 0.35), tone > 0.5)
    ]
    assert 0.1 < share[0] < 0.45 and 0.05 < share[1] < 0.5 and share[2] > 0.3


def test_white_is_shaded_in_the_creases_only(suzanne):
    """Ambient occlusion is in the picture: white where the surface lies open, darker where it does not."""
    _, model, _ = suzanne
    middle = model.vertices[model.corner_vertex.reshape(-1, 3)].mean(axis=1)
    color = sample.coat((middle / sample.HEIGHT_MM).astype(np.float32))
    white = (color == sample.WHITE).all(axis=1)
    texels = np.floor(model.corner_uv.reshape(-1, 3, 2).mean(axis=1) * 256).astype(int).clip(0, 255)
    shade = model.textures[0].tone[texels[:, 1], texels[:, 0]][white] / float(sample.WHITE @ [0.2126, 0.7152, 0.0722])
    assert np.quantile(shade, 0.9) > 0.9 and (shade < 0.6).mean() > 0.03


def test_noise_is_smooth_periodic_and_within_bounds():
    points = np.random.default_rng(3).uniform(-20, 20, (2000, 3)).astype(np.float32)
    noise = sample.value_noise(points, seed=1)
    assert noise.min() >= 0 and noise.max() <= 1 and noise.std() > 0.1
    step = sample.value_noise(points + np.float32(0.001), seed=1) - noise
    assert np.abs(step).max() < 0.01
    np.testing.assert_allclose(sample.value_noise(points + 16, seed=1), noise, atol=1e-3)
    assert np.abs(sample.value_noise(points, seed=2) - noise).mean() > 0.05


def test_at_lattice_points_noise_is_the_lattice():
    lattice = np.random.default_rng(7).random((16, 16, 16))
    at = np.array([[1, 2, 3], [15, 0, 7], [-1, 16, 4]])
    expected = lattice[at[:, 0] % 16, at[:, 1] % 16, at[:, 2] % 16]
    np.testing.assert_allclose(sample.value_noise(at.astype(np.float32), seed=7), expected, atol=1e-6)


def test_the_picture_travels_with_the_file(suzanne):
    assert bpy.data.images["Calico coat"].packed_file is not None

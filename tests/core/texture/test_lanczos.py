"""Pictures reduced to one texel a layer pair by Lanczos: sizes, values, edges."""

import numpy as np
import pytest
from dualcolor.core.model import TriangleMesh
from dualcolor.core.texture.lanczos import reduced
from dualcolor.core.texture.lookup import tone_at
from dualcolor.core.texture.pyramid import build_pyramids
from dualcolor.tests.core.texture.textured_plates import image, plates


def test_lanczos_lands_a_60_by_71_picture_on_142_layers_one_to_one():
    tone = np.random.default_rng(6).random((71, 60)).astype(np.float32)
    mesh = plates((0, 0, 1, 1))
    vertices = mesh.vertices * [30 / 40, 1, 35.5 / 40]
    mesh = TriangleMesh(vertices, mesh.faces, mesh.face_uv, mesh.face_tone, mesh.face_texture)
    pyramids = build_pyramids(mesh, (image(tone),), 0.5, "lanczos")
    z = (np.arange(142) + 0.5) * 0.25
    for column in range(60):
        uv = np.c_[np.full(142, (column + 0.5) / 60), z / 35.5]
        found = tone_at(pyramids, np.zeros(142, int), uv, np.full(142, np.nan), 0.5)
        assert np.array_equal(found[0::2], tone[:, column].astype(float))
        assert np.array_equal(found[1::2], tone[:, column].astype(float))


def test_lanczos_reduces_each_direction_by_its_own_spacing_and_never_enlarges():
    mesh = plates((0, 0, 1, 1))
    mesh = TriangleMesh(mesh.vertices * [2, 1, 0.5], mesh.faces, mesh.face_uv, mesh.face_tone, mesh.face_texture)
    picture = image(np.random.default_rng(7).random((200, 400)))
    level = build_pyramids(mesh, (picture,), 0.5, "lanczos").pictures[0].levels[0]
    assert (level.height, level.width) == (40, 160)  # 20 mm high, 80 mm wide
    assert level.paint.mean() == pytest.approx(picture.tone.mean(), abs=2e-3)
    assert level.paint.min() >= 0 and level.paint.max() <= 1
    assert build_pyramids(mesh, (picture,), 0.01, "lanczos").pictures[0].levels[0].paint.size == 200 * 400


def test_lanczos_does_not_overshoot_at_an_edge():
    tone = np.broadcast_to(np.arange(200) < 101, (200, 200))
    for alpha in (1.0, tone * 0.5):
        level = build_pyramids(plates((0, 0, 1, 1)), (image(tone, alpha),), 0.5, "lanczos").pictures[0].levels[0]
        assert level.paint.size == 80 * 80
        assert level.paint.min() >= 0 and (level.paint <= level.alpha).all() and level.alpha.max() <= 1


def test_lanczos_does_not_care_how_the_picture_is_turned_on_the_object():
    mesh = plates((0, 0, 1, 1))
    turned = TriangleMesh(
        mesh.vertices[:, [2, 1, 0]] * [2, 1, 0.5], mesh.faces, mesh.face_uv, mesh.face_tone, mesh.face_texture
    )
    level = build_pyramids(turned, (image(np.full((200, 400), 0.5)),), 0.5, "lanczos").pictures[0].levels[0]
    assert (level.height, level.width) == (160, 40)


def test_texels_are_weighted_by_a_sinc_in_the_window_of_a_wider_one():
    tone = np.random.default_rng(8).uniform(0.4, 0.6, (60, 60)).astype(np.float32)
    whole = np.ones_like(tone)
    paint, alpha = reduced(tone, whole, whole > 0, (0.5, 0.5))
    away = (np.arange(60) + 0.5 - 2 * (np.arange(30)[:, None] + 0.5)) / 2  # in texels of the result
    weight = np.where(np.abs(away) < 3, np.sinc(away) * np.sinc(away / 3), 0.0)
    weight /= weight.sum(axis=1, keepdims=True)
    assert paint == pytest.approx(weight @ tone @ weight.T, abs=1e-5)
    assert alpha == pytest.approx(1.0, abs=1e-6)

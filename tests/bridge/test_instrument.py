"""The measuring camera: what it reads of surfaces that are known."""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.measuring.instrument import Face, mounted, photograph, view_axes  # noqa: E402
from dualcolor.bridge.pictures.plastics import diffuse_material  # noqa: E402
from dualcolor.core.errors import PrintError  # noqa: E402
from dualcolor.core.job.layers import joined  # noqa: E402
from dualcolor.core.paths import Feature  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.toolpaths.moves import Moves  # noqa: E402

SETTINGS = PrintSettings()
FACE = Face((5.0, 0.0, 5.0), 10.0, 8.0)


def lines(ends, feature=Feature.OUTER_WALL, layer=0, tool=1):
    """Strands 0.4 x 0.25 mm between pairs of points (K, 2, 3)."""
    ends = np.asarray(ends, dtype=float)
    count = 2 * len(ends)
    extrudes = np.arange(count) % 2 == 1
    whole = np.full(count, 1, dtype=np.int64)
    return Moves(
        position=ends.reshape(-1, 3),
        tool=whole * tool,
        feature=np.where(extrudes, feature, Feature.TRAVEL),
        layer=whole * layer,
        width=extrudes * 0.4,
        height=extrudes * 0.25,
        speed=whole * 30.0,
        filament=extrudes * 1.0,
    )


@pytest.fixture
def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def add_plane(face, reflectance):
    """A matt plane in the face, in the scene of the stand, which has its origin in the face's center."""
    right, up, out = face.axes
    corners = [out + x * 50 * right + y * 50 * up for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([corner.tolist() for corner in corners], [], [(0, 1, 2, 3)])
    mesh.materials.append(diffuse_material("matt", reflectance, 1.0, 1.0))
    bpy.data.scenes["Instrument"].collection.objects.link(bpy.data.objects.new("plane", mesh))


@pytest.mark.parametrize("light", ["even", "lamp"])
@pytest.mark.parametrize(("slant", "phi", "theta"), [(0, 0, 0), (60, 0, 0), (30, -70, 0), (30, 0, 70)])
def test_matt_plane_reads_its_reflectance(empty, light, slant, phi, theta):
    face = Face((5.0, 0.0, 5.0), 10.0, 8.0, slant_deg=slant, azimuth_deg=20.0)
    with mounted(lines([[(0, 0, 5), (10, 0, 5)]]), SETTINGS, face, light) as stand:
        add_plane(face, 0.8)
        picture = stand.photograph(phi_deg=phi, theta_deg=theta, mm_per_pixel=0.5, samples=128)
    assert picture.shape == (16, 20) and picture.dtype == np.float32
    assert picture.mean() == pytest.approx(0.8, abs=0.015)


@pytest.mark.parametrize(
    "angles", [{}, {"phi_deg": 60.0}, {"phi_deg": -60.0}, {"theta_deg": 60.0}, {"theta_deg": -60.0}]
)
def test_picture_is_of_the_face_from_every_side(empty, angles):
    # A short strand above and to the right of the middle of the face.
    picture = photograph(lines([[(7.0, 0, 7.125), (8.0, 0, 7.125)]]), SETTINGS, FACE, **angles)
    row, column = np.nonzero(~np.isnan(picture))
    assert picture.shape == (80, 100)
    assert row.mean() == pytest.approx(80 - 60, abs=1.0) and column.mean() == pytest.approx(75, abs=1.0)
    assert np.ptp(column) + 1 >= 10.0


def test_rods_are_straight_and_have_round_ends(empty):
    """Whatever curves this Blender's Cycles draws: a long step before a short one around a corner, seen from above."""
    path = np.array([[2.0, 0, 5], [7.0, 0, 5], [7.0, 0.15, 5], [7.0, 2.0, 5]])
    moves = joined([lines(path[[k, k + 1]][None]) for k in range(3)])
    above = Face((5.0, 0.0, 5.0), 10.0, 8.0, slant_deg=89.9)
    seen = ~np.isnan(photograph(moves, SETTINGS, above, mm_per_pixel=0.02, samples=4))
    radius = 0.4 / math.sqrt(math.pi)
    x, y = np.meshgrid((np.arange(500) + 0.5) * 0.02, 4.0 - (np.arange(400) + 0.5) * 0.02)
    along, aside = np.clip(x, 2, 7), np.clip(y, 0, 2)
    away = np.minimum(np.hypot(x - along, y), np.hypot(x - 7.0, y - aside))
    assert seen[away < radius - 0.03].all() and not seen[away > radius + 0.03].any()


def test_view_looks_along_the_normal_and_is_lifted_and_turned():
    face = Face((0, 0, 0), 1, 1, slant_deg=30.0, azimuth_deg=0.0)
    assert view_axes(face, 0, 0)[2] == pytest.approx([0, -math.cos(math.pi / 6), 0.5])
    assert view_axes(face, 20, 0)[2] == pytest.approx(view_axes(Face((0, 0, 0), 1, 1, 50.0), 0, 0)[2])
    turned = view_axes(face, 0, 40)
    assert turned[2] @ face.axes[0] == pytest.approx(math.sin(math.radians(40)))
    assert turned[1] == pytest.approx(face.axes[1])
    assert np.linalg.det(view_axes(face, 15, 40)) == pytest.approx(1.0)


def test_same_seed_same_picture_and_nothing_is_left(empty):
    before = {
        kind: len(getattr(bpy.data, kind)) for kind in ("scenes", "objects", "hair_curves", "materials", "images")
    }
    with mounted(lines([[(0, 0, z), (10, 0, z)] for z in (1.0, 1.25, 1.5, 5.0, 5.25)]), SETTINGS, FACE) as stand:
        first, again, other = (stand.photograph(mm_per_pixel=0.2, samples=4, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(first, again, equal_nan=True)
    assert not np.array_equal(first, other, equal_nan=True)
    assert before == {kind: len(getattr(bpy.data, kind)) for kind in before}


PARTS = (Feature.OUTER_WALL, Feature.INNER_WALL, Feature.SKIN, Feature.BRIDGE, Feature.INFILL)


@pytest.mark.parametrize("feature", [each for each in Feature if each > Feature.RETRACT])
def test_only_what_the_object_is_made_of_is_photographed(empty, feature):
    moves = lines([[(0, 0, 5), (10, 0, 5)]], feature)
    if feature in PARTS:
        assert not np.isnan(photograph(moves, SETTINGS, FACE, samples=1)).all()
        return
    with pytest.raises(PrintError, match="no strands"):
        photograph(moves, SETTINGS, FACE)


def test_one_sample_a_pixel_reads_the_same_as_many_where_pixels_keep_step_with_the_layers(empty):
    """The middle of every pixel would hit every strand where it bulges out most."""
    moves = joined([lines([[(0, 0, z), (10, 0, z)]], layer=round(z / 0.25) - 1) for z in np.arange(0.25, 3.1, 0.25)])
    face = Face((5.0, -0.2, 1.5), 8.0, 2.0)
    few, many = (np.nanmean(photograph(moves, SETTINGS, face, mm_per_pixel=0.25, samples=n)) for n in (1, 64))
    assert few == pytest.approx(many, abs=0.04)

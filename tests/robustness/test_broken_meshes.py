"""Broken meshes print with a warning or are refused in one sentence, and what is printed is where the mesh is."""

from dataclasses import replace

import numpy as np
import pytest
from dualcolor.core.errors import MeshError
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.open_layers import heights
from dualcolor.core.slicing.planes import layer_stack
from dualcolor.core.slicing.slices import slices
from dualcolor.tests.robustness.winding import agreement
from dualcolor.tests.solids import box, cylinder, joined, surface

SETTINGS = PrintSettings()


def sliced(model):
    mesh = triangulate(model, SETTINGS)
    return mesh, slices(mesh, SETTINGS)


def flipped(model, faces):
    """With some of its triangles turned round."""
    corners = model.corner_vertex.reshape(-1, 3).copy()
    corners[faces] = corners[faces, ::-1]
    return replace(model, corner_vertex=corners.ravel())


@pytest.mark.parametrize(
    "model",
    [
        cylinder(8, 10),
        box((0, 0, 0), (10, 10, 10), inward=True),
        joined(box((0, 0, 0), (20, 20, 10)), box((4, 4, -1), (16, 16, 11), inward=True)),
        joined(box((0, 0, 0), (10, 10, 10)), box((5, 5, 0), (15, 15, 10)), box((7, 0, 2), (9, 20, 6))),
        joined(box((0, 0, 0), (10, 10, 10)), box((10, 0, 0), (20, 10, 10))),
        joined(box((0, 0, 0), (10, 10, 10)), box((0, 0, 0), (10, 10, 10))),
    ],
    ids=["cylinder", "inside out", "hole", "overlapping", "touching", "doubled"],
)
def test_slices_and_rays_agree(model):
    found = agreement(*sliced(model), 4000)
    assert found.disagreements == 0 and found.unambiguous > 3900 and found.inside > 500


def test_the_rays_see_a_slice_that_is_wrong():
    mesh, cut = sliced(cylinder(8, 10))
    regions = np.roll(np.array([*cut.regions[:-1], cut.regions[0].buffer(-1)]), 1)
    outlines = replace(cut.outlines, points=cut.outlines.points * 0.9)
    for wrong in ({"regions": regions}, {"outlines": outlines}):
        assert agreement(mesh, replace(cut, **wrong), 4000).disagreements > 0


def test_mixed_winding_is_closed_and_printed():
    model = flipped(box((0, 0, 0), (20, 20, 5)), [3, 8])
    _, cut = sliced(model)
    np.testing.assert_allclose([region.area for region in cut.regions], 400, rtol=1e-6)


def with_a_sail(*parts, low, high):
    """Solids, and a single quad from one height to another."""
    sail = surface(np.array([[2, 2, low], [8, 2, low], [8, 2, high], [2, 2, high]]), np.array([[0, 1, 2], [0, 2, 3]]))
    return joined(*parts, sail)


def test_layers_of_which_nothing_closes_are_left_out_and_named():
    gap = generate(with_a_sail(box((0, 0, 0), (10, 10, 2)), box((0, 0, 3), (10, 10, 5)), low=2, high=3), SETTINGS)
    assert gap.slices.open_layers.tolist() == [8, 9, 10, 11]
    printed = np.unique(gap.moves.layer[gap.moves.feature == Feature.OUTER_WALL])
    assert printed.tolist() == [*range(8), *range(12, 20)]
    assert any("do not close are left out: in 4 layers from 2.00 to 3.00 mm" in text for text in gap.warnings)
    assert any("to print from 2.00 to 3.00 mm, so what lies above begins in the air" in text for text in gap.warnings)
    top = generate(with_a_sail(box((0, 0, 0), (10, 10, 2)), low=2, high=3), SETTINGS)
    assert any(text.endswith("to print from 2.00 to 3.00 mm") for text in top.warnings)
    with pytest.raises(MeshError, match=r"from 0\.00 to 1\.00 mm"):
        generate(with_a_sail(box((0, 0, 1), (10, 10, 2)), low=0, high=1), SETTINGS)


def test_stretches_of_heights():
    stack = layer_stack(10, SETTINGS)
    assert heights(np.array([0, 1, 4, 5, 6, 9]), stack) == (
        "from 0.00 to 0.50 and from 1.00 to 1.75 and from 2.25 to 2.50 mm"
    )
    assert heights(np.arange(0, 20, 2), stack) == "from 0.00 to 4.75 mm"


def test_duplicate_and_zero_area_faces_change_nothing():
    plain = box((0, 0, 0), (20, 20, 5))
    corners = plain.corner_vertex.reshape(-1, 3)
    worse = surface(plain.vertices, np.concatenate([corners, [[0, 0, 1], [0, 1, 1]], corners[:6], corners[:6, ::-1]]))
    _, cut = sliced(worse)
    np.testing.assert_allclose([region.area for region in cut.regions], 400, rtol=1e-6)


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (1e-3, "meters"),
        (1 / 25.4, "inches"),
        (1e-6, "kilometers"),
        (1e3, "scaled by 0.001 it would be 20 mm long"),
        (1e36, "unit"),
        (np.nan, "finite"),
    ],
)
def test_absurd_scales_are_refused_with_a_hint_at_the_unit(factor, said):
    model = box((0, 0, 0), (20, 20, 10))
    with pytest.raises(MeshError, match=said) as refused:
        generate(replace(model, vertices=model.vertices * factor), SETTINGS)
    assert "\n" not in str(refused.value)


def test_outlines_smaller_than_a_strand_are_refused_with_a_hint_at_the_unit():
    with pytest.raises(MeshError, match=r"no outline .* 1\.26 mm long.* in inches it would be 30\.5 mm"):
        generate(box((0, 0, 0), (0.3, 0.3, 1.2)), SETTINGS)
    with pytest.raises(MeshError, match=r"no outline .*: scale it up"):
        generate(box((0, 0, 0), (0.3, 0.3, 7)), SETTINGS)


def test_a_small_object_is_printed_with_a_hint_at_the_unit():
    model = box((0, 0, 0), (2, 2, 1))
    with pytest.raises(MeshError, match="in inches it would be 10"):
        generate(replace(model, vertices=model.vertices * 0.2), SETTINGS)
    found = generate(model, SETTINGS)
    assert any(
        "only 2 mm long; check its scale and unit: in inches it would be 50.8 mm" in text for text in found.warnings
    )


@pytest.mark.parametrize(
    "name",
    ["box.STL", "cube_with_fold.ply", "degenerated.obj", "empty.stl", "kleinBottle.obj", "nancolor.obj", "soup.stl",
     "sphereWithHole.stl", "teapot.obj", "two-boxes-bad-self-union.ply", "not_convex.obj"],
)  # fmt: skip
def test_nasty_files(data, name):
    pytest.importorskip("bpy")
    from benchmarks.robustness import is_kind, printed

    said, result = printed(data / "nasty" / name, 10.0)
    if result is None:
        assert "\n" not in said["refused"] and len(said["refused"]) < 300
    else:
        found = agreement(result.mesh, result.slices, 2000)
        assert is_kind({"points": vars(found)})
        assert len(result.slices.open_layers) == 0 or any("do not close" in text for text in result.warnings)


def test_shells_that_cross_and_lie_on_one_another_are_united(data):
    pytest.importorskip("bpy")
    from benchmarks.robustness import printed

    _, result = printed(data / "nasty" / "openscad-nonmanifold-crash.obj", 20.0)
    assert agreement(result.mesh, result.slices, 4000).disagreements == 0


@pytest.mark.parametrize("most", [1, 500, 3000])
def test_bands_of_layers_give_the_same_outlines(most):
    from dataclasses import fields

    from dualcolor.core.slicing.bands import linked_outlines

    model = joined(cylinder(8, 10), box((0, 0, 2), (12, 9, 7)), flipped(box((20, 0, 0), (30, 9, 9)), [3]))
    model = replace(model, corner_vertex=model.corner_vertex[:-9], polygon_start=model.polygon_start[:-3],
                    polygon_texture=model.polygon_texture[:-3])  # fmt: skip
    mesh = triangulate(model, SETTINGS)
    planes = np.arange(0.1, 9.9, 0.2)
    whole, left_open = linked_outlines(mesh, planes, 0.05)
    banded, open_too = linked_outlines(mesh, planes, 0.05, most)
    assert len(left_open) and np.array_equal(left_open, open_too)
    for column in fields(whole):
        np.testing.assert_array_equal(getattr(whole, column.name), getattr(banded, column.name))

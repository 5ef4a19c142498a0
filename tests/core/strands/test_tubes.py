"""The mesh of the predicted print: closed tubes, outward normals, the extruded volume."""

import itertools

import numpy as np
import pytest
from dualcolor.core.errors import OutputError, PrintError
from dualcolor.core.strands.mesh_files import write_mesh
from dualcolor.core.strands.settling import settled
from dualcolor.core.strands.strands import Strands
from dualcolor.core.strands.tubes import SIDES, Rods, count, tubes
from dualcolor.tests.strand_volume import volume_mm3


def rods(*lines, across=0.2, up=0.1) -> Rods:
    points = np.concatenate([np.array(line, dtype=float) for line in lines])
    start = np.concatenate([[0], np.cumsum([len(line) for line in lines])])
    return Rods(points, start, np.full(len(points), across), np.full(len(points), up))


def waved():
    """Two layers of strands, the upper one bridging a gap."""
    x = np.linspace(0, 12, 120)
    lower = np.column_stack([x, np.sin(3 * x), np.full(120, 0.1)])
    upper = np.column_stack([x, np.full(120, 3.0), np.full(120, 0.3)])
    points = np.concatenate([lower, upper])
    label = np.array([0, 1])
    none = np.zeros(240)
    laid = Strands(
        points,
        np.array([0, 120, 240]),
        label,
        label + 2,
        label,
        none + 0.4,
        np.full(2, 0.2),
        none,
        none,
        np.arange(240),
    )
    return Rods.of(settled(laid, 0.3)), volume_mm3(laid).sum()


def volume(vertices, triangles):
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def assert_closed(triangles):
    """Every edge is used once in each direction."""
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    forth = np.unique(edges, axis=0)
    assert len(forth) == len(edges)
    assert np.array_equal(forth, np.unique(edges[:, ::-1], axis=0))


def test_a_straight_rod_is_a_prism_of_the_area_of_the_oval():
    (part,) = tubes(rods([(0, 0, 1), (5, 0, 1)]))
    triangles = part.triangles()
    assert_closed(triangles)
    assert len(triangles) == 2 * SIDES + 2 * (SIDES - 2)
    assert volume(part.vertices, triangles) == pytest.approx(np.pi * 0.2 * 0.1 * 5)
    assert np.ptp(part.vertices[:, 0]) == pytest.approx(5)
    assert part.vertices.mean(axis=0) == pytest.approx([2.5, 0, 1])


def test_normals_point_outwards():
    (part,) = tubes(rods([(0, 0, 0), (2, 1, 0), (3, 3, 0.2)]))
    triangles = part.triangles()
    a, b, c = (part.vertices[triangles[:, corner]] for corner in range(3))
    sides = slice(0, 2 * len(part.quads))
    normal, middle = np.cross(b - a, c - a)[sides], ((a + b + c) / 3)[sides]
    axis = np.array([(0, 0, 0), (2, 1, 0), (3, 3, 0.2)], dtype=float)
    dense = np.concatenate([np.linspace(p, q, 50) for p, q in itertools.pairwise(axis)])
    nearest = dense[np.argmin(np.linalg.norm(middle[:, None] - dense, axis=2), axis=1)]
    assert (np.einsum("ij,ij->i", normal, middle - nearest) > 0).all()


@pytest.mark.parametrize("degrees", [10, 60, 90, 119])
def test_mitred_corners_keep_the_volume(degrees):
    turn = np.radians(degrees)
    (part,) = tubes(rods([(0, 0, 0), (4, 0, 0), (4 + 3 * np.cos(turn), 3 * np.sin(turn), 0)]))
    assert len(part.caps) == 2
    assert volume(part.vertices, part.triangles()) == pytest.approx(np.pi * 0.02 * 7)


def test_a_turn_back_is_cut_in_two_tubes():
    back = rods([(0, 0, 0), (4, 0, 0), (0.5, 0.2, 0)], [(0, 9, 0), (1, 9, 0)])
    (part,) = tubes(back)
    assert count(back) == (6, 3) and len(part.caps) == 6
    assert_closed(part.triangles())
    length = 4 + np.hypot(3.5, 0.2) + 1
    assert volume(part.vertices, part.triangles()) == pytest.approx(np.pi * 0.02 * length)


def test_settled_strands_have_the_extruded_volume():
    shape, extruded = waved()
    parts = list(tubes(shape))
    assert sum(volume(part.vertices, part.triangles()) for part in parts) == pytest.approx(extruded, rel=0.01)


def test_both_kinds_of_file_hold_the_same_mesh(tmp_path):
    shape, _ = waved()
    (part,) = tubes(shape)
    assert write_mesh(tmp_path / "a.stl", shape) == 2
    write_mesh(tmp_path / "a.obj", shape)
    data = (tmp_path / "a.stl").read_bytes()
    found = np.frombuffer(data, dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("x", "<u2")], offset=84)
    assert int.from_bytes(data[80:84], "little") == len(found) == len(part.triangles())
    np.testing.assert_allclose(found["c"], part.vertices[part.triangles()], atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(found["n"], axis=1), 1.0, atol=1e-5)
    rows = [line.split() for line in (tmp_path / "a.obj").read_text().splitlines()]
    vertices = np.array([row[1:] for row in rows if row[0] == "v"], dtype=float)
    np.testing.assert_allclose(vertices, part.vertices, atol=1e-5)
    faces = [[int(corner) - 1 for corner in row[1:]] for row in rows if row[0] == "f"]
    assert faces == [*part.quads.tolist(), *part.caps.tolist()]


def test_large_numbers_of_vertices_are_written_whole():
    from dualcolor.core.strands import mesh_files

    numbers = np.array([[1, 9_999, 10_000, 10_203, 1_234_567, 100_000_000, 120_030_004, 100_010_000]])
    assert mesh_files._text(mesh_files._face_words(numbers)).decode().split()[1:] == [str(n) for n in numbers[0]]


def test_what_cannot_be_written(tmp_path):
    with pytest.raises(OutputError, match="neither"):
        write_mesh(tmp_path / "a.ply", rods([(0, 0, 0), (1, 0, 0)]))
    with pytest.raises(PrintError, match="no strands"):
        write_mesh(tmp_path / "a.stl", Rods(np.zeros((0, 3)), np.zeros(1, dtype=np.int64), np.zeros(0), np.zeros(0)))
    with pytest.raises(OutputError, match="cannot be written"):
        write_mesh(tmp_path / "missing" / "a.stl", rods([(0, 0, 0), (1, 0, 0)]))

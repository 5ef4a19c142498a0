"""How cuts of faces become outlines: linked, put into cycles, wound, united, known again."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.ragged import starts
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.cycles import cycles
from dualcolor.core.slicing.edges import LEADS_UP, faces_beyond
from dualcolor.core.slicing.intersect import intersect
from dualcolor.core.slicing.link import link
from dualcolor.core.slicing.outlines import Outlines
from dualcolor.core.slicing.planes import layer_stack, levels
from dualcolor.core.slicing.union import equal_segments, united, winding_number
from dualcolor.tests.solids import box, cylinder, joined, lathe

KEEP = PrintSettings(center_on_bed=False)


def test_reversing_a_loop_keeps_each_segment_with_its_own_values():
    points = np.array([[0.0, 0], [4, 0], [4, 3], [0, 3]])
    carried = np.zeros((4, 2, 3))
    carried[:, :, 0] = [[0, 1], [1, 2], [2, 3], [3, 0]]
    lines = Outlines(points, np.array([0, 4]), np.array([0]), np.array([10, 11, 12, 13]), carried)
    back = lines.reversed(np.array([True]))
    assert back.signed_area == pytest.approx(-lines.signed_area)
    for face in (10, 11, 12, 13):
        new, old = np.flatnonzero(back.face == face)[0], np.flatnonzero(lines.face == face)[0]
        assert back.points[new] == pytest.approx(lines.ends[old])
        assert back.ends[new] == pytest.approx(lines.points[old])
        assert back.carried[new, 0] == pytest.approx(carried[old, 1])


def test_loops_reduced_in_place_are_those_of_a_copy():
    rng = np.random.default_rng(0)
    start = starts(rng.integers(3, 9, 20_000))
    loops, points = len(start) - 1, int(start[-1])

    def outlines():
        values = np.arange(points, dtype=np.float64)
        carried = np.arange(4.0 * points).reshape(-1, 2, 2)
        return Outlines(np.stack([values, -values], axis=1), start, np.arange(loops), np.arange(points), carried)

    keep, point = rng.random(loops) < 0.9, rng.random(points) < 0.9
    point[:40_000] = keep[:6_000] = True  # nothing is left out for a while
    count = np.add.reduceat(point, start[:-1], dtype=np.int64)
    copied = outlines().reduced(keep, point, count)
    own = outlines()
    moved = own.reduced(keep, point, count, in_place=True)
    for name in ("points", "start", "layer", "face", "carried"):
        assert np.array_equal(getattr(moved, name), getattr(copied, name))
    assert np.shares_memory(moved.carried, own.carried)


def test_cycles_of_a_permutation():
    successor = np.array([3, 0, 2, 1, 5, 4])
    order, start = cycles(successor, np.array([7, 7, 3, 7, 7, 7]))
    assert order.tolist() == [2, 0, 3, 1, 4, 5]
    assert start.tolist() == [0, 1, 4, 6]


def test_cycles_of_a_long_permutation_are_those_that_steps_find():
    """Long ones, and thousands that are so short that no ruler lies on them."""
    rng = np.random.default_rng(4)
    lengths = [20_000, 300, *[3] * 2000]
    first, shuffled = starts(np.array(lengths)), rng.permutation(sum(lengths))
    successor, layer = np.empty(len(shuffled), dtype=np.int64), np.empty(len(shuffled), dtype=np.int64)
    found = []
    for number, (begin, end) in enumerate(pairwise(first)):
        cycle = np.roll(shuffled[begin:end], -np.argmin(shuffled[begin:end]))
        successor[cycle], layer[cycle] = np.roll(cycle, -1), number % 5
        found.append((number % 5, cycle[0], cycle))
    order, start = cycles(successor, layer)
    ordered = [cycle for _, _, cycle in sorted(found, key=lambda each: each[:2])]
    assert np.array_equal(order, np.concatenate(ordered))
    assert np.array_equal(np.diff(start), [len(cycle) for cycle in ordered])


def test_every_loop_is_closed_and_uses_all_segments():
    mesh = triangulate(cylinder(sides=40), KEEP)
    stack = layer_stack(10.0, KEEP)
    segments = intersect(mesh, stack.plane)
    lines, open_layers = link(segments, 0.0)
    assert len(open_layers) == 0
    assert len(lines.points) == len(segments.layer) == 40 * 2 * len(stack)
    assert (lines.count == 80).all()


def test_winding_numbers():
    square = np.array([[0.0, 0], [4, 0], [4, 4], [0, 4]])
    ends = np.roll(square, -1, axis=0)
    probe = np.array([[2.0, 2], [5, 2], [-1, 2], [2, 5]])
    assert winding_number(probe, square, ends).tolist() == [1, 0, 0, 0]
    assert winding_number(probe, ends, square).tolist() == [-1, 0, 0, 0]


def test_a_figure_of_eight_keeps_both_halves():
    points = np.array([[0.0, 0], [4, 4], [4, 0], [0, 4]])
    eight = Outlines(points, starts(np.array([4])), np.array([0]), np.zeros(4, dtype=np.int64), np.zeros((4, 2, 3)))
    assert np.abs(united(eight).signed_area).sum() == pytest.approx(8.0)


@pytest.mark.parametrize("inward", [None, False, True])
def test_each_cut_goes_on_where_it_ends_also_among_solids_that_touch(inward):
    solid = box((0, 0, 0), (10, 10, 5))
    others = [lathe([[10, 0], [6, 7], [9, 16]])] if inward is None else [box((0, 0, 0), (10, 10, 5), inward=inward)]
    cuts = intersect(triangulate(joined(solid, *others), KEEP), layer_stack(5.0, KEEP).plane)
    assert sorted(cuts.successor) == list(range(len(cuts.layer)))
    assert np.array_equal(cuts.layer[cuts.successor], cuts.layer)
    assert np.array_equal(cuts.points[cuts.successor, 0], cuts.points[:, 1])


@pytest.mark.parametrize("spacing", ["even", "thick first layer", "uneven", "few"])
def test_levels_are_those_that_a_search_finds_also_on_planes_and_beyond_them(spacing):
    rng = np.random.default_rng(6)
    planes = {
        "even": 0.1 + 0.2 * np.arange(50),
        "thick first layer": np.append(0.15, 0.4 + 0.2 * np.arange(50)),
        "uneven": np.cumsum(rng.uniform(0.01, 2.0, 50)),
        "few": np.array([0.3, 0.5]),
    }[spacing]
    heights = np.concatenate([planes, np.nextafter(planes, 0), rng.uniform(-3, planes[-1] + 3, 500), [-1e9, 1e9]])
    assert np.array_equal(levels(heights, planes), np.searchsorted(planes, heights, side="right"))


@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("edges", [0, 1, 60, 3000])
def test_the_kth_edge_that_leads_up_goes_with_the_kth_of_the_same_ends_that_leads_down(edges, closed):
    rng, slots = np.random.default_rng(5), 10000
    up, ends = rng.permutation(slots)[:edges], max(edges // 3, 1)
    key = rng.permutation(edges).astype(np.int64) if closed else rng.integers(ends, size=edges)
    down, down_key = rng.integers(slots, size=edges), key if closed else rng.integers(ends, size=edges)
    beyond = faces_beyond(np.append(key, down_key) << 40, np.append(up | LEADS_UP, down), slots)
    expected = np.full(slots, -1)
    for each in np.unique(key):
        pairs = zip(np.sort(up[key == each]), np.sort(down[down_key == each]) // 2, strict=False)
        for number, face in pairs:
            expected[number] = face
    assert np.array_equal(beyond, expected)


def test_segments_are_known_again_either_way_round_but_not_among_equal_ones():
    tails, heads = (
        np.array([[0.0, 0], [1, 0], [1, 1], [5, 5], [5, 5]]),
        np.array([[1.0, 0], [1, 1], [0, 0], [6, 5], [6, 5]]),
    )
    new_tails, new_heads = np.array([[-0.0, 0], [1, 1], [0.5, 0], [6, 5]]), np.array([[1.0, 0], [1, 0], [1, 0], [5, 5]])
    assert equal_segments(new_tails, new_heads, tails, heads).tolist() == [0, 1, -1, -1]


def test_what_united_loops_carry_is_interpolated_on_every_piece():
    """Far from the origin and askew; each corner carries where it is, and so does each end of the new segments."""
    square = np.array([[0.0, 0], [6, 1], [5, 7], [-1, 6]])
    squares = square + np.array([[[30, 12]], [[33, 14]], [[30, 18]]])
    tails = squares.reshape(-1, 2)
    corners = Outlines(tails, starts(np.full(3, 4)), np.zeros(3, dtype=np.int64), np.arange(12), np.zeros((12, 2, 2)))
    loops = replace(corners, carried=np.stack([tails, corners.ends], axis=1))
    whole = united(loops)
    assert whole.carried[:, 0] == pytest.approx(whole.points) and whole.carried[:, 1] == pytest.approx(whole.ends)
    assert whole.signed_area.sum() == pytest.approx(shapely.union_all(shapely.polygons(squares)).area)
    side, along = loops.ends[whole.face] - loops.points[whole.face], whole.ends - whole.points
    assert side[:, 0] * along[:, 1] == pytest.approx(side[:, 1] * along[:, 0])  # a piece of the side that it names

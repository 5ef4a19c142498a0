"""Where closed lines start: at the rear, above each other, beside the nozzle, in the valleys of waves."""

import numpy as np
import pytest
from dualcolor.core.paths import Feature, Paths
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.toolpaths.order import ordered
from dualcolor.core.toolpaths.seams import seam_offsets, valleys
from dualcolor.tests.solids import cylinder


def loops(*points, layer=None, feature=Feature.OUTER_WALL):
    count = np.array([len(loop) for loop in points])
    return Paths(
        points=np.concatenate([np.asarray(loop, dtype=float) for loop in points]),
        start=np.concatenate([[0], np.cumsum(count)]),
        layer=np.arange(len(points)) if layer is None else np.array(layer),
        feature=np.full(len(points), int(feature)),
        island=np.arange(len(points)),
        closed=np.ones(len(points), dtype=bool),
        width=np.full(int(count.sum()), 0.4),
    )


def wave(radius, waves, depth, points=900, phase=0.0):
    angle = np.linspace(0, 2 * np.pi, points, endpoint=False)
    way = radius + depth / 2 * np.cos(waves * angle + phase)
    return np.column_stack([way * np.cos(angle), way * np.sin(angle)])


def begun(paths, **settings):
    order = ordered(paths, PrintSettings(**settings))
    return order.points[order.start[:-1]]


@pytest.mark.parametrize("phase", [0.0, np.pi, 1.0])
@pytest.mark.parametrize("turn", [1, -1])
def test_valleys_of_a_wave(phase, turn):
    waves = 40
    loop = wave(9.6, waves, 0.5, phase=phase)[::turn]
    found = np.flatnonzero(valleys(loop, np.array([0, len(loop)]), 0.75))
    radius = np.hypot(*loop[found].T)
    assert waves <= len(found) <= 2 * waves  # two neighbors may be as deep
    # into the material: inwards for a body, outwards for a hole
    assert radius == pytest.approx(9.6 - turn * 0.25, abs=0.01)


def test_of_deep_and_shallow_valleys_only_the_deep_ones_hide_a_seam():
    angle = np.linspace(0, 2 * np.pi, 1200, endpoint=False)
    depth = np.where(angle < np.pi, 0.8, 0.2)
    way = 10 + depth / 2 * np.cos(40 * angle)
    loop = np.column_stack([way * np.cos(angle), way * np.sin(angle)])
    found = angle[valleys(loop, np.array([0, len(loop)]), 0.75)]
    assert len(found) >= 19 and (found < np.pi + 0.1).all()


@pytest.mark.parametrize("seam_position", ["rear", "nearest"])
def test_a_flat_back_has_its_seam_at_the_corner_whatever_the_tones_set_back(seam_position):
    across = np.arange(-10, 10, 0.5)
    corner = np.array([[10.0, 10.0], [-10.0, 10.0], [-10.0, -10.0], [10.0, -10.0]])
    set_back = np.random.default_rng(4).choice([0.0, 1e-9, 0.02, 0.3], size=(30, len(across)))
    backs = [np.vstack([corner[2:], np.column_stack([across, 10 - depth])]) for depth in set_back]
    paths = loops(*backs)
    seams = paths.points[paths.start[:-1] + seam_offsets(paths, PrintSettings(seam_position=seam_position))]
    assert seams[:, 0].min() > 8 and np.ptp(seams[:, 0]) < 2


def test_seam_in_the_valley_nearest_to_the_rear_then_to_the_one_below():
    waves = [wave(10, 40, 0.6, phase=phase) for phase in (0.0, 0.0, np.pi, np.pi, 0.0)]
    seams = begun(loops(*waves), seam_position="valley")
    assert np.hypot(*seams.T) == pytest.approx(9.7, abs=0.01)
    pitch = 2 * np.pi * 10 / 40
    assert np.hypot(*(seams - [2, 9.8]).T).max() < 1.5 * pitch
    assert np.hypot(*np.diff(seams, axis=0).T).max() < 0.75 * pitch
    # without it, at the rear, the seam sits on a crest or a flank
    assert np.hypot(*begun(loops(*waves), seam_position="rear").T).max() > 9.9


def test_without_a_wave_in_a_concave_corner_or_at_the_rear():
    corner = [(0, 0), (20, 0), (20, 20), (12, 20), (12, 8), (8, 8), (8, 20), (0, 20)]
    seams = begun(loops(corner), seam_position="valley")
    assert seams[0].tolist() in ([12, 8], [8, 8])
    square = [(0, 0), (20, 0), (21, 21), (0, 20)]
    assert begun(loops(square), seam_position="valley")[0].tolist() == [21, 21]


def test_nearest_to_the_nozzle():
    ring = wave(10, 0, 0.0, points=360)
    # the first one is not around the place from which the nozzle comes, of which all its points would be as near
    far = loops(ring - np.array([1, 0]), ring + np.array([40, 0]), ring + np.array([40, 40]), layer=[0, 0, 0])
    order = ordered(far, PrintSettings(seam_position="nearest"))
    begin, end = order.points[order.start[:-1]], order.points[order.start[1:] - 1]
    assert begin == pytest.approx(end)
    place = np.zeros(2)
    for loop, seam in enumerate(begin):
        mine = order.points[order.start[loop] : order.start[loop + 1]]
        assert np.hypot(*(seam - place).T) == pytest.approx(np.hypot(*(mine - place).T).min())
        place = seam
    assert begin[1] == pytest.approx([30, 0], abs=0.2)  # across from the first one


def test_of_a_whole_print():
    settings = PrintSettings(pattern="wave", skirts=0, calibration="none")
    can = cylinder(radius=12, height=2)
    radii = {}
    for place in ("rear", "valley", "nearest"):
        moves = generate(can, settings.changed({"seam_position": place})).moves
        wall = moves.feature == Feature.OUTER_WALL
        first = np.flatnonzero(wall & ~np.roll(wall, 1)) - 1
        radii[place] = np.hypot(*moves.position[first, :2].T)
    # the line lies at 11.8 mm, its waves are 0.75 mm deep
    assert radii["valley"] == pytest.approx(11.8 - 0.375, abs=0.03)
    assert radii["rear"].max() > 11.8
    assert len(radii["nearest"]) == len(radii["valley"])

"""The raft: below the object, in one color, covering what it holds; the object above it unchanged."""

import numpy as np
import pytest
import shapely
from dualcolor.core.exports import dump, export_gcode
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.toolpaths.raft import raft_area, raft_paths
from dualcolor.tests.gpx import convert
from dualcolor.tests.solids import cylinder

PLAIN = PrintSettings(skirt_distance=2.0)
RAFTED = PLAIN.changed({"raft_layers": 3, "raft_margin": 3.0, "raft_gap": 0.2, "first_layer_height": 0.3})


def strands(moves, chosen):
    rows = np.flatnonzero(moves.extrudes & chosen)
    return shapely.linestrings(np.stack([moves.position[rows - 1, :2], moves.position[rows, :2]], axis=1)), rows


def test_lines_apart_below_and_side_by_side_above():
    area = raft_area(shapely.box(-10, -10, 10, 10), RAFTED)
    assert shapely.hausdorff_distance(area, shapely.box(-13, -13, 13, 13)) < 2
    paths = raft_paths(area, RAFTED)
    assert (paths.feature == Feature.RAFT).all() and np.unique(paths.layer).tolist() == [0, 1, 2]
    covered = []
    for layer in range(3):
        lines = [
            shapely.LineString(paths.points[paths.start[k] : paths.start[k + 1]]).buffer(0.2)
            for k in np.flatnonzero(paths.layer == layer)
        ]
        laid = shapely.union_all(lines)
        assert area.buffer(0.01).covers(laid)
        covered.append(laid.area / area.area)
    assert 0.45 < covered[0] < 0.65
    assert min(covered[1:]) > 0.95
    step = np.abs(np.diff(paths.points, axis=0))
    along_x = [step[paths.start[k] : paths.start[k + 1] - 1].sum(axis=0) @ [1, -1] > 0 for k in range(len(paths.layer))]
    assert along_x == [layer % 2 == 0 for layer in paths.layer]  # each layer across the one below
    assert not len(raft_paths(area, PLAIN).layer)


@pytest.mark.parametrize("shield", [False, True])
def test_the_object_stands_on_it_as_it_stood_on_the_bed(shield, tmp_path):
    model = cylinder(radius=8, height=3)
    flat = generate(model, PLAIN.changed({"first_layer_height": 0.3, "ooze_shield": shield}))
    high = generate(model, RAFTED.changed({"ooze_shield": shield}))
    for feature in (Feature.OUTER_WALL, Feature.INNER_WALL, Feature.SKIN):
        low, up = (np.flatnonzero(r.moves.extrudes & (r.moves.feature == feature)) for r in (flat, high))
        assert len(low) == len(up)
        assert np.sort(high.moves.position[up, 2]) == pytest.approx(np.sort(flat.moves.position[low, 2]) + 1.0)
        assert high.moves.filament[up].sum() == pytest.approx(flat.moves.filament[low].sum(), rel=1e-6)
    assert high.report["tool_changes"] == high.report["layers"] - 1 == flat.report["layers"] - 1
    moves = high.moves
    wall = moves.feature == Feature.OUTER_WALL
    assert (moves.tool[wall & moves.extrudes] == (moves.layer[wall & moves.extrudes] - 3) % 2).all()
    # Raft and tower stand on the bed, and the tower is on every layer.
    laid = moves.extrudes
    for feature in (Feature.RAFT, Feature.TOWER):
        assert moves.position[laid & (moves.feature == feature), 2].min() == pytest.approx(0.3)
    assert len(np.unique(moves.layer[laid & (moves.feature == Feature.TOWER)])) == high.report["layers"] + 3
    # The object's first layer lies on the raft, and the tower keeps clear of it.
    first, _ = strands(moves, wall & (moves.layer == 3))
    raft = shapely.union_all(shapely.buffer(strands(moves, moves.feature == Feature.RAFT)[0], 0.25))
    assert shapely.covers(raft, first).all()
    tower = shapely.union_all(strands(moves, moves.feature == Feature.TOWER)[0])
    assert tower.distance(raft) > RAFTED.tower_distance - 0.3
    if shield:
        wall_around = shapely.union_all(strands(moves, moves.feature == Feature.OOZE_SHIELD)[0])
        assert wall_around.distance(raft) > 1.5
    export_gcode(high, tmp_path / "raft.gcode")
    assert convert(tmp_path / "raft.gcode") == []


def test_what_stands_on_the_bed_goes_on_through_the_air_above_the_raft():
    """Each line of the tower and the shield is as high as the nozzle has risen, or they break there."""
    moves = generate(cylinder(radius=8, height=3), RAFTED.changed({"ooze_shield": True, "infill_speed": 300.0})).moves
    laid = moves.extrudes
    length = np.linalg.norm(np.diff(moves.position, axis=0, prepend=moves.position[:1]), axis=1)
    section = moves.filament * np.pi / 4 * RAFTED.filament_diameter_0**2 / np.maximum(length, 1e-9)
    for feature in (Feature.TOWER, Feature.OOZE_SHIELD):
        rows = np.flatnonzero(laid & (moves.feature == feature))
        levels, which = np.unique(moves.position[rows, 2], return_inverse=True)
        rise = np.diff(levels, prepend=0.0)[which]
        assert rise.max() == pytest.approx(RAFTED.first_layer_height + RAFTED.raft_gap)
        assert moves.height[rows] == pytest.approx(rise)
        assert section[rows] == pytest.approx(moves.width[rows] * rise)
    assert (section * moves.speed)[laid].max() <= RAFTED.max_volumetric_speed * 1.001
    wall = laid & np.isin(moves.feature, (Feature.OUTER_WALL, Feature.INNER_WALL))  # the object is to come off
    assert moves.height[wall & (moves.layer == 3)] == pytest.approx(RAFTED.first_layer_height)


def test_report_file_and_dump_count_layers_alike(tmp_path):
    settings = PrintSettings(raft_layers=3, tower_type="none")
    done = export_gcode(generate(cylinder(radius=8, height=2), settings), tmp_path / "can.gcode")
    report, moves = done.report, done.moves
    assert (report["layers"], report["raft_layers"], report["tool_changes"]) == (8, 3, 7)
    lines = (tmp_path / "can.gcode").read_text().splitlines()
    assert [line for line in lines if line.startswith("; layer ")] == [f"; layer {layer}" for layer in range(8 + 3)]
    changes = [place for place, line in enumerate(lines) if line.startswith("M135")]
    begin = lines.index("; layer 3")  # the object's first layer, in the color of the raft
    assert len([place for place in changes if place > lines.index("; layer 0")]) == 7
    assert min(place for place in changes if place > lines.index("; layer 0")) > begin
    dump(done, tmp_path / "can.npz")
    dumped = np.load(tmp_path / "can.npz")
    wall = moves.feature == Feature.OUTER_WALL
    assert dumped["layer_z"].tolist() == np.unique(moves.position[wall, 2]).tolist()
    assert dumped["layer_z"][0] == pytest.approx(3 * 0.25 + settings.raft_gap + 0.25)
    assert np.unique(dumped["loop_layer"]).tolist() == list(range(8))

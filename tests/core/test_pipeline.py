"""The whole job on small solids, and on real models: order, tools, amounts, report, files."""

import json
import threading

import numpy as np
import pytest
from dualcolor.core.calibration.tile import profile_tile
from dualcolor.core.errors import MeshError, OutputError
from dualcolor.core.exports import dump, export_gcode, export_x3g
from dualcolor.core.paths import Feature, Paths
from dualcolor.core.pipeline import generate, steps
from dualcolor.core.settings import PrintSettings
from dualcolor.core.toolpaths.order import ordered
from dualcolor.core.toolpaths.seams import seam_offsets
from dualcolor.core.toolpaths.tool_turns import tool_of_layer
from dualcolor.core.x3g.audit import audit
from dualcolor.core.x3g.reader import read_x3g
from dualcolor.tests.gpx import convert
from dualcolor.tests.real_models import image_file, obj_model
from dualcolor.tests.solids import box, cylinder, joined, lathe, picture

SMALL = PrintSettings(skirt_distance=2.0, calibration="none")
GRADIENT = picture(np.tile(np.linspace(0, 1, 64)[:, None], (1, 8)))


@pytest.fixture(scope="module")
def vase():
    return generate(lathe([[8, 0], [10, 6], [7, 12]], textures=[GRADIENT]), SMALL)


def paths(*lines, feature=Feature.INNER_WALL, closed=True, layer=0, island=0):
    count = np.array([len(line) for line in lines])
    return Paths(
        points=np.concatenate([np.asarray(line, dtype=float) for line in lines]),
        start=np.concatenate([[0], np.cumsum(count)]),
        layer=np.full(len(lines), layer),
        feature=np.full(len(lines), int(feature)),
        island=np.full(len(lines), island),
        closed=np.full(len(lines), closed),
        width=np.full(count.sum(), 0.4),
    )


# Order


def test_open_paths_are_chained_nearest_first_from_either_end():
    lines = [[[0, 0], [10, 0]], [[0, 5], [10, 5]], [[0, 1], [10, 1]]]
    order = ordered(paths(*lines, feature=Feature.INFILL, closed=False), PrintSettings())
    assert order.points.tolist() == [[0, 0], [10, 0], [10, 1], [0, 1], [0, 5], [10, 5]]


def test_a_line_printed_backwards_keeps_its_widths():
    line = paths([[9, 9], [5, 5], [1, 1]], feature=Feature.INFILL, closed=False)
    line.width[:] = [0.1, 0.2, 0.3]
    order = ordered(line, PrintSettings())
    assert order.points[0].tolist() == [1, 1]
    assert order.width[:2].tolist() == [0.2, 0.1]


def test_walls_come_before_fill_and_tower_and_skirt_first():
    square = np.array([[0, 0], [10, 0], [10, 10], [0, 10]])
    table = Paths.joined(
        [
            paths(square + 1, feature=Feature.SKIN, closed=False),
            paths(square, feature=Feature.OUTER_WALL),
            paths(square + 0.5, feature=Feature.INNER_WALL),
            paths(square + 40, feature=Feature.TOWER, island=-1),
            paths(square - 40, feature=Feature.SKIRT, island=-2),
        ]
    )
    inner_first = ordered(table, PrintSettings()).feature.tolist()
    outer_first = ordered(table, PrintSettings(outer_wall_first=True)).feature.tolist()
    start = [Feature.SKIRT, Feature.TOWER]
    assert inner_first == [*start, Feature.INNER_WALL, Feature.OUTER_WALL, Feature.SKIN]
    assert outer_first == [*start, Feature.OUTER_WALL, Feature.INNER_WALL, Feature.SKIN]


def test_closed_paths_return_to_their_seam():
    ring = [[0, 0], [10, 0], [10, 10], [0, 9]]
    order = ordered(paths(ring), PrintSettings(seam_position="rear"))
    assert order.points.tolist() == [[10, 10], [0, 9], [0, 0], [10, 0], [10, 10]]


def test_aligned_seams_stay_above_each_other():
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    rings = [paths(5 * np.column_stack([np.cos(turn + k), np.sin(turn + k)]), layer=k) for k in range(20)]
    table = Paths.joined(rings)
    offset = seam_offsets(table, PrintSettings(seam_position="aligned"))
    seam = table.points[table.start[:-1] + offset]
    assert np.hypot(*np.diff(seam, axis=0).T).max() < 5 * 2 * np.pi / 60


# The whole job


def test_one_tool_a_layer_and_one_change_between_layers(vase):
    layers = vase.report["layers"]
    assert layers == 48
    assert vase.report["tool_changes"] == layers - 1
    laid = vase.moves.extrudes
    assert (vase.moves.tool[laid] == tool_of_layer(vase.moves.layer[laid], SMALL)).all()
    assert (np.diff(vase.moves.layer) >= 0).all()


def test_outlines_are_single_spans_as_in_one_color(vase):
    assert vase.report["outline_spans"] == vase.report["layers"]


def test_every_tool_change_is_followed_by_a_travel_and_a_prime(vase):
    moves = vase.moves
    change = np.flatnonzero(np.diff(moves.tool)) + 1
    assert (moves.feature[change] == Feature.TRAVEL).all()
    assert (moves.filament[change] == 0).all()
    assert (moves.filament[change - 2] == -SMALL.retract_length_toolchange).all()
    assert (moves.filament[change + 2] == SMALL.retract_length_toolchange).all()
    assert (moves.feature[change + 3] == Feature.TOWER).all()
    assert (moves.position[change, 2] > moves.position[change + 1, 2]).all()


def test_amount_of_filament_is_the_volume_of_the_lines(vase):
    moves = vase.moves
    laid = np.flatnonzero(moves.extrudes)
    length = np.linalg.norm(moves.position[laid] - moves.position[laid - 1], axis=1)
    volume = length * moves.width[laid] * moves.height[laid]
    assert moves.filament[laid] * np.pi / 4 * 1.75**2 == pytest.approx(volume, rel=1e-6, abs=1e-8)
    assert (moves.position[laid, 2] == moves.position[laid - 1, 2]).all()


def test_travels_longer_than_the_limit_are_retracted():
    settings = SMALL.changed({"only_retract_when_crossing_perimeters": False, "avoid_crossing_perimeters": False})
    result = generate(joined(cylinder(radius=5, height=1), cylinder(radius=5, height=1, x=20)), settings)
    moves = result.moves
    travels = np.flatnonzero((moves.feature == Feature.TRAVEL) & (np.diff(moves.tool, prepend=0) == 0))[1:]
    length = np.linalg.norm(moves.position[travels, :2] - moves.position[travels - 1, :2], axis=1)
    far = travels[length > SMALL.retract_before_travel]
    assert len(far) >= 4
    assert (moves.feature[far - 1] == Feature.RETRACT).all() | (moves.layer[far] != moves.layer[far - 2]).all()
    balance = np.cumsum(np.where(moves.feature == Feature.RETRACT, moves.filament, 0.0))
    assert balance.max() < SMALL.retract_length_toolchange + 1e-9


def test_the_texture_reaches_the_wall(vase):
    """The gradient is black at the bottom and white at the top: the attenuated color changes in the middle."""
    lines = vase.outlines
    loop = np.repeat(np.arange(len(lines.layer)), np.diff(lines.start))
    back = np.array([lines.set_back[loop == k].mean() for k in range(len(lines.layer))])
    black, white = back[0::2], back[1::2]
    assert (white[:8] > 0.1).all()
    assert (black[:11] < 0.01).all()
    assert (black[-8:] > 0.1).all()
    assert (white[-11:] < 0.01).all()
    assert np.corrcoef(lines.tone, lines.uv[:, 1])[0, 1] > 0.999


def test_color_attribute_and_background_give_the_tone():
    gray = generate(cylinder(radius=6, height=1, tone=0.2), SMALL)
    assert gray.outlines.tone == pytest.approx(0.2)
    bare = generate(cylinder(radius=6, height=1), PrintSettings(background_tone=0.7, skirt_distance=2.0))
    assert bare.outlines.tone == pytest.approx(0.7)
    assert any("no texture" in warning for warning in bare.warnings)


def test_nothing_is_printed_twice_and_inner_wall_leaves_no_gap():
    """The strip between the waved outline's valleys and the first inner wall is one line wide, set-back included."""
    result = generate(cylinder(radius=12, height=3, tone=1.0), SMALL)
    moves = result.moves
    radius = np.hypot(moves.position[:, 0], moves.position[:, 1])
    for layer in range(4, 8):
        wall = (moves.layer == layer) & (moves.feature == Feature.OUTER_WALL)
        inner = (moves.layer == layer) & (moves.feature == Feature.INNER_WALL)
        assert radius[wall].min() - radius[inner].mean() == pytest.approx(SMALL.extrusion_width, abs=0.06)


def test_black_may_be_in_either_tool():
    swapped = generate(cylinder(radius=6, height=1), PrintSettings(black_tool=1, skirt_distance=2.0))
    assert swapped.moves.tool[0] == 1


@pytest.mark.parametrize("pattern", ["wave", "wave_offset", "offset"])
def test_same_input_same_bytes(pattern, tmp_path):
    """Whether the text is begun beside the findings or after them."""
    chosen = PrintSettings(pattern=pattern, skirt_distance=2.0)
    texts = []
    for name, begins in (("a", False), ("b", True)):
        made = generate(cylinder(radius=6, height=2, textures=[GRADIENT]), chosen, begin_gcode=begins)
        assert (made.begun is not None) == begins
        export_gcode(made, tmp_path / name)
        texts.append((tmp_path / name).read_bytes())
    assert texts[0] == texts[1]


def test_tones_are_averaged_along_the_wall_as_far_as_the_pattern_needs():
    """An edge in the picture takes a whole wave where waves alone show it, half of one where lines are set back too."""
    edge = profile_tile(0.0, 0.25, np.repeat([0.0, 1.0], 100), 20.0).model
    width = {}
    for pattern in ("wave", "wave_offset", "offset"):
        made = generate(edge, SMALL.changed({"pattern": pattern, "skirts": 0, "tower_type": "none"})).outlines
        front = (made.base[:, 1] < made.base[:, 1].min() + 0.1) & (np.abs(made.base[:, 0]) < 5.0)
        between = front & (made.tone > 0.1) & (made.tone < 0.9)
        width[pattern] = float(np.ptp(made.base[between, 0]))
    assert 0.9 < width["wave"] < 1.6
    assert width["offset"] + 0.1 < width["wave_offset"] < width["wave"] - 0.2


def test_report_is_json_and_complete(vase, tmp_path):
    report = export_gcode(vase, tmp_path / "vase.gcode").report
    text = json.loads(json.dumps(report))
    for key in ("layers", "tool_changes", "bounds_mm", "settings", "pattern", "stages_s", "total_s", "peak_rss_mb"):
        assert key in text
    assert {"total", "tool_change", "tower", "features", "heating", "single_color", "ratio"} <= set(text["time_s"])
    assert {"tool0_mm", "tool1_mm", "tool0_g", "tool1_g", "cost"} <= set(text["filament"])
    assert {"samples", "error_free", "imperceptible", "salient", "discarded", "histogram"} <= set(text["pattern"])
    assert {"painted_contrast", "contrast_degraded", "contrast_gone"} <= set(text["slopes"])
    written = (tmp_path / "vase.gcode").read_bytes()
    assert text["gcode"] == {"bytes": len(written), "moves": written.count(b"\nG1 ")}
    assert text["bounds_mm"][0][2] == 0.0
    assert text["total_s"] == pytest.approx(sum(text["stages_s"].values()))
    assert vase.report["gcode"]["bytes"] == 0


def test_dump_holds_what_independent_checks_need(vase, tmp_path):
    dump(vase, tmp_path / "vase.npz")
    with np.load(tmp_path / "vase.npz") as arrays:
        points = arrays["loop_start"][-1]
        assert set(arrays) == {
            *("layer_z", "loop_layer", "loop_start", "base_xy", "wave_xy", "phase", "depth", "tone", "uv")
        }
        for name in ("base_xy", "wave_xy", "phase", "depth", "tone", "uv"):
            assert len(arrays[name]) == points
        assert len(arrays["layer_z"]) == vase.report["layers"]


def test_progress_rises_and_names_the_stages():
    seen = []
    generate(cylinder(radius=6, height=1), SMALL, lambda done, stage: seen.append((done, stage)))
    done = [share for share, _ in seen]
    assert done == sorted(done)
    assert {"slicing", "sampling", "modulation", "fill", "toolpaths"} <= {stage for _, stage in seen}


def test_a_job_can_be_dropped_half_way():
    job = steps(cylinder(radius=6, height=1), SMALL)
    before = threading.active_count()
    for _ in range(4):
        next(job)
    assert threading.active_count() > before  # the textures are prepared beside the slicing
    job.close()
    assert threading.active_count() == before
    with pytest.raises(StopIteration):
        next(job)


def test_an_object_that_leaves_no_room_is_refused():
    with pytest.raises(MeshError, match=r"bed|reach|room"):
        generate(box((-103, -71, 0), (103, 71, 2)), PrintSettings())


def test_an_unwritable_path_leaves_nothing(vase, tmp_path):
    with pytest.raises(OutputError):
        export_gcode(vase, tmp_path / "no such folder" / "vase.gcode")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("name", "height"), [("spot/spot.obj", 60), ("bob/bob_tri.obj", 40)])
def test_real_models_convert_without_a_diagnostic(data, name, height, tmp_path):
    """Spot and bob with their own pictures through to a file that GPX accepts."""
    texture = next((data / "meshes" / name).parent.glob("*.png"))
    result = generate(obj_model(data / "meshes" / name, height, [image_file(texture)]), PrintSettings(pattern="wave"))
    export_gcode(result, tmp_path / "out.gcode")
    assert result.report["tool_changes"] == result.report["layers"] - 1
    assert np.ptp(result.outlines.tone) > 0.5
    assert convert(tmp_path / "out.gcode") == []


def test_x3g_holds_the_print_and_is_reported(vase, tmp_path):
    report = export_x3g(vase, tmp_path / "vase.x3g").report
    commands = read_x3g((tmp_path / "vase.x3g").read_bytes())
    assert report["x3g"]["bytes"] == (tmp_path / "vase.x3g").stat().st_size
    assert (commands.code == 134).sum() >= vase.report["tool_changes"]
    assert audit(commands, PrintSettings().printer_profile) == []


def test_what_is_too_small_to_print_is_told_with_a_remedy():
    job = generate(joined(box((0, 0, 0), (10, 10, 4)), box((4, 4, 4), (4.2, 4.2, 6))), PrintSettings())
    (told,) = [text for text in job.warnings if "smaller than a strand" in text]
    assert "8 in all layers" in told and "scale" in told and "extrusion_width" in told


@pytest.mark.parametrize("raft", [0, 2])
def test_nothing_is_printed_beside_a_tip_that_is_too_thin_to_print(raft):
    needle = joined(box((0, 0, 0), (10, 10, 4)), box((4, 4, 4), (4.2, 4.2, 9)))
    settings = PrintSettings(raft_layers=raft, ooze_shield=True)
    moves = generate(needle, settings).moves
    assert moves.layer[moves.feature == Feature.TOWER].max() == moves.layer.max() == 15 + raft
    assert moves.position[moves.extrudes, 2].max() == pytest.approx(4.0 + (raft > 0) * (raft * 0.25 + 0.2))

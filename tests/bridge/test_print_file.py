"""The preview made from a file is the one made from the scene."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor import cli  # noqa: E402
from dualcolor.bridge.strands.preview import build_preview, preview_of  # noqa: E402
from dualcolor.bridge.strands.print_file import read_print, show_file  # noqa: E402
from dualcolor.bridge.strands.strand_curves import read_strands  # noqa: E402
from dualcolor.bridge.units import use_millimeters  # noqa: E402
from dualcolor.core.errors import PrintError  # noqa: E402
from dualcolor.core.pipeline import generate  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.strands.strands import strands  # noqa: E402
from dualcolor.core.x3g.writer import x3g_bytes  # noqa: E402
from dualcolor.tests.printing import gcode_text, lengths  # noqa: E402
from dualcolor.tests.solids import box  # noqa: E402
from dualcolor.tests.strand_volume import volume_mm3  # noqa: E402


@pytest.fixture(scope="module")
def printed():
    return generate(box((0, 0, 0), (9, 8, 2)), PrintSettings(pattern="wave", calibration="none"))


@pytest.fixture
def gcode(printed, tmp_path):
    path = tmp_path / "brick.gcode"
    path.write_bytes(gcode_text(printed.moves, printed.settings, [f"object = {printed.name}"]))
    return path


def shown(collection):
    """Name → world points in mm and thickness of each object."""
    bpy.context.view_layer.update()
    found = {}
    for held in collection.objects:
        points, counts, radius, labels = read_strands(held)
        matrix = np.array(held.matrix_world)
        world = points @ matrix[:3, :3].T + matrix[:3, 3]
        found[held["dualcolor_strands"]] = (world, counts, radius, labels["layer"], labels["feature"])
    return found


def test_scene_to_gcode_to_preview(scene, printed, gcode):
    use_millimeters(scene)
    expected = shown(build_preview(printed))
    read = shown(show_file(gcode))
    assert read.keys() == expected.keys()
    # Where the roundness is just between two levels, the last digit decides in which object a piece of strand is.
    for color in ("Black", "White"):
        old, new = (
            np.concatenate([np.column_stack([held[0], np.repeat(held[3], held[1])]) for name, held in
                            found.items() if name.startswith(color)])
            for found in (expected, read)
        )  # fmt: skip
        assert len(new) == pytest.approx(len(old), rel=0.01)
        for these, those in ((old, new), (new, old)):
            away = np.array([np.abs(those - point).max(axis=1).min() for point in these])
            assert (away <= 0.002).mean() > 0.99
            assert away.max() < 0.3  # points along lines over air that only one of them needs, as at turns of the fill


def test_x3g_is_as_exact_as_its_steps(printed, tmp_path):
    path = tmp_path / "brick.x3g"
    path.write_bytes(x3g_bytes(printed.moves, printed.settings, "brick"))
    moves = read_print(path).moves
    laid = strands(moves)
    expected = strands(printed.moves)
    assert volume_mm3(laid).sum() == pytest.approx(volume_mm3(expected).sum(), rel=0.02)
    tree = {tuple(place) for place in np.rint(laid.points * 20).astype(int).tolist()}
    near = [any((x + i, y + j, z) in tree for i in (-1, 0, 1) for j in (-1, 0, 1))
            for x, y, z in np.rint(expected.points * 20).astype(int).tolist()]  # fmt: skip
    assert np.mean(near) > 0.99


def test_both_files_tell_the_same_lines(printed, gcode, tmp_path):
    path = tmp_path / "brick.x3g"
    path.write_bytes(x3g_bytes(printed.moves, printed.settings, "brick"))
    both = [read_print(file) for file in (path, gcode)]
    assert len({read.summary for read in both}) == 1
    meters = lengths(printed.moves)[printed.moves.extrudes].sum() / 1000
    assert both[0].summary == f"8 layers, {meters:.1f} m of strands"
    # Neither the lines that prime in front of the print nor short travels between two lines are taken for strands.
    laid, expected = (
        np.bincount(moves.layer[moves.extrudes], lengths(moves)[moves.extrudes])
        for moves in (both[0].moves, printed.moves)
    )
    np.testing.assert_allclose(laid, expected, rtol=0.002)


def test_the_command_makes_a_scene_from_a_file(gcode, tmp_path, capfd):
    blend = tmp_path / "out.blend"
    assert cli.main(["render", str(gcode), "--blend", str(blend)]) == 0
    assert f"wrote {blend}" in capfd.readouterr().out
    with bpy.data.libraries.load(str(blend)) as (inside, _):
        assert len(inside.hair_curves) >= 2


def test_a_file_that_is_no_print(tmp_path, capfd):
    wrong = tmp_path / "wrong.gcode"
    wrong.write_text("hello\n")
    for path in (wrong, tmp_path / "missing.gcode"):
        with pytest.raises(PrintError):
            read_print(path)
        assert cli.main(["render", str(path), "--blend", str(tmp_path / "out.blend")]) == 1
        assert len(capfd.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "out.blend").exists()


def test_the_operator(scene, gcode):
    dualcolor.register()
    try:
        assert bpy.ops.dualcolor.import_print(filepath=str(gcode)) == {"FINISHED"}
        with pytest.raises(RuntimeError, match="cannot be read"):
            bpy.ops.dualcolor.import_print(filepath=str(gcode) + "x")
    finally:
        dualcolor.unregister()
    (shown_print,) = [held for held in bpy.data.collections if held.objects]
    assert preview_of(shown_print.objects[0]) == shown_print


def test_imported_strands_are_active_and_seen_in_a_scene_of_meters(scene, gcode):
    bpy.ops.mesh.primitive_cube_add(size=2)
    cube, areas = bpy.context.object, list(bpy.context.screen.areas)
    view = next(area.spaces.active.region_3d for area in areas if area.type == "VIEW_3D")
    assert view.view_distance > 2
    dualcolor.register()
    try:
        bpy.ops.dualcolor.import_print(filepath=str(gcode))
    finally:
        dualcolor.unregister()
    (made,) = [held for held in bpy.data.collections if "Dual-Color" in held.name]
    assert bpy.context.object in set(made.objects) and not bpy.context.selected_objects  # which would hide their colors
    assert not cube.select_get() and 0.01 < view.view_distance < 0.5

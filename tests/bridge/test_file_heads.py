"""Model files that Blender's importers would crash at, or read as another shape, are refused in a sentence."""

import json
import struct

import bpy
import pytest
from dualcolor.bridge.input.file_heads import check_head
from dualcolor.bridge.input.model_file import open_model
from dualcolor.core.errors import MeshError, PrintError
from dualcolor.tests.scene import model_of, volume

HEADER = "ply\nformat {kind} 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n"
FACES = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"


def written(path, text):
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("count", ["2147483648", "99999999999", "-1", "three", ""])
@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
def test_absurd_counts(tmp_path, count, kind):
    path = written(tmp_path / "a.ply", HEADER.format(kind=kind, count=count) + FACES + "0 0 0\n")
    with pytest.raises(MeshError, match=r"a\.ply is damaged: its header cannot be read"):
        check_head(path)
    sound = HEADER.format(kind=kind, count="3") + FACES + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    check_head(written(path, sound))
    check_head(written(path, sound.replace("\n", "\r\n")))


def test_headers_without_end_and_lines_without_end(tmp_path):
    path = written(tmp_path / "a.ply", "ply\n" + "comment c\n" * 10_000)
    with pytest.raises(MeshError, match="its header cannot be read"):
        check_head(path)
    lines = HEADER.format(kind="ascii", count=3) + FACES + "0 0 0\n1 0 0\n0 1 0\n"
    with pytest.raises(MeshError, match="a line too long"):
        check_head(written(path, lines + "200 " + "0 " * 40_000 + "\n"))
    check_head(written(path, lines + "3 0 1 2" + " " * 10_000))  # the last block is shorter than a line may be
    check_head(written(path, lines.replace("ascii", "binary_little_endian") + "\0" * 100_000))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("spelled", [str.lower, str.upper, str.title])
def test_stl_in_capitals_and_with_any_line_ends(tmp_path, spelled, end):
    corners = [(0, 0, 0), (4, 0, 0), (0, 3, 0), (0, 0, 2)]
    lines = ["solid a"]
    for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        around = [f"vertex {x:e} {y:e} {z:e}" for x, y, z in (corners[corner] for corner in face)]
        lines += ["facet normal 0 0 0", "outer loop", *around, "endloop", "endfacet"]
    path = written(tmp_path / "Part.stl", end.join(map(spelled, [*lines, "endsolid a", ""])))
    obj = open_model(path)
    assert volume(model_of(obj)) == pytest.approx(4) and obj.name == "Part"
    assert [each.name for each in tmp_path.iterdir()] == ["Part.stl"]


@pytest.mark.parametrize("name", ["a.obj", "a.ply"])
def test_line_ends_of_old(tmp_path, name):
    with pytest.raises(MeshError, match="line ends that Blender cannot read: save it with those of Unix or Windows"):
        check_head(written(tmp_path / name, "ply\rv 0 0 0\rend_header\r"))


@pytest.mark.parametrize(
    ("name", "word"), [("a.obj", "v"), ("a.stl", "      vertex"), ("A.OBJ", "v "), ("a.stl", "VERTEX")]
)
def test_decimal_commas(tmp_path, name, word):
    with pytest.raises(MeshError, match="has decimal commas in its coordinates: export it with decimal points"):
        check_head(written(tmp_path / name, f"# a, b\n{word} 1.0 -2,5 0\n"))
    check_head(written(tmp_path / name, f"# v 1,2 is no vertex\no a,b 1,5\n{word} 1.0 -2.5 0\n"))


def test_the_importer_of_gltf_shows_no_traceback(tmp_path, capfd):
    text = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"children": [0]}]}
    body = json.dumps(text).encode()
    body += b" " * (-len(body) % 4)
    path = tmp_path / "own_child.glb"
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 20 + len(body)) + struct.pack("<I4s", len(body), b"JSON") + body)
    with pytest.raises(PrintError, match=r"Blender cannot read .*own_child\.glb: it is damaged"):
        open_model(path)
    assert "Traceback" not in capfd.readouterr().err
    assert not bpy.data.meshes

"""What a model file names is found beside it, and nothing else; damaged files name nothing."""

import json
import struct
from pathlib import Path

import pytest
from dualcolor.core.companions import companions


def test_materials_and_their_pictures(tmp_path):
    model = tmp_path / "cow.obj"
    model.write_text("# a cow\nmtllib two words.mtl\nv 0 0 0\nmtllib sub/a.mtl b.mtl\n")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "a.mtl").write_text("newmtl a\nKd 1 1 1\n\tmap_Kd -o 1 1 1 the skin.png\r\nbump ..\\b.png\n")
    (tmp_path / "cow.mtl").write_bytes(b"map_Ks caf\xe9.png\n")
    found = set(companions(model))
    named = ["two words.mtl", "sub/a.mtl", "b.mtl", "cow.mtl", "sub/the skin.png", "sub/../b.png", "caf\udce9.png"]
    assert {tmp_path / name for name in named} <= found
    assert model not in found


@pytest.mark.parametrize("kind", ["gltf", "glb"])
def test_buffers_and_pictures(tmp_path, kind):
    entries = {
        "buffers": [{"uri": "my%20cow.bin"}, {"byteLength": 3}, {"uri": "data:,x"}],
        "images": [{"uri": "a.png"}],
    }
    text = json.dumps(entries).encode()
    head = b"glTF" + struct.pack("<III4s", 2, 20 + len(text), len(text), b"JSON")
    model = tmp_path / f"cow.{kind}"
    model.write_bytes(text if kind == "gltf" else head + text + b"more")
    assert companions(model) == [tmp_path / "my cow.bin", tmp_path / "a.png"]


@pytest.mark.parametrize("text", [b"", b"[]", b'{"buffers": [1]}', b'{"images": [{"uri": 2}]}', b"[" * 9999, b"\xff"])
def test_damaged_files_name_nothing(tmp_path, text):
    (tmp_path / "a.gltf").write_bytes(text)
    assert companions(tmp_path / "a.gltf") == companions(tmp_path / "none.obj")[1:] == []
    claim = b"glTF" + struct.pack("<III4s", 2, 20, 0xFFFFFFFF, b"JSON")
    (tmp_path / "a.glb").write_bytes(claim + text)
    assert companions(tmp_path / "a.glb") == companions(Path("n" * 300 + ".glb")) == []


def test_no_file_names_more_than_can_be_looked_for(tmp_path):
    (tmp_path / "a.obj").write_text("mtllib " + "a " * 200_000 + "\n" + "mtllib b.mtl\n" * 200_000)
    assert len(companions(tmp_path / "a.obj")) < 5000

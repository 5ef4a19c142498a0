"""Files of others: no more is read or unpacked than such a file may hold, nothing in them is run."""

import io
import json
import pickle
import zipfile

import numpy as np
import pytest
from dualcolor.core.calibration.sweep import read_sweep
from dualcolor.core.calibration.table import read_table
from dualcolor.core.errors import CalibrationError, PrintError, SettingsError
from dualcolor.core.files import read_print_file
from dualcolor.core.settings.presets import read_preset, read_settings
from dualcolor.core.settings.printer import read_profile


def test_an_archive_that_unpacks_to_much_is_not_unpacked(tmp_path, monkeypatch):
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        head = io.BytesIO()
        np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (3_000_000,)})
        archive.writestr("tone.npy", head.getvalue() + bytes(24_000_000))
    assert path.stat().st_size < 100_000
    monkeypatch.setattr(np, "load", lambda *_args, **_more: pytest.fail("it was unpacked"))
    with pytest.raises(CalibrationError, match="holds no readings"):
        read_sweep(path)


class Harm:
    """Runs when it is unpickled."""

    def __reduce__(self):
        return pytest.fail, ("something in the file was run",)


def test_nothing_in_an_archive_is_run(tmp_path):
    held = io.BytesIO()
    np.lib.format.write_array(held, np.array([Harm()], dtype=object), allow_pickle=True)
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("about.npy", held.getvalue())
    (tmp_path / "b.npz").write_bytes(pickle.dumps(Harm()))
    for name in ("a.npz", "b.npz"):
        with pytest.raises(CalibrationError, match="holds no readings"):
            read_sweep(tmp_path / name)


@pytest.mark.parametrize("read", [read_table, read_preset, read_settings, read_profile])
@pytest.mark.parametrize("text", ["[" * 200_000, '{"a":' * 200_000, " " * 2_000_000, '{"a": ' + "9" * 900_000 + "}"])
def test_json_without_bounds(tmp_path, read, text):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(PrintError) as refused:
        read(tmp_path / "a.json")
    assert "\n" not in str(refused.value) and len(str(refused.value)) < 400


def test_a_file_without_end_is_not_read_to_its_end(tmp_path, monkeypatch):
    monkeypatch.setattr("dualcolor.core.files.MOST_PRINT_BYTES", 1_000_000)
    (tmp_path / "a.gcode").write_bytes(bytes(1_000_001))
    with pytest.raises(PrintError, match="has more than 1 MB"):
        read_print_file(tmp_path / "a.gcode")
    endless = tmp_path / "endless.gcode"
    endless.symlink_to("/dev/zero")
    for read in (read_print_file, read_settings, read_preset):
        with pytest.raises(PrintError):
            read(endless)
    with pytest.raises(SettingsError):
        read_settings(tmp_path / "a.gcode")


@pytest.mark.parametrize("text", ["[1", "[]", "7", '{"layers": 3}', "[" * 100_000, ""])
def test_what_an_object_keeps_may_be_anything(scene, text):
    """A .blend file of others, or one of another version of the program."""
    import bpy
    import dualcolor
    from dualcolor.bridge import properties
    from dualcolor.bridge.analysis import orientations, overlays
    from dualcolor.bridge.kept import kept_json

    dualcolor.register()
    bpy.ops.mesh.primitive_cube_add()
    obj = bpy.context.object
    obj.dualcolor.report = obj.dualcolor.findings = text
    obj[overlays.REPORT_KEY] = obj[orientations.ORIENTATIONS_KEY] = text
    assert properties.report_of(obj.dualcolor) == overlays.analysis_of(obj) == {}
    assert properties.findings_of(obj.dualcolor) in ({}, {"layers": 3})
    assert orientations.orientations_of(obj) == []
    obj[overlays.REPORT_KEY] = 5
    assert overlays.analysis_of(obj) == {}
    assert kept_json(json.dumps({"a": 1}), {}, ["a"]) == {"a": 1}
    dualcolor.unregister()

"""Files are written whole or not at all, one by one or several together."""

import os
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest
from dualcolor.core.errors import OutputError
from dualcolor.core.files import OutputFiles, keep_inputs, read_json, read_print_file, title, write_file


def test_new_and_replaced(tmp_path):
    path = tmp_path / "a.gcode"
    write_file(path, b"one")
    write_file(str(path), b"two")
    assert path.read_bytes() == b"two"
    assert os.listdir(tmp_path) == ["a.gcode"]
    umask = os.umask(0)
    os.umask(umask)
    assert path.stat().st_mode & 0o777 == 0o666 & ~umask


def test_link_stays_a_link(tmp_path):
    path, link = tmp_path / "a.gcode", tmp_path / "link.gcode"
    path.write_bytes(b"one")
    link.symlink_to(path)
    write_file(link, b"two")
    assert link.is_symlink() and path.read_bytes() == b"two"


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no such devices here")
def test_device_is_written_to_and_stays():
    write_file("/dev/null", b"away")
    assert not os.path.isfile("/dev/null")
    with pytest.raises(OutputError, match="the disk is full"):
        write_file("/dev/full", b"too much")


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("none/a.gcode", "its folder does not exist"),
        ("file/a.gcode", "its folder is a file"),
        ("folder", "it is a folder"),
        ("n" * 300, "its name is too long"),
    ],
)
def test_one_sentence_and_nothing_left(tmp_path, path, reason):
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / "folder").mkdir()
    with pytest.raises(OutputError, match=reason) as error:
        write_file(tmp_path / path, b"data")
    assert "\n" not in str(error.value)
    assert sorted(os.listdir(tmp_path)) == ["file", "folder"]


def test_full_disk_leaves_the_old_file(tmp_path):
    resource = pytest.importorskip("resource")
    signal = pytest.importorskip("signal")
    path = tmp_path / "a.gcode"
    path.write_bytes(b"old")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        with pytest.raises(OutputError):
            write_file(path, bytes(100_000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.gcode"]


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write anywhere")
def test_no_permission(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(OutputError, match="no permission"):
        write_file(tmp_path / "a.gcode", b"")


def test_devices_are_written_to_not_replaced(tmp_path):
    if os.name != "posix":
        pytest.skip("no /dev/null here")
    null = type(tmp_path)("/dev/null")
    with OutputFiles({"null": null}) as files:
        files.staged("null").write_text("gone")
    assert null.is_char_device()


def test_a_name_may_be_as_long_as_the_folder_allows(tmp_path):
    path = tmp_path / f"{'n' * 251}.x3g"
    path.touch()
    with OutputFiles({"x3g": path}) as files:
        write_file(files.staged("x3g"), b"data")
    assert path.read_bytes() == b"data"
    keep_inputs([path], [tmp_path / ("n" * 256)])
    with pytest.raises(OutputError, match="its name is too long"):
        OutputFiles({"x3g": tmp_path / ("n" * 256)})
    with pytest.raises(OutputError, match="two outputs"):
        OutputFiles({"x3g": path, "gcode": tmp_path / "." / path.name})


def test_a_folder_that_is_gone_is_told(tmp_path, monkeypatch):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    try:
        (tmp_path / "gone").rmdir()
    except OSError:
        pytest.skip("folders in use cannot be removed here")
    with pytest.raises(OutputError, match="its folder does not exist"):
        OutputFiles({"gcode": type(tmp_path)("a.gcode")})


def test_files_appear_together_or_not_at_all(tmp_path):
    first, second = tmp_path / "a.txt", tmp_path / "b.txt"
    first.write_text("former")
    with pytest.raises(ZeroDivisionError), OutputFiles({"first": first, "second": second}) as files:
        files.staged("first").write_text("new")
        files.staged("second").write_text("new")
        raise ZeroDivisionError
    assert first.read_text() == "former" and [path.name for path in tmp_path.iterdir()] == ["a.txt"]
    with OutputFiles({"first": first, "second": second}) as files:
        files.staged("first").write_text("new")
        files.staged("second").write_text("new")
        assert first.read_text() == "former"
    assert first.read_text() == second.read_text() == "new" and len(list(tmp_path.iterdir())) == 2


def test_jobs_with_the_same_process_number_do_not_share_files(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "getpid", lambda: 1)  # as in each of several containers
    with OutputFiles({"x3g": tmp_path / "a.x3g"}) as one, OutputFiles({"x3g": tmp_path / "b.x3g"}) as other:
        one.staged("x3g").write_text("one")
        other.staged("x3g").write_text("other")
    assert [(tmp_path / name).read_text() for name in ("a.x3g", "b.x3g")] == ["one", "other"]


@pytest.mark.parametrize("system", ["win32", "darwin", "linux"])
def test_names_that_differ_in_case_are_one_file_where_case_does_not_count(tmp_path, monkeypatch, system):
    outputs = {"gcode": tmp_path / "print", "report": tmp_path / "PRINT"}
    monkeypatch.setattr(sys, "platform", system)
    with nullcontext() if system == "linux" else pytest.raises(OutputError, match="two outputs"):
        OutputFiles(outputs)


@pytest.mark.skipif(os.name != "posix", reason="no names for open files here")
def test_no_output_among_the_result(tmp_path):
    (tmp_path / "a.gcode").write_text("former")
    read, write = os.pipe()
    kept = os.dup(1)
    for place in (os.open(tmp_path / "a.gcode", os.O_WRONLY), write):
        os.dup2(place, 1)
        os.close(place)
        try:
            with pytest.raises(OutputError, match="where the program tells its result"):
                OutputFiles({"gcode": Path("/dev/stdout")})
        finally:
            os.dup2(kept, 1)
    os.close(kept)
    os.close(read)
    assert (tmp_path / "a.gcode").read_text() == "former"


@pytest.mark.skipif(not os.path.exists("/dev/fd"), reason="no names for open files here")
def test_a_pipe_to_another_program():
    read, write = os.pipe()
    with OutputFiles({"gcode": Path(f"/dev/fd/{write}")}) as files:
        write_file(files.staged("gcode"), b"G1 X1\n")
    write_file(f"/dev/fd/{write}", b"G1 X2\n")
    os.close(write)
    with os.fdopen(read, "rb") as pipe:
        assert pipe.read() == b"G1 X1\nG1 X2\n"


def test_what_went_wrong_first_is_told_even_if_nothing_can_be_removed(tmp_path, monkeypatch):
    def gone(path, missing_ok=False):
        raise OSError("the disk is gone")

    with pytest.raises(ZeroDivisionError), OutputFiles({"gcode": tmp_path / "a.gcode"}) as files:
        files.staged("gcode").write_text("half")
        monkeypatch.setattr(Path, "unlink", gone)
        raise ZeroDivisionError


def test_byte_order_marks_are_no_part_of_a_text(tmp_path):
    (tmp_path / "a.json").write_bytes(b'\xef\xbb\xbf{"layer_height": 0.2}')
    (tmp_path / "a.gcode").write_bytes(b"\xef\xbb\xbf; layer_height = 0.2\nG1 X1\n")
    assert read_json(tmp_path / "a.json") == {"layer_height": 0.2}
    assert read_print_file(tmp_path / "a.gcode") == b"; layer_height = 0.2\nG1 X1\n"


def test_titles_of_files_are_unicode():
    assert title(Path("a b.c.obj")) == "a b.c"
    assert title(Path("caf\udce9.obj")).encode().startswith(b"caf")

"""The command that looks for faults in an X3G file."""

from dualcolor.cli import main
from dualcolor.core.settings import PrintSettings
from dualcolor.core.x3g.writer import x3g_bytes
from dualcolor.tests.printing import rosette


def test_good_bad_and_missing_files(tmp_path, capsys):
    path = tmp_path / "part.x3g"
    whole = x3g_bytes(rosette(3, 40), PrintSettings())
    path.write_bytes(whole)
    assert main(["audit", str(path)]) == 0
    assert "moves, no faults found" in capsys.readouterr().out
    path.write_bytes(whole[: whole.rindex(b"\x96\x64")])  # without the end
    assert main(["audit", str(path)]) == 1
    shown = capsys.readouterr().err
    assert "error: part.x3g must not be printed by replicator_2x: the build starts 1 times and ends 0 times" in shown
    path.write_bytes(whole[:-7])
    assert main(["audit", str(path)]) == 1
    path.write_bytes(b"no X3G")
    assert main(["audit", str(path)]) == 1
    assert "the X3G file is damaged" in capsys.readouterr().err
    assert main(["audit", str(tmp_path / "missing.x3g")]) == 1
    assert "cannot be read" in capsys.readouterr().err
    assert main(["audit", str(tmp_path / "print.gcode")]) == 1
    assert "print.gcode is not an X3G file" in capsys.readouterr().err


def test_the_printer_is_chosen(tmp_path, capsys):
    path = tmp_path / "part.x3g"
    path.write_bytes(x3g_bytes(rosette(3, 40), PrintSettings(printer="replicator_dual")))
    assert main(["audit", str(path), "--printer", "replicator_dual"]) == 0
    assert main(["audit", str(path)]) == 1  # its steps are longer
    shown = capsys.readouterr().err
    assert "must not be printed by replicator_2x: it is sound for another printer: --printer replicator_dual" in shown
    assert main(["audit", str(path), "--printer", "ender"]) == 2
    assert main(["audit", str(path), "--printer", "marlin_dual"]) == 1
    assert "does not read X3G" in capsys.readouterr().err

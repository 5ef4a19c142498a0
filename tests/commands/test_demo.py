"""The job that the README begins with."""

import json

from dualcolor import cli


def test_the_sample_can_be_printed_as_it_is(tmp_path, capfd):
    """All its files are there, and no wall hangs in the air: it has supports."""
    assert cli.main(["demo", "--out", str(tmp_path), "--pixels", "100", "--set", "layer_height=0.3"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        f"suzanne.{each}" for each in ("gcode", "x3g", "png", "blend", "json")
    }
    report = json.loads((tmp_path / "suzanne.json").read_text(encoding="utf-8"))
    assert report["filament"]["support_share"] > 0.02
    assert "hang in the air" not in capfd.readouterr().out

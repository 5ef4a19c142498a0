"""A model to print, and commands that have to fail."""

import pytest
from dualcolor import cli
from dualcolor.tests.commands.models import CLOSED_BOX


@pytest.fixture
def box(tmp_path):
    """A cube of 20 mm without UVs, y up."""
    path = tmp_path / "box.obj"
    path.write_text(CLOSED_BOX)
    return path


@pytest.fixture
def refused(tmp_path, capfd):
    """Run a command that has to fail by the user's fault; returns the one line it says."""

    def run(*arguments):
        before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        capfd.readouterr()
        status = cli.main([str(argument) for argument in arguments])
        out, err = capfd.readouterr()
        after = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        assert status == 1 and out == ""
        lines = err.splitlines()
        assert len(lines) == 1 and lines[0].startswith("error: ") and "Traceback" not in err
        assert after == before
        return lines[0]

    return run

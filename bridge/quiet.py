"""Keep Blender's own messages off the standard output, where they would drown ours."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout

STDOUT = 1


@contextmanager
def quiet_stdout() -> Iterator[None]:
    """Send what is written to the process's standard output nowhere while the block runs.

    Importers and the renderer write there from C, so the file descriptor itself is turned away; reports of operators
    come through Python's `sys.stdout`, which need not be the same.
    """
    _flush()
    kept = os.dup(STDOUT)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, STDOUT)
    os.close(nowhere)
    try:
        with open(os.devnull, "w") as silence, redirect_stdout(silence):
            yield
    finally:
        _flush()
        os.dup2(kept, STDOUT)
        os.close(kept)


def _flush() -> None:
    sys.stdout.flush()
    if os.name == "posix":
        ctypes.CDLL(None).fflush(None)  # C's buffer would come out later

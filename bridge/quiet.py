"""Keep Blender's own messages off the standard streams, where they would drown ours."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout

STDOUT, STDERR = 1, 2


@contextmanager
def quiet_stdout() -> Iterator[None]:
    """Discard what is written to the process's standard output while the block runs.

    Importers and the renderer write there from C, so the file descriptor itself is turned away; reports of operators
    come through Python's `sys.stdout`, which need not be the same.
    """
    with _turned_away(STDOUT), open(os.devnull, "w") as silence, redirect_stdout(silence):
        yield


@contextmanager
def quiet_stderr() -> Iterator[None]:
    """Discard what is written to the process's standard error, for short blocks whose failures we report ourselves."""
    with _turned_away(STDERR), open(os.devnull, "w") as silence, redirect_stderr(silence):
        yield


@contextmanager
def _turned_away(descriptor: int) -> Iterator[None]:
    _flush()
    kept = os.dup(descriptor)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, descriptor)
    os.close(nowhere)
    try:
        yield
    finally:
        _flush()
        os.dup2(kept, descriptor)
        os.close(kept)


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:  # a Blender without a console on Windows has none
            stream.flush()
    if os.name == "posix":
        ctypes.CDLL(None).fflush(None)  # C's buffer would come out later

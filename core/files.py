"""Writing files so that a failed job leaves what was there."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path
from typing import Any

from .errors import OutputError, PrintError

# Settings take a few kB, tables somewhat more; no file is read beyond this.
MOST_JSON_BYTES = 1 << 20
MOST_PRINT_BYTES = 400_000_000
_REASONS = {
    errno.ENOENT: "its folder does not exist",
    errno.ENOTDIR: "its folder is a file",
    errno.EISDIR: "it is a folder",
    errno.EACCES: "there is no permission to write there",
    errno.EPERM: "there is no permission to write there",
    errno.EROFS: "there is no permission to write there",
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk is full",
    errno.EFBIG: "the disk takes no file of this size",
    errno.ENAMETOOLONG: "its name is too long",
}


def read_json(path: Path) -> Any:
    """The content of a JSON file, limited in size and nesting.

    Raises:
        OSError: it cannot be read.
        ValueError: it is too large or not JSON.
    """
    with path.open("rb") as file:
        data = file.read(MOST_JSON_BYTES + 1)
    if len(data) > MOST_JSON_BYTES:
        raise ValueError("too large")
    try:
        return json.loads(data.decode("utf-8"))
    except RecursionError:
        raise ValueError("nested too deeply") from None


def read_print_file(path: Path) -> bytes:
    """A G-code or X3G file.

    Raises:
        PrintError: it cannot be read, or is larger than any print.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MOST_PRINT_BYTES + 1)  # no farther, whatever size the file claims
    except OSError as problem:
        raise PrintError(f"{path} cannot be read", problem.strerror or "choose another file") from None
    if len(data) > MOST_PRINT_BYTES:
        raise PrintError(f"{path} has more than {MOST_PRINT_BYTES // 1_000_000} MB", "choose the file of a print")
    return data


def write_file(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file whole or not at all: under a temporary name beside it, then renamed.

    Args:
        path: where to; an existing file is replaced, its folder must exist.
        data: the content.

    Raises:
        OutputError: the file cannot be written; whatever was there before is untouched.
    """
    target = Path(os.path.realpath(path))
    try:
        if target.exists() and not target.is_file() and not target.is_dir():
            target.write_bytes(data)  # a device such as /dev/null must not be replaced by a file
            return
        if target.is_dir():
            raise IsADirectoryError(errno.EISDIR, "is a folder")
        if target.exists() and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, "is read-only")
        _write_beside_and_rename(target, data)
    except OSError as error:
        raise OutputError(f"{os.fspath(path)} cannot be written, {reason(error)}", "choose another path") from error


def reason(error: OSError) -> str:
    """Why a file cannot be written, in a few words."""
    return _REASONS.get(error.errno or 0, error.strerror or str(error))


def _write_beside_and_rename(target: Path, data: bytes) -> None:
    temporary = target.parent / f".dualcolor-{os.getpid()}.part"
    try:
        temporary.write_bytes(data)
        os.replace(temporary, target)
    except BaseException:  # raised again: after an interrupt, too, nothing half-written may stay
        temporary.unlink(missing_ok=True)
        raise

"""Reading and writing files so that a failed job leaves what was there: one file, or several that appear together."""

from __future__ import annotations

import errno
import json
import os
import secrets
import signal
import stat
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType, TracebackType
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
if sys.platform == "win32":
    _REASONS[errno.EACCES] = "there is no permission to write there, or another program has it open"


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
        return json.loads(without_mark(data).decode("utf-8"))
    except RecursionError:
        raise ValueError("nested too deeply") from None


def file_size(count: int) -> str:
    """A number of bytes as text."""
    return f"{count / 1e6:.1f} MB" if count >= 1e6 else f"{count / 1e3:.1f} kB"


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
    return without_mark(data)


def without_mark(text: bytes) -> bytes:
    """A text without the byte order mark that editors on Windows begin it with."""
    return text.removeprefix(b"\xef\xbb\xbf")


def title(path: Path) -> str:
    """A file's name without its suffix; names in Blender are UTF-8, those of files may be anything."""
    return os.fsencode(path.stem).decode("utf-8", "replace")


def write_file(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file whole or not at all: under a temporary name beside it, then renamed.

    Args:
        path: where to; an existing file is replaced, its folder must exist.
        data: the content.

    Raises:
        OutputError: the file cannot be written; whatever was there before is untouched.
    """
    try:
        target = _target(Path(path))
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
    temporary = target.parent / _temporary_name()
    try:
        temporary.write_bytes(data)
        os.replace(temporary, target)
    except BaseException:  # raised again: after an interrupt, too, nothing half-written may stay
        temporary.unlink(missing_ok=True)
        raise


def _temporary_name() -> str:
    """A name that no other job uses; process numbers alone repeat in containers and on other machines."""
    return f".dualcolor-{os.getpid()}-{secrets.token_hex(4)}.part"


class OutputFiles:
    """Checked before the work starts, written under temporary names, renamed together at the end.

    Used as a context manager: leaving the block normally puts all staged files in place, leaving it by an exception
    removes them and touches nothing that was there.

    Attributes:
        paths: of the files, by the kind of each.

    Raises:
        OutputError: two outputs have the same path, a folder is missing or cannot be written to, or writing a staged
            file has failed.
    """

    def __init__(self, paths: Mapping[str, Path]) -> None:
        self.paths = dict(paths)
        self._staged: dict[Path, Path] = {}
        seen: set[str] = set()
        for path in self.paths.values():
            _check_writable(path)
            place = _spelled_alike(os.path.realpath(path))
            if place in seen:
                raise OutputError(f"{path} is named for two outputs", "give each its own name")
            seen.add(place)

    def staged(self, kind: str) -> Path:
        """A temporary name in the same folder, with the same suffix, for what will become the file of a kind."""
        path = self.paths[kind]
        target = _target(path)
        folder = Path(tempfile.gettempdir()) if _is_device(target) else target.parent
        # Not the file's name, which may be as long as names can be.
        self._staged[target] = folder / f"{_temporary_name()}{path.suffix}"
        return self._staged[target]

    def __enter__(self) -> OutputFiles:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                for target, part in self._staged.items():
                    _put(part, target)
            elif isinstance(problem, (OSError, OutputError)):
                self._raise_failed(problem)
        finally:
            for part in self._staged.values():
                for left in (part, part.with_name(part.name + "@")):  # Blender's own temporary name
                    with suppress(OSError):  # the disk may be gone; what went wrong first is what is told
                        left.unlink(missing_ok=True)

    def _raise_failed(self, problem: OSError | OutputError) -> None:
        """Say which output could not be written, by its own name."""
        text = (
            problem.message if isinstance(problem, OutputError) else f"{problem.filename or 'a file'} cannot be written"
        )
        for target, part in self._staged.items():
            text = text.replace(str(part), str(target))
        hint = problem.hint if isinstance(problem, OutputError) else reason(problem)
        raise OutputError(text, hint) from problem


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Within the block a request to end (SIGTERM, SIGHUP) unwinds the stack as Ctrl+C does, so files are removed."""
    numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    if threading.current_thread() is not threading.main_thread():
        numbers = []  # only there can handlers be set
    heeded = [number for number in numbers if signal.getsignal(number) is not signal.SIG_IGN]  # nohup ignores SIGHUP
    former = {number: signal.signal(number, _unwind) for number in heeded}
    try:
        yield
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)


def _unwind(number: int, _frame: FrameType | None) -> None:
    raise SystemExit(128 + number)


def make_folder(path: Path) -> None:
    """Make a folder for output files, unless it is there.

    Raises:
        OutputError: it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        hint = "a file has that name" if isinstance(problem, FileExistsError) else problem.strerror or ""
        raise OutputError(f"the folder {path} cannot be made", hint) from None


def keep_inputs(outputs: Iterable[Path], inputs: Iterable[Path]) -> None:
    """Make sure that no output takes the place of a file that the job reads.

    Raises:
        OutputError: one would.
    """
    read = [path for path in inputs if os.path.isfile(path)]  # a Path's own tests fail at names that are too long
    for output in outputs:
        if os.path.isfile(output) and any(output.samefile(path) for path in read):
            raise OutputError(f"{output} is read by this job and would be lost", "write to another file")


def _spelled_alike(place: str) -> str:
    """A path as it is compared: Windows and macOS take no notice of small and capital letters."""
    return place.casefold() if sys.platform in ("win32", "darwin") else place


def _target(path: Path) -> Path:
    """What a link leads to; a device or pipe is known by the name that was given only."""
    return path if _is_device(path) else Path(os.path.realpath(path))


def _is_device(path: Path) -> bool:
    """Whether a path is something like /dev/null, which must not be replaced by a file."""
    return path.exists() and not path.is_file()


def _put(part: Path, target: Path) -> None:
    try:
        if _is_device(target):
            target.write_bytes(part.read_bytes())
        else:
            os.replace(part, target)
    except OSError as failed:
        raise OutputError(f"{target} cannot be written", reason(failed)) from None


def _check_writable(path: Path) -> None:
    try:
        if path.is_dir():
            raise OutputError(f"{path} cannot be written", "it is a folder")
        if _is_stdout(path):
            raise OutputError(f"{path} cannot be written", "it is where the program tells its result")
        if not path.parent.is_dir():
            raise OutputError(f"{path} cannot be written", f"there is no folder {path.parent}")
        if path.exists() and not os.access(path, os.W_OK):
            raise OutputError(f"{path} cannot be written", "the file is write-protected")
        if not _is_device(path):
            with tempfile.TemporaryFile(dir=Path(os.path.realpath(path)).parent):
                pass
    except OSError as failed:
        raise OutputError(f"{path} cannot be written", reason(failed)) from None


def _is_stdout(path: Path) -> bool:
    """Whether a path is the pipe or file that the standard output goes to, where more text is to come."""
    try:
        here, stdout = os.stat(path), os.fstat(1)
    except OSError:  # no such file yet, or no standard output
        return False
    return os.path.samestat(here, stdout) and not stat.S_ISCHR(here.st_mode)

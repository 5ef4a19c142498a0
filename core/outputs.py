"""Several output files of one command: all of them appear, or none does."""

from __future__ import annotations

import os
import signal
import tempfile
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, TracebackType

from .errors import OutputError
from .files import reason


class OutputFiles:
    """Checked before the work starts, written under temporary names, renamed together at the end.

    Used as a context manager: leaving the block normally puts all staged files in place, leaving it by an exception
    removes them and touches nothing that was there.

    Raises:
        OutputError: two outputs have the same path, a folder is missing or cannot be written to, or writing a staged
            file has failed.
    """

    def __init__(self, paths: Iterable[Path]) -> None:
        self._staged: dict[Path, Path] = {}
        seen: set[Path] = set()
        for path in paths:
            if path.resolve() in seen:
                raise OutputError(f"{path} is named for two outputs", "give each its own name")
            seen.add(path.resolve())
            _check_writable(path)

    def staged(self, path: Path) -> Path:
        """A temporary name in the same folder, with the same suffix, for the file that will become `path`."""
        target = Path(os.path.realpath(path))
        folder = Path(tempfile.gettempdir()) if _is_device(target) else target.parent
        self._staged[target] = folder / f".dualcolor-{os.getpid()}-{path.stem}.part{path.suffix}"
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
    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    if threading.current_thread() is not threading.main_thread():
        names = []  # only there can handlers be set
    former = {name: signal.signal(getattr(signal, name), _unwind) for name in names}
    try:
        yield
    finally:
        for name, handler in former.items():
            signal.signal(getattr(signal, name), handler)


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
        raise OutputError(f"the folder {path} cannot be made", problem.strerror or "") from None


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
    if path.is_dir():
        raise OutputError(f"{path} cannot be written", "it is a folder")
    if not path.parent.is_dir():
        raise OutputError(f"{path} cannot be written", f"there is no folder {path.parent}")
    if path.exists() and not os.access(path, os.W_OK):
        raise OutputError(f"{path} cannot be written", "the file is write-protected")
    if _is_device(path):
        return
    try:
        with tempfile.TemporaryFile(dir=Path(os.path.realpath(path)).parent):
            pass
    except OSError as failed:
        raise OutputError(f"{path} cannot be written", reason(failed)) from None

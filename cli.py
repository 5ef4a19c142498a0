"""The command line: `dualcolor COMMAND …`, alone or as `blender -b --command dualcolor COMMAND …`."""

from __future__ import annotations

import argparse
import errno
import os
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Protocol, TextIO

from .commands import analyze, audit, build_table, demo, measure, plate, read_photo, render, tile
from .commands import print as print_command
from .core.companions import companions
from .core.errors import PrintError
from .core.files import OutputFiles, ended_by_signals, file_size, keep_inputs
from .core.settings import PrintSettings

PROGRAM = "dualcolor"
DONE, USER_ERROR, INTERRUPTED = 0, 1, 130
READ = ("model", "images", "file", "photo", "texture", "settings", "simulated", "support_enforcer", "support_blocker")
"""Arguments that name files to read."""
SPELLINGS = {"analyze": ["analyse"]}
"""Other spellings of commands."""


class Command(Protocol):
    """What a module in `commands` has."""

    NAME: str
    HELP: str

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Declare the arguments."""

    def outputs(self, args: argparse.Namespace) -> dict[str, Path]:
        """The files that are to be written, by kind."""

    def run(self, args: argparse.Namespace, files: OutputFiles) -> list[str]:
        """Do it; the lines to be printed."""


COMMANDS: tuple[Command, ...] = (
    print_command,
    demo,
    render,
    plate,
    analyze,
    audit,
    measure,
    build_table,
    tile,
    read_photo,
)


def main(argv: Sequence[str]) -> int:
    """Run one command and return its exit status: 0 done, 1 the user's error, 2 wrong usage.

    Args:
        argv: the arguments after the program's name.
    """
    try:
        parser = make_parser()
        args, unknown = parser.parse_known_args(list(argv))
        if unknown:
            parser.error(_unknown(unknown))
    except SystemExit as stop:  # argparse has printed its message
        return int(stop.code or DONE)
    command = args.command
    try:
        paths = command.outputs(args)
        keep_inputs(paths.values(), _inputs(args))
        with ended_by_signals(), OutputFiles(paths) as files:
            message = command.run(args, files)
    except PrintError as problem:
        print("error:", _shown(" ".join(str(problem).split()), sys.stderr), file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt:
        return INTERRUPTED
    except SystemExit as ended:  # by a signal; files are tidied
        return int(ended.code or USER_ERROR)
    written = [f"wrote {path} ({file_size(path.stat().st_size)})" for path in paths.values()]
    return _say([*message, *written])


def make_parser() -> argparse.ArgumentParser:
    """The arguments of all commands."""
    parser = argparse.ArgumentParser(
        prog=PROGRAM,
        description="Print a picture on a shape with two filaments.",
        epilog=f"{PROGRAM} COMMAND --help explains a command. Exit status: 0 done, 1 an error that is told in one "
        "sentence, 2 wrong usage, 130 stopped by Ctrl+C.",
    )
    parser.add_argument("--version", action="version", version=f"{PROGRAM} {_version()}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in COMMANDS:
        sentence = f"{command.HELP[0].upper()}{command.HELP[1:]}."
        one = commands.add_parser(
            command.NAME, aliases=SPELLINGS.get(command.NAME, []), help=command.HELP, description=sentence
        )
        command.add_arguments(one)
        one.set_defaults(command=command)
    return parser


def _unknown(arguments: Sequence[str]) -> str:
    """What is wrong with arguments that no option takes; slicers have an option for every setting."""
    name = arguments[0].partition("=")[0].lstrip("-").replace("-", "_")
    if arguments[0].startswith("--") and name in {setting.name for setting in fields(PrintSettings)}:
        return f"{arguments[0]} is a setting: give it as --set {name}=VALUE"
    return f"unrecognized arguments: {' '.join(arguments)}"


def _inputs(args: argparse.Namespace) -> list[Path]:
    """The files that are named to be read, and those that models among them name."""
    values = [getattr(args, name, None) for name in READ]
    named = [each for value in values for each in (value if isinstance(value, list) else [value])]
    paths = [Path(each) for each in named if each is not None]
    return paths + [each for path in paths for each in companions(path)]


def _say(lines: Sequence[str]) -> int:
    """Print the result; who has stopped reading it, as `head` does, has not made the job fail."""
    try:
        print(_shown("\n".join(lines), sys.stdout), flush=True)
    except OSError as problem:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # else Python complains again when it ends
        if not isinstance(problem, BrokenPipeError) and problem.errno != errno.EINVAL:  # Windows's number for that
            print(f"error: the result cannot be shown: {problem.strerror}", file=sys.stderr)
            return USER_ERROR
    return DONE


def _shown(text: str, stream: TextIO | None) -> str:
    """A text with question marks for what a stream cannot show; names of files may be no Unicode at all."""
    encoding = getattr(stream, "encoding", None) or "utf-8"
    return text.encode(encoding, "replace").decode(encoding)


def _version() -> str:
    manifest = Path(__file__).with_name("blender_manifest.toml")
    return str(tomllib.loads(manifest.read_text(encoding="utf-8"))["version"])

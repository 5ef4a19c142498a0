"""`dualcolor audit`: whether an X3G file can be printed without watching it."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.errors import PrintError
from ..core.files import OutputFiles, read_print_file
from ..core.settings.printer import printer_names, printer_profile
from ..core.x3g.audit import audit
from ..core.x3g.reader import read_x3g

NAME = "audit"
SUFFIXES = (".x3g", ".s3g")
HELP = "look for faults in an X3G file before it is printed"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", type=Path, metavar="F.x3g", help="file of this program or of GPX")
    parser.add_argument("--printer", choices=printer_names(), default="replicator_2x", help="printer that the "
                        "file is for (default: replicator_2x)")  # fmt: skip


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """No files are written."""
    return {}


def run(args: argparse.Namespace, files: OutputFiles) -> list[str]:
    """Read the file and say that nothing is wrong with it.

    Raises:
        PrintError: something is, the file cannot be read or is damaged, or the printer reads no such files.
    """
    if args.file.suffix.lower() not in SUFFIXES:
        raise PrintError(f"{args.file.name} is not an X3G file", "name a file written by --x3g")
    printer = printer_profile(args.printer)
    if printer.marlin is not None:
        raise PrintError(f"{printer.name} does not read X3G", "choose another printer by --printer")
    commands = read_x3g(read_print_file(args.file))
    if findings := audit(commands, printer):
        others = {name: printer_profile(name) for name in printer_names() if name != args.printer}
        sound = [name for name, other in others.items() if not other.marlin and not audit(commands, other)]
        advice = [f"it is sound for another printer: --printer {name}" for name in sound]
        raise PrintError(f"{args.file.name} must not be printed by {args.printer}", "; ".join(advice or findings))
    return [f"{args.file.name}: {int(commands.moves.sum()):,} moves, no faults found for {args.printer}"]

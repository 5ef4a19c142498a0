"""Fuzz the readers of files: `python tests/fuzz/run.py --seconds 60 [--target NAME] [--seed N] [--keep FOLDER]`.

Only PrintError may come out of a reader, within 4 GB and 10 s. Files that did worse are kept.
"""

from __future__ import annotations

import argparse
import sys
import traceback
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic

ROOT = Path(__file__).resolve().parent.parent.parent
SLOW_S = 10.0
MEMORY = 4 << 30


@dataclass
class Outcome:
    """Of a target: how many files were tried, how many of them were refused, and what went wrong."""

    tried: int = 0
    refused: int = 0
    findings: dict[str, bytes] = field(default_factory=dict)


def fuzzed(name: str, seconds: float, seed: int, most: int = sys.maxsize) -> Outcome:
    """Try damaged files until the time is over or there have been so many."""
    import numpy as np
    from dualcolor.core.errors import PrintError
    from dualcolor.tests.fuzz.mutate import mutated
    from dualcolor.tests.fuzz.targets import targets

    target = targets()[name]
    random = np.random.default_rng(seed)
    outcome = Outcome()
    corpus = list(target.seeds)
    until = monotonic() + seconds
    while monotonic() < until and outcome.tried < most:
        data = mutated(corpus[int(random.integers(0, len(corpus)))], corpus, target.words, random)
        outcome.tried += 1
        began = monotonic()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)  # numpy's, which a user would see
                target.read(data)
        except PrintError as problem:
            outcome.refused += 1
            if "\n" in str(problem) or len(str(problem)) > 600:
                outcome.findings["a message that is no sentence"] = data
        except Exception as bug:  # whatever a reader raises but a PrintError is what is looked for
            place = traceback.extract_tb(bug.__traceback__)[-1]
            outcome.findings[f"{type(bug).__name__} in {place.name}, line {place.lineno}"] = data
        else:
            if len(corpus) < 200:
                corpus.append(data)  # what passes is damaged further
        if monotonic() - began > SLOW_S:
            outcome.findings["slow"] = data
    return outcome


def main() -> int:
    """Fuzz one reader or all of them and print what was found."""
    parser = argparse.ArgumentParser(description="Fuzz the readers of files.")
    parser.add_argument("--seconds", type=float, default=60, help="for each reader")
    parser.add_argument("--target", action="append", help="only this reader; repeatable")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("fuzz-findings"), help="folder for files that did harm")
    args = parser.parse_args()
    sys.path.insert(0, str(ROOT))
    from launcher import load_package

    load_package()
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    from dualcolor.tests.fuzz.targets import targets

    bad = 0
    for name in args.target or targets():
        outcome = fuzzed(name, args.seconds, args.seed)
        print(
            f"{name}: {outcome.tried:,} files, {outcome.refused:,} refused, {len(outcome.findings)} findings",
            flush=True,
        )
        for number, (text, data) in enumerate(outcome.findings.items()):
            args.keep.mkdir(exist_ok=True)
            (args.keep / f"{name}-{number}").write_bytes(data)
            print("  ", text, flush=True)
        bad += len(outcome.findings)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())

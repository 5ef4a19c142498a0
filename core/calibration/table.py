"""The tone table: what each tone looks like on each slope, and the inverse (paper, section 6.2)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import CalibrationError
from ..files import read_json, write_file
from ..model import FloatArray
from ..records import dataclass
from .provenance import Provenance

if TYPE_CHECKING:
    from .sweep import Sweep

FORMAT, VERSION = "dualcolor tone table", 1


@dataclass(frozen=True)
class ToneTable:
    """The face-on response on S slopes to T tones.

    Attributes:
        tone: (T,) printed, ascending from 0 to 1.
        slant_deg: (S,) ascending, 0 upright.
        reflectance: (S, T) linear, not descending along a row.
        noise: (S, T) standard error of the readings.
        provenance: what it is valid for.
    """

    tone: FloatArray
    slant_deg: FloatArray
    reflectance: FloatArray
    noise: FloatArray
    provenance: Provenance

    @property
    def upright(self) -> ToneTable:
        """A table of the least slope alone, to be used for all slopes."""
        return ToneTable(self.tone, self.slant_deg[:1], self.reflectance[:1], self.noise[:1], self.provenance)

    def printed(self, target: FloatArray) -> FloatArray:
        """(S, K) the tone to print for reflectances (S, K) on each slope; the nearest one where it is out of reach."""
        # A tiny rise makes flat stretches invertible.
        rise = np.arange(len(self.tone)) * 1e-9
        rows = zip(target, self.reflectance + rise, strict=True)
        return np.stack([np.interp(wanted, row, self.tone) for wanted, row in rows])

    def seen(self, printed: FloatArray, slant_deg: FloatArray) -> FloatArray:
        """(W, K) the reflectance of tones printed (W, K) on walls of some slopes (W,), face on."""
        rows = np.stack([[np.interp(tones, self.tone, row) for row in self.reflectance] for tones in printed])
        return np.asarray(np.einsum("ws,wsk->wk", slope_shares(self.slant_deg, slant_deg), rows))


def slope_shares(known_deg: FloatArray, wanted_deg: FloatArray) -> FloatArray:
    """(W, S) weights of S known slopes for W wanted ones, by linear interpolation, constant beyond the outermost."""
    number = np.arange(len(known_deg))
    at = np.interp(wanted_deg, known_deg, number)
    return np.asarray(np.clip(1.0 - np.abs(at[:, None] - number), 0.0, 1.0))


def table_of(sweeps: Sequence[Sweep]) -> ToneTable:
    """The table from the face-on readings of some tiles, one per slope.

    Args:
        sweeps: of one kind of print. Where a slope was read several times, the surest reading counts.
    """
    slants = sorted({sweep.slant_deg for sweep in sweeps})
    rows, noises = [], []
    for slant in slants:
        own = [sweep for sweep in sweeps if sweep.slant_deg == slant]
        best = min(own, key=lambda sweep: float(np.nanmean(sweep.noise[:, sweep.face_on])))
        rows.append(isotonic(best.reflectance[:, best.face_on]))
        noises.append(best.noise[:, best.face_on])
    return ToneTable(sweeps[0].tone, np.array(slants), np.stack(rows), np.stack(noises), sweeps[0].provenance)


def isotonic(values: FloatArray) -> FloatArray:
    """The ascending values nearest to these by least squares: isotonic regression by pooling adjacent violators."""
    means: list[float] = []
    counts: list[int] = []
    for value in values.tolist():
        means.append(value)
        counts.append(1)
        while len(means) > 1 and means[-2] > means[-1]:
            count = counts[-2] + counts[-1]
            means[-2:] = [(means[-2] * counts[-2] + means[-1] * counts[-1]) / count]
            counts[-2:] = [count]
    return np.repeat(means, counts)


def write_table(path: Path, table: ToneTable) -> None:
    """Write a table as JSON.

    Raises:
        OutputError: the file cannot be written.
    """
    values: dict[str, Any] = {"format": FORMAT, "version": VERSION, "about": table.provenance.as_dict()}
    values |= {"tone": table.tone.round(6).tolist(), "slant_deg": table.slant_deg.tolist()}
    values |= {"reflectance": table.reflectance.round(5).tolist(), "noise": table.noise.round(5).tolist()}
    lines = [f"  {json.dumps(name)}: {_text(value)}" for name, value in values.items()]
    write_file(path, ("{\n" + ",\n".join(lines) + "\n}\n").encode("utf-8"))


def _text(value: Any) -> str:
    """JSON with one row of a matrix per line."""
    if isinstance(value, list) and value and isinstance(value[0], list):
        return "[\n    " + ",\n    ".join(json.dumps(row) for row in value) + "\n  ]"
    return json.dumps(value)


def read_table(path: Path) -> ToneTable:
    """The table in a file.

    Raises:
        CalibrationError: it is missing, of another kind or version, or inconsistent.
    """
    hint = "give a file made by dualcolor build-table"
    try:
        values = read_json(path)
        if values["format"] != FORMAT or values["version"] != VERSION:
            raise CalibrationError(f"{path} is not a tone table of version {VERSION}", hint)
        tone, slant, seen, noise = (
            np.array(values[name], dtype=np.float64) for name in ("tone", "slant_deg", "reflectance", "noise")
        )
        table = ToneTable(tone, slant, seen, noise, Provenance.from_dict(values["about"]))
    except OSError as problem:
        raise CalibrationError(f"the tone table {path} cannot be read", problem.strerror or "") from None
    except (KeyError, ValueError, TypeError, AttributeError):
        raise CalibrationError(f"{path} is not a tone table", hint) from None
    if not _is_sound(table):
        raise CalibrationError(f"the tone table {path} is inconsistent", hint)
    return table


def _is_sound(table: ToneTable) -> bool:
    shape = (len(table.slant_deg), len(table.tone)) if table.tone.ndim == table.slant_deg.ndim == 1 else (0, 0)
    return bool(
        min(shape) > 0
        and shape[1] > 1
        and table.reflectance.shape == table.noise.shape == shape
        and all(np.isfinite(values).all() for values in (table.tone, table.slant_deg, table.reflectance))
        and {"Black", "White"} <= set(table.provenance.reflectance)
        and (np.diff(table.tone) > 0).all()
        and (np.diff(table.slant_deg) > 0).all()
        and (np.diff(table.reflectance, axis=1) >= 0).all()
    )

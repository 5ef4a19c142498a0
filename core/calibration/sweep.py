"""One job of a measurement: the tones of a tile from one row of directions, kept in a file of its own."""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from pathlib import Path

import numpy as np

from ..errors import CalibrationError
from ..files import write_file
from ..model import FloatArray
from ..records import dataclass
from .provenance import Provenance

BLOCKS = ("face", "phi", "theta")
"""Face on alone; turned up and down; turned to the sides."""
_STEP_DEG, _FARTHEST_DEG = 10, 80
_MOST_BYTES = 1 << 24  # readings take some kB

# Raised by numpy and zipfile for files that are not archives, are broken, or claim to be larger than the memory.
_DAMAGES = (
    *(OSError, EOFError, KeyError, ValueError, TypeError, AttributeError, NotImplementedError, RuntimeError),
    *(MemoryError, RecursionError, SyntaxError, zipfile.BadZipFile, zlib.error),
)


@dataclass(frozen=True)
class Sweep:
    """Readings of one tile. T tones, A directions.

    Attributes:
        slant_deg: of the tile.
        block: of `BLOCKS`.
        angle_deg: (A,) φ or θ; 0 looks along the face's normal, positive from above or from the right.
        tone: (T,) that the tile's picture has.
        reflectance: (T, A) linear, what is seen.
        noise: (T, A) standard error of it.
        provenance: what they are valid for.
    """

    slant_deg: float
    block: str
    angle_deg: FloatArray
    tone: FloatArray
    reflectance: FloatArray
    noise: FloatArray
    provenance: Provenance

    @property
    def face_on(self) -> int:
        """The column that looks along the normal."""
        return int(np.flatnonzero(self.angle_deg == 0)[0])


def angles_of(block: str) -> list[tuple[float, float]]:
    """(φ, θ) of each direction of a block, degrees, in the order of its columns."""
    turn = [float(angle) for angle in range(-_FARTHEST_DEG, _FARTHEST_DEG + 1, _STEP_DEG)]
    if block == "phi":
        return [(angle, 0.0) for angle in turn]
    return [(0.0, angle) for angle in turn] if block == "theta" else [(0.0, 0.0)]


def sweep_path(folder: Path, slant_deg: float, block: str) -> Path:
    """The file of a job's readings."""
    return folder / f"slant_{slant_deg:g}_{block}.npz"


def write_sweep(path: Path, sweep: Sweep) -> None:
    """Write readings whole or not at all.

    Raises:
        OutputError: the file cannot be written.
    """
    buffer = io.BytesIO()
    np.savez(
        buffer,
        slant_deg=sweep.slant_deg,
        block=sweep.block,
        angle_deg=sweep.angle_deg,
        tone=sweep.tone,
        reflectance=sweep.reflectance,
        noise=sweep.noise,
        about=json.dumps(sweep.provenance.as_dict()),
    )
    write_file(path, buffer.getvalue())


def read_sweep(path: Path) -> Sweep:
    """The readings in a file.

    Raises:
        CalibrationError: it is missing, holds something else or is inconsistent.
    """
    try:
        _check_size(path)
        with np.load(path, allow_pickle=False) as held:
            provenance = Provenance.from_dict(json.loads(str(held["about"])))
            angle, tone, seen, noise = (
                held[name].astype(np.float64) for name in ("angle_deg", "tone", "reflectance", "noise")
            )
            sweep = Sweep(float(held["slant_deg"]), str(held["block"]), angle, tone, seen, noise, provenance)
            if not _is_sound(sweep):
                raise ValueError("inconsistent")
            return sweep
    except _DAMAGES:
        raise CalibrationError(f"{path} holds no readings of a tile", "remove it and measure again") from None


def _is_sound(sweep: Sweep) -> bool:
    shape = (len(sweep.tone), len(sweep.angle_deg)) if sweep.tone.ndim == sweep.angle_deg.ndim == 1 else (0, 0)
    return bool(
        min(shape) > 0
        and sweep.reflectance.shape == sweep.noise.shape == shape
        and sweep.block in BLOCKS
        and np.isfinite([sweep.slant_deg, *sweep.tone]).all()
        and (np.diff(sweep.tone) > 0).all()
        and (sweep.angle_deg == 0).any()
    )


def _check_size(path: Path) -> None:
    """Refuse an archive that unpacks to more than any readings take."""
    with zipfile.ZipFile(path) as archive:
        if sum(entry.file_size for entry in archive.infolist()) > _MOST_BYTES:
            raise ValueError("too large")


def read_sweeps(folder: Path) -> list[Sweep]:
    """All readings in a folder, by slant and block.

    Raises:
        CalibrationError: there are none, one is broken, or they are of different settings.
    """
    sweeps = [read_sweep(path) for path in sorted(folder.glob("slant_*.npz"))]
    if not sweeps:
        raise CalibrationError(f"{folder} holds no readings of tiles", "run dualcolor measure first")
    first = sweeps[0]
    if any(sweep.provenance != first.provenance or not np.array_equal(sweep.tone, first.tone) for sweep in sweeps):
        raise CalibrationError(f"{folder} holds readings of different settings", "measure each into its own folder")
    return sorted(sweeps, key=lambda sweep: (sweep.slant_deg, sweep.block))

"""The fitted phase: on a cylinder without sliding and even, elsewhere the solution of its least-squares problem."""

import numpy as np
import pytest
from dualcolor.core.sampling import phase_fit
from dualcolor.core.sampling.phase import Phase
from dualcolor.core.sampling.phase_fit import HARD, SOFT, FitEffort, PhaseFit
from dualcolor.core.sampling.projected_grid import phase_grid
from dualcolor.core.sampling.projector import Projector
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.pattern_stages import lines_of
from dualcolor.tests.solids import cylinder, joined, lathe

SETTINGS = PrintSettings(pattern="wave")
USUAL = SETTINGS.wavelength * np.sqrt(2)


def roughly(model, stray):
    """The grid of a model, and a phase that rises evenly around each contour but for random numbers."""
    lines = lines_of(model, SETTINGS)
    grid = phase_grid(Projector(lines, SETTINGS.projection_threshold), SETTINGS.wavelength)
    turns = np.rint(lines.length / USUAL).astype(np.int64)
    along = (grid.arc - lines.arc_start[grid.loop]) / lines.length[grid.loop] * turns[grid.loop]
    return grid, Phase(along + np.random.default_rng(3).uniform(-stray, stray, len(along)), turns)


def slides(grid, phase):
    """(K,) what the phase at a node's image is more than its own, less whole numbers; of linked nodes."""
    apart = phase.at(grid.low, grid.share, grid) - phase.value
    return (apart - np.rint(apart))[grid.linked]


def test_on_a_cylinder_nothing_slides_and_waves_are_even():
    grid, rough = roughly(joined(cylinder(9, 1.5, 240), cylinder(4, 1.5, 120, x=20)), 0.1)
    assert np.abs(slides(grid, rough)).max() > 0.1
    for plain in (6, 0):
        fitted = PhaseFit(grid, rough, np.ones(len(grid.arc)), SETTINGS.wavelength).solved(FitEffort(6, plain, 200))
        assert np.abs(slides(grid, fitted)).max() < 1e-3
        around = np.bincount(grid.loop, grid.length)[grid.loop]
        even = fitted.turns[grid.loop] * grid.length / around
        assert fitted.waves(grid) == pytest.approx(even, rel=0.01)


@pytest.mark.parametrize("stray", [0.02, 0.3])
def test_a_round_solves_its_least_squares_problem(stray, monkeypatch):
    """Against the dense one: rows of sliding, and rows that pull each edge to its target, or into its bounds."""
    monkeypatch.setattr(phase_fit, "CONVERGED", 1e-16)
    grid, rough = roughly(lathe([[4, 0], [6, 1], [5.4, 1.6]], sides=90), stray)
    size = len(grid.arc)
    weight = np.random.default_rng(5).uniform(0.2, 1, size)
    fit = PhaseFit(grid, rough, weight, SETTINGS.wavelength)
    one, waves = np.eye(size), rough.waves(grid)
    link = one[grid.low] * (1 - grid.share)[:, None] + one[grid.ahead[grid.low]] * grid.share[:, None] - one
    edge = one[grid.ahead] - one
    bounded = np.clip(waves, fit.least, fit.most)
    inside = bounded == waves
    pull = np.sqrt(np.where(inside, SOFT, HARD)) * SETTINGS.wavelength / grid.length
    goal = np.where(inside, grid.length / USUAL, bounded) - grid.closes * rough.turns[grid.loop]
    hold = np.sqrt(fit.weight)  # 0 where there is no image
    rows = np.concatenate([link * hold[:, None], edge * pull[:, None]])
    sides = np.concatenate([fit.offset * hold, goal * pull])
    fitted = fit.solved(FitEffort(1, 1, 4 * size)).value

    def cost(value):
        return np.square(rows @ value - sides).sum()

    best, *_ = np.linalg.lstsq(rows, sides, rcond=None)
    assert cost(best) < 0.8 * cost(rough.value)
    assert cost(fitted) == pytest.approx(cost(best), rel=1e-6)
    assert (inside.mean() < 0.9) == (stray > 0.1)

"""Whatever mesh and settings are given: a print that holds together, or one sentence."""

import warnings
from dataclasses import replace

import numpy as np
from dualcolor.core.errors import PrintError, SettingsError
from dualcolor.core.gcode.reader import read_gcode
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.x3g.audit import audit
from dualcolor.core.x3g.reader import read_x3g
from dualcolor.core.x3g.writer import x3g_bytes
from dualcolor.tests.printing import gcode_text
from dualcolor.tests.robustness.strategies import ANY_SETTINGS, JOB_SETTINGS, broken, examples, solids
from dualcolor.tests.robustness.winding import agreement
from dualcolor.tests.solids import lathe, picture
from hypothesis import assume, given

VASE = lathe([[4, 0], [5, 0.6], [3.5, 1.4]], 24, textures=(picture(np.random.default_rng(1).random((16, 16))),))


def printed(model, settings):
    """The print; None where it is refused, in one sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            return generate(model, settings)
    except PrintError as problem:
        assert problem.message and "\n" not in str(problem) and len(str(problem)) < 400
        return None


def assert_holds_together(result):
    """Finite, within reach, nothing but strands with a cross-section; the files tell the same print."""
    moves, settings = result.moves, result.settings
    strand = moves.extrudes
    assert np.isfinite(moves.position).all() and np.isfinite(moves.filament).all()
    assert (moves.width[strand] > 0).all() and (moves.height[strand] > 0).all() and (moves.speed > 0).all()
    profile = settings.printer_profile
    low, high = np.array(profile.reach_min) - 1e-6, np.array(profile.reach_max) + 1e-6
    assert (moves.position[strand] >= low).all() and (moves.position[strand] <= high).all()
    back = read_gcode(gcode_text(moves, settings, []), "part").moves
    np.testing.assert_allclose(back.filament[back.extrudes].sum(), moves.filament[strand].sum(), rtol=1e-3)
    if not profile.marlin:
        assert not audit(read_x3g(x3g_bytes(moves, settings, "part")), profile)


def middles_below(height, settings):
    """How many layers have their middle below a height: those are printed."""
    middles = settings.first_layer_height + settings.layer_height * (np.arange(200) - 0.5)
    middles[0] = settings.first_layer_height / 2
    assume(np.abs(middles - height).min() > 1e-6)
    return int((middles < height).sum())


@given(solids(), JOB_SETTINGS)
@examples(40)
def test_any_solids_print_where_they_are(model, changes):
    settings = PrintSettings().changed(changes)
    result = printed(model, settings)
    if result is None:
        return
    assert_holds_together(result)
    assert len(result.slices.layers) == middles_below(float(np.ptp(model.vertices[:, 2])), settings)
    assert not len(result.slices.open_layers)
    # A face in the very plane of a layer belongs to either side; loops in which no strand fits are left out.
    even = np.abs(result.mesh.vertices[:, 2, None] - result.slices.layers.plane).min(axis=0) < 1e-6
    passed = np.union1d(np.flatnonzero(even), result.slices.specks.layer)
    found = agreement(result.mesh, replace(result.slices, open_layers=passed), 400)
    assert found.disagreements == 0


@given(broken(), JOB_SETTINGS)
@examples(60)
def test_any_broken_mesh_prints_or_is_refused(model, changes):
    result = printed(model, PrintSettings().changed(changes))
    if result is not None:
        assert_holds_together(result)
        named = any("do not close" in text for text in result.warnings)
        assert named == bool(len(result.slices.open_layers))


@given(ANY_SETTINGS)
@examples(30)
def test_any_settings_print_or_are_refused(values):
    try:
        settings = PrintSettings().changed(values)
    except SettingsError:
        assume(False)
    result = printed(VASE, settings)
    if result is not None:
        assert_holds_together(result)

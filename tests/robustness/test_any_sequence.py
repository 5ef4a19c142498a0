"""Whatever is changed from one run to the next, in whatever order: what is kept of former runs changes no print."""

from dataclasses import replace

import numpy as np
from dualcolor.core.job.stage_cache import StageCache
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.core.job.test_layers_anew import PICTURE, bottle
from dualcolor.tests.core.job.test_stage_cache import of
from dualcolor.tests.robustness.strategies import examples
from hypothesis import given
from hypothesis import strategies as st

HALF = replace(PICTURE, tone=np.where(np.arange(len(PICTURE.tone)) < 40, 0.5, PICTURE.tone.T).T.astype(np.float32))
UPSIDE_DOWN = replace(PICTURE, tone=PICTURE.tone[::-1].copy())
STROKE = replace(PICTURE, tone=np.vstack([PICTURE.tone[:30], PICTURE.tone[30:34] * 0, PICTURE.tone[34:]]))
CHOICES = {
    "pattern": ("offset", "wave", "wave_offset"),
    "calibration": ("slope_aware", "none", "upright"),
    "offset_max": (0.35, 0.3),
    "offset_onset": (0.0, 0.2),
    "hide_seams": (False, True),
    "seam_position": ("rear", "aligned", "nearest"),
    "tower_type": ("w", "none"),
    "solid_regions": ("none", "set_back", "tool_change"),
    "infill_density": (10.0, 0.0),
    "slowdown_below_layer_time": (5.0, 25.0),
}
SETTINGS = st.fixed_dictionaries({}, optional={name: st.sampled_from(values) for name, values in CHOICES.items()})
RUNS = st.lists(st.tuples(st.sampled_from([PICTURE, HALF, UPSIDE_DOWN, STROKE]), SETTINGS), min_size=2, max_size=4)


@given(RUNS)
@examples(8)
def test_runs_one_after_the_other_print_as_each_alone(runs):
    cache = StageCache()
    for image, changed in runs:
        settings = PrintSettings().changed(changed)
        assert of(generate(bottle(image), settings, cache=cache)) == of(generate(bottle(image), settings))

"""A run that finds former stages gives what a run without them gives, and reads again what has changed."""

import json
from dataclasses import replace

import numpy as np
import pytest
from dualcolor.core.job.stage_cache import StageCache
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.printing import gcode_text
from dualcolor.tests.solids import lathe, picture

RANDOM = np.random.default_rng(3)
FIRST, SECOND = (picture(RANDOM.random((32, 32))) for _ in range(2))


def model(image):
    return lathe([[6, 0], [8, 3], [5, 5]], 48, textures=(image,))


def of(result):
    """The file, and the report but for the times; sums may depend on how arrays lie in memory, in the last digit."""
    left_out = ("stages_s", "beside_s", "total_s", "peak_rss_mb")
    rows = json.dumps({key: value for key, value in result.report.items() if key not in left_out})
    rounded = json.loads(rows, parse_float=lambda text: float(f"{float(text):.10g}"))
    return gcode_text(result.moves, result.settings, []), rounded, result.warnings


CHANGES = [
    {}, {"wave_depth_max": 0.6}, {"wavelength": 1.5}, {"background_tone": 0.2}, {"infill_density": 25.0},
    {"infill_density": 0.0}, {"infill_density": 100.0}, {"infill_density": 40.0},
    {"layer_height": 0.2}, {"support_enable": True}, {"wave_speed": 25.0}, {"pattern": "wave"},
    {"sampling": "paper"}, {"extrusion_width": 0.5}, {"perimeters": 3}, {"calibration": "upright"},
    {"texture_filter": "lanczos"}, {}, {"front": True},
    {"front_angle": 90.0}, {"hide_seams": True}, {"solid_regions": "tool_change", "solid_region_tolerance": 0.4}, {},
]  # fmt: skip


def test_results_are_those_without_a_cache():
    cache = StageCache()
    settings = PrintSettings()
    for number, change in enumerate(CHANGES):
        settings = settings.changed(change)
        shape = model(FIRST if number % 3 else SECOND)
        assert of(generate(shape, settings, cache=cache)) == of(generate(shape, settings)), change


def counted(cache, monkeypatch):
    """The names of the stages that are computed."""
    names, original = [], cache.run

    def run(stage, function, *arguments):
        def noting(*given):
            names.append(stage)
            return function(*given)

        return original(stage, noting, *arguments)

    monkeypatch.setattr(cache, "run", run)
    return names


@pytest.mark.parametrize(
    ("change", "kept", "computed"),
    [
        ({}, {"slicing", "contours", "sampling", "tone", "fill", "toolpaths", "texture"}, set()),
        ({"offset_onset": 0.2}, {"slicing", "contours", "texture", "tone"}, {"modulation", "fill"}),
        (
            {"infill_density": 33.0},
            {"slicing", "contours", "sampling", "tone", "wave", "inside", "closing", "areas"},
            {"fill", "toolpaths"},
        ),
        ({"infill_density": 0.0}, {"slicing", "contours", "closing"}, {"bridges", "areas", "fill"}),
        ({"infill_density": 100.0}, {"slicing", "contours", "inside"}, {"closing", "fill"}),
        ({"wavelength": 1.6}, {"slicing", "texture"}, {"contours", "sampling", "tone"}),
        ({"layer_height": 0.3}, set(), {"slicing", "contours", "fill", "texture"}),
    ],
)
def test_only_what_reads_the_change_is_computed(change, kept, computed, monkeypatch):
    cache = StageCache()
    generate(model(FIRST), PrintSettings(), cache=cache)
    names = counted(cache, monkeypatch)
    generate(model(FIRST), PrintSettings().changed(change), cache=cache)
    assert not kept & set(names) and computed <= set(names)


def test_another_picture_keeps_the_slices(monkeypatch):
    cache = StageCache()
    generate(model(FIRST), PrintSettings(), cache=cache)
    names = counted(cache, monkeypatch)
    generate(model(SECOND), PrintSettings(), cache=cache)
    assert {"slicing", "contours", "sampling", "slant", "charts", "shadow", "closing"}.isdisjoint(names) and {
        "texture",
        "tone",
    } <= set(names)
    moved = replace(model(SECOND), vertices=model(SECOND).vertices * 1.01)
    names.clear()
    generate(moved, PrintSettings(), cache=cache)
    assert {"slicing", "contours"} <= set(names)


def test_memory_is_bounded():
    cache = StageCache(most_bytes=1000)
    generate(model(FIRST), PrintSettings(), cache=cache)
    assert not cache._held
    roomy = StageCache()
    generate(model(FIRST), PrintSettings(), cache=roomy)
    assert roomy._held
    once = roomy.size
    assert 1e6 < once < 100e6
    generate(model(FIRST), PrintSettings(), cache=roomy)
    assert roomy.size == once


@pytest.mark.parametrize(
    "array",
    [
        np.array([1.0, np.nan, -0.0]), np.arange(7, dtype=np.uint8), np.arange(200_003) * 0.5, np.zeros((0, 3)),
        np.arange(12.0).reshape(3, 4).T, np.arange(12.0).reshape(3, 4)[:, ::2], np.array(3.0),
        np.ones((5, 2), dtype=bool),
    ],
)  # fmt: skip
def test_arrays_are_known_again_and_no_others(array):
    cache, calls = StageCache(), []

    def stage(given):
        calls.append(1)
        return given

    cache.run("a", stage, array)
    cache.run("a", stage, np.array(array, order="K"))
    cache.run("a", stage, np.array(array, order="C"))
    assert len(calls) == 1
    for place in {0, array.size // 2, array.size - 1} if array.size else ():
        other = np.array(array, order="K")
        other.flat[place] = 0 if other.flat[place] else 1
        cache.run("a", stage, other)
        cache.run("a", stage, array)
    assert len(calls) == 1 + 2 * len({0, array.size // 2, array.size - 1} if array.size else ())


def test_a_stage_is_run_again_when_a_setting_that_it_read_changes():
    cache, calls = StageCache(), []

    def stage(numbers, settings):
        calls.append(1)
        return settings.perimeters if settings.infill_density > 10 else len(numbers)

    numbers = np.arange(3)
    settings = PrintSettings().changed({"infill_density": 10.0})
    assert cache.run("a", stage, numbers, settings) == 3
    assert cache.run("a", stage, numbers.copy(), settings.changed({"perimeters": 7})) == 3 and len(calls) == 1
    assert cache.run("a", stage, numbers, settings.changed({"perimeters": 7, "infill_density": 20.0})) == 7
    assert cache.run("a", stage, numbers, settings.changed({"perimeters": 5, "infill_density": 20.0})) == 5
    assert cache.run("a", stage, np.arange(4), settings.changed({"infill_density": 5.0})) == 4 and len(calls) == 4

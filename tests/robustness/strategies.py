"""What hypothesis draws: solids, damage to meshes and files, pictures, settings; and how many of each are tried."""

from dataclasses import fields, replace

import numpy as np
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.solids import box, joined, lathe, surface
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

SEARCHED = 40
"""How many times as many examples a search tries: `pytest --hypothesis-profile=search`."""


def examples(count):
    """So many examples, always the same ones; in a search many more, different each time."""
    default = settings.default
    return settings(max_examples=count if default.derandomize else SEARCHED * count)


def millimeters(low, high):
    """Eighths, which are also the heights of planes, and hundredths."""
    return st.one_of(
        st.integers(int(np.ceil(low * 8)), int(high * 8)).map(lambda eighths: eighths / 8),
        st.integers(int(np.ceil(low * 100)), int(high * 100)).map(lambda hundredths: hundredths / 100),
    )


@st.composite
def boxes(draw):
    """A box on the bed or above it, upright or leaning."""
    x, y, z = draw(millimeters(-6, 6)), draw(millimeters(-6, 6)), draw(st.sampled_from([0.0, 0.0, 0.5, 0.625, 1.0]))
    size = [draw(millimeters(0.4, 8)), draw(millimeters(0.4, 8)), draw(millimeters(0.3, 2.5))]
    made = box((x, y, z), (x + size[0], y + size[1], z + size[2]), inward=draw(st.booleans()))
    lean = draw(st.sampled_from([0.0, 0.0, 0.3, -1.0]))
    return replace(made, vertices=made.vertices + lean * np.outer(made.vertices[:, 2] - z, [1, 0, 0]))


@st.composite
def lathes(draw):
    """A solid of revolution."""
    radius = draw(st.lists(millimeters(0.3, 6), min_size=2, max_size=5))
    step = draw(st.sampled_from([0.25, 0.5, 0.61]))
    profile = np.column_stack([radius, np.arange(len(radius)) * step])
    sides = draw(st.sampled_from([3, 5, 24]))
    return lathe(profile, sides, x=draw(millimeters(-4, 4)), y=draw(millimeters(-4, 4)))


def solids():
    """One to four closed solids in one mesh: apart, touching, overlapping, nested, some of them inside out."""
    return st.lists(st.one_of(boxes(), lathes()), min_size=1, max_size=4).map(lambda parts: joined(*parts))


@st.composite
def broken(draw):
    """A mesh as people download it: faces that lack, are turned round or there twice, vertices torn out of place."""
    if draw(st.integers(0, 3)) == 0:
        return draw(soups())
    model = draw(solids())
    vertices, faces = model.vertices.copy(), model.corner_vertex.reshape(-1, 3).copy()
    picks = st.lists(st.integers(0, len(faces) - 1), max_size=6)
    turned, doubled, lost = draw(picks), draw(picks), draw(picks)
    faces[turned] = faces[turned, ::-1]
    faces = np.delete(np.concatenate([faces, faces[doubled]]), lost, axis=0)
    for number in draw(st.lists(st.integers(0, len(vertices) - 1), max_size=2)):
        vertices[number] += draw(arrays(np.float64, 3, elements=st.floats(-3, 3)))
    if draw(st.integers(0, 4)) == 0:
        vertices[draw(st.integers(0, len(vertices) - 1))] = draw(st.sampled_from([np.nan, np.inf, 1e38, -1e9, 1e-40]))
    scale = draw(st.sampled_from([1.0, 1.0, 1.0, 1e-6, 1 / 25.4, 1e3, 1e36]))
    return surface(vertices * scale, faces)


@st.composite
def soups(draw):
    """Triangles between any places, some of them flat, some with a vertex twice."""
    count = draw(st.integers(3, 20))
    points = draw(arrays(np.float64, (count, 3), elements=st.integers(-64, 64))) / 8
    flat = draw(st.sampled_from([1.0, 1.0, 1e-9]))
    faces = draw(st.lists(st.tuples(*[st.integers(0, count - 1)] * 3), min_size=1, max_size=40))
    return surface(points * [1, 1, flat], np.array(faces))


JOB_SETTINGS = st.fixed_dictionaries(
    {},
    optional={
        "layer_height": st.sampled_from([0.15, 0.2, 0.3]),
        "first_layer_height": st.sampled_from([0.2, 0.35]),
        "pattern": st.sampled_from(["wave", "wave_offset", "offset"]),
        "sampling": st.sampled_from(["optimized", "paper"]),
        "wavelength": st.sampled_from([0.5, 3.0]),
        "solid_regions": st.sampled_from(["none", "set_back"]),
        "perimeters": st.integers(0, 3),
        "extrusion_width": st.sampled_from([0.3, 0.6]),
        "infill_pattern": st.sampled_from(["grid", "triangles", "gyroid", "concentric"]),
        "infill_density": st.sampled_from([0.0, 30.0, 100.0]),
        "outer_wall_first": st.booleans(),
        "seam_position": st.sampled_from(["aligned", "rear", "nearest", "valley"]),
        "brim_width": st.sampled_from([0.0, 2.0]),
        "raft_layers": st.integers(0, 2),
        "tower_type": st.sampled_from(["w", "none"]),
        "ooze_shield": st.booleans(),
        "support_enable": st.booleans(),
        "black_tool": st.integers(0, 1),
        "z_hop": st.sampled_from([0.0, 0.4]),
        "wipe": st.sampled_from([0.0, 1.0]),
        "avoid_crossing_perimeters": st.booleans(),
        "standby_temperature_delta": st.sampled_from([0.0, 40.0]),
    },
)
"""Settings that change what is printed, by name; few at a time when an example is made small."""


def values_of(declared):
    """Values that a setting may have."""
    about, kind = declared.metadata, type(declared.default)
    if about["choices"]:
        return st.sampled_from(about["choices"])
    if kind is bool:
        return st.booleans()
    if kind is str:
        return st.text(max_size=20)
    if kind is int:
        return st.integers(int(about["low"]), int(about["high"]))
    return st.floats(about["low"], about["high"])


ANY_SETTINGS = st.fixed_dictionaries({}, optional={each.name: values_of(each) for each in fields(PrintSettings)})
"""Any settings within their limits, by name."""


@st.composite
def pixels(draw):
    """(H, W, 4) of 8, 16 or 32 bits a channel, as Blender hands them over; those of 32 bits may be anything."""
    shape = (draw(st.integers(1, 6)), draw(st.integers(1, 6)), 4)
    bits = draw(st.sampled_from([8, 16, 32]))
    if bits == 32:
        return draw(arrays(np.float32, shape, elements=st.floats(width=32)))
    most = (1 << bits) - 1
    return draw(arrays(np.int64, shape, elements=st.integers(0, most))).astype(np.float32) / np.float32(most)


@st.composite
def damaged(draw, seeds, words):
    """The bytes of one of the files, cut short, with bytes changed, pieces lost or doubled and words put in."""
    data = draw(st.sampled_from(seeds))
    for _ in range(draw(st.integers(1, 5))):
        here = draw(st.integers(0, len(data)))
        there = min(len(data), here + draw(st.integers(0, 60)))
        kind = draw(st.sampled_from(["end", "byte", "loss", "double", "word", "other"]))
        middle = {
            "end": b"",
            "byte": draw(st.binary(max_size=2)),
            "loss": b"",
            "double": data[here:there] * 2,
            "word": draw(st.sampled_from(words)),
            "other": draw(st.sampled_from(seeds))[here:there],
        }[kind]
        data = data[:here] + middle + (b"" if kind == "end" else data[here + 1 :] if kind == "byte" else data[there:])
    return data

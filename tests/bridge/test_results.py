"""What an export need not compute again: prints known by what they were made from, the latest few of them."""

from dataclasses import replace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.results import digest_of, forget_all, keep, kept, stages_of  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.tests.scene import add_box, model_of  # noqa: E402


@pytest.fixture
def boxes(registered):
    yield [add_box((9, 9, 9), f"box {number}") for number in range(3)]
    forget_all()


def test_a_print_is_known_by_every_number_that_it_was_made_from(boxes):
    model = model_of(boxes[0])
    known = {digest_of(model, PrintSettings()), digest_of(model, PrintSettings(wipe=1.0))}
    polygons = np.zeros(len(model.polygon_texture), dtype=np.int64)
    others = {"polygon_support": polygons, "polygon_object": polygons, "vertices": model.vertices + 1e-9, "name": "x"}
    known |= {digest_of(replace(model, **{name: value}), PrintSettings()) for name, value in others.items()}
    assert len(known) == 6
    assert digest_of(replace(model, vertices=model.vertices.copy()), PrintSettings()) in known


def test_the_two_latest_prints_are_kept_for_what_they_were_made_from(boxes):
    for number, box in enumerate(boxes):
        keep(box, f"digest {number}", f"print {number}")
    assert [kept(box, f"digest {number}") for number, box in enumerate(boxes)] == [None, "print 1", "print 2"]
    assert kept(boxes[2], "digest 1") is None
    keep(boxes[1], "new", "print 3")
    keep(boxes[0], "digest 0", "print 0")
    assert kept(boxes[1], "new") == "print 3" and kept(boxes[2], "digest 2") is None


def test_stages_are_kept_of_the_last_object_alone(boxes):
    first = stages_of(boxes[0])
    assert stages_of(boxes[0]) is first
    stages_of(boxes[1])
    assert stages_of(boxes[0]) is not first

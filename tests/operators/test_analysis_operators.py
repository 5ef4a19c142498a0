"""Analyze Pattern, Suggest Orientation and the command `analyze`, as users run them."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor import cli  # noqa: E402
from dualcolor.bridge.analysis.orientations import orientations_of  # noqa: E402
from dualcolor.bridge.analysis.overlays import analysis_of, overlays_of  # noqa: E402
from dualcolor.bridge.bed import bounds_mm  # noqa: E402
from dualcolor.bridge.properties import set_report, values_of  # noqa: E402
from dualcolor.bridge.units import use_millimeters  # noqa: E402
from dualcolor.panels.analysis import (  # noqa: E402
    DUALCOLOR_PT_analysis,
    DUALCOLOR_PT_orientation,
    analysis_figures,
)


@pytest.fixture
def cone(scene):
    """The active object: a cone that gets narrower, 8 mm high, away from the origin."""
    dualcolor.register()
    use_millimeters(scene)
    bpy.ops.mesh.primitive_cone_add(vertices=64, radius1=9, radius2=5, depth=8, location=(30, 20, 10))
    made = bpy.context.object
    made.dualcolor.pattern, made.dualcolor.sampling = "wave", "paper"
    bpy.context.view_layer.update()
    yield made
    dualcolor.unregister()


class Recorder:
    """A layout that notes what is drawn."""

    def __init__(self):
        self.texts, self.operators, self.icons = [], [], []

    def label(self, text="", icon="NONE", icon_value=0, translate=True):
        self.texts.append(text)
        self.icons.append(icon)

    def progress(self, factor, text):
        assert 0 <= factor <= 1
        self.texts.append(text)

    def prop(self, data, name, **shown):
        assert name in data.bl_rna.properties

    def operator(self, name, text="", icon="NONE"):
        self.operators.append(name)
        self.icons.append(icon)
        return SimpleNamespace()

    def row(self, **_):
        return self

    column = split = row


def drawn(panel, obj):
    """What a panel shows in a narrow sidebar."""
    layout = Recorder()
    context = SimpleNamespace(
        object=obj, region=SimpleNamespace(width=300), preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))
    )
    panel.draw(SimpleNamespace(layout=layout), context)
    icons = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
    assert set(layout.icons) <= set(icons.keys())
    return layout


def test_what_the_nodes_make_can_be_baked_below_the_warning_about_them(cone):
    from dualcolor.bridge.input.base_color import BAKE_HINT
    from dualcolor.panels.printing import DUALCOLOR_PT_results

    report = {
        "warnings": ["a", f"nodes: {BAKE_HINT}", f"others: {BAKE_HINT}"],
        "layers": 1,
        "bounds_mm": [(0,) * 3] * 2,
    }
    report |= {"settings": values_of(cone.dualcolor), "time_s": {"total": 1.0}}
    report["filament"] = {f"tool{tool}_{unit}": 1.0 for tool in (0, 1) for unit in ("mm", "g")}
    set_report(cone.dualcolor, report)
    assert drawn(DUALCOLOR_PT_results, cone).operators == ["dualcolor.bake_material"]
    set_report(cone.dualcolor, report | {"warnings": ["a"]})
    assert not drawn(DUALCOLOR_PT_results, cone).operators


def shown(collection):
    return {held.name.rsplit(".", 1)[0]: held for held in collection.objects}


def test_overlays_stand_on_the_object_and_are_replaced(cone):
    assert bpy.ops.dualcolor.analyze() == {"FINISHED"}
    collection = overlays_of(cone)
    overlays = shown(collection)
    assert {"Tracelines", "Deaths", "Seam Error from 4", "Below 20° from Flat"} <= set(overlays)
    assert bpy.context.object == cone and all(held.hide_select for held in overlays.values())
    low, high = bounds_mm([cone])
    place = np.empty(len(overlays["Tracelines"].data.points) * 3, dtype=np.float32)
    overlays["Tracelines"].data.attributes["position"].data.foreach_get("vector", place)
    world = place.reshape(-1, 3) + np.array(overlays["Tracelines"].location)
    assert (world.min(axis=0) > low - 0.3).all() and (world.max(axis=0) < high + 0.3).all()
    assert np.ptp(world[:, 2]) == pytest.approx(7.75, abs=0.01)
    overlays["Deaths"].hide_viewport = True
    before = len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.hair_curves), len(bpy.data.collections)
    assert bpy.ops.dualcolor.analyze() == {"FINISHED"}
    assert before == (
        len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.hair_curves), len(bpy.data.collections)
    )  # fmt: skip
    again = shown(overlays_of(cone))
    assert again["Deaths"].hide_viewport and not again["Tracelines"].hide_viewport


def test_what_the_user_puts_among_the_overlays_stays(cone):
    bpy.ops.dualcolor.analyze()
    held = overlays_of(cone)
    held.objects.link(lamp := bpy.data.objects.new("Lamp", None))
    texts = drawn(DUALCOLOR_PT_analysis, cone).texts
    assert "Lamp" not in texts and "Tracelines" in texts
    bpy.ops.dualcolor.analyze()
    assert overlays_of(cone) == held and lamp.name in held.objects
    assert bpy.ops.dualcolor.remove_analysis() == {"FINISHED"}
    assert overlays_of(cone) is None and held.objects[:] == [lamp]


def test_figures_match_the_report_and_go_with_the_overlays(cone):
    bpy.ops.dualcolor.analyze()
    report = analysis_of(cone)
    rows = dict(analysis_figures(report))
    assert rows["Births, Deaths"] == f"0, {report['tracelines']['deaths']}"
    texts = drawn(DUALCOLOR_PT_analysis, cone).texts
    assert {"Salient", rows["Salient"], "Tracelines", "Seam Error from 4"} <= set(texts)
    assert "Settings have changed since" not in texts
    cone.dualcolor.wavelength = 2.0
    assert "Settings have changed since" in drawn(DUALCOLOR_PT_analysis, cone).texts
    assert bpy.ops.dualcolor.remove_analysis() == {"FINISHED"}
    assert overlays_of(cone) is None and not analysis_of(cone)
    assert drawn(DUALCOLOR_PT_analysis, cone).texts == []
    assert not bpy.ops.dualcolor.remove_analysis.poll()


def test_offset_shows_slopes_only(cone):
    cone.dualcolor.pattern = "offset"
    bpy.ops.dualcolor.analyze()
    assert "Tracelines" not in shown(overlays_of(cone)) and analysis_of(cone)["warnings"]
    assert "Below 20° from Flat" in shown(overlays_of(cone))


def test_turning_stands_the_object_up_where_it_was(scene):
    dualcolor.register()
    use_millimeters(scene)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(30, 20, 5), rotation=(0.0, 0.0, 0.5))
    slab = bpy.context.object
    slab.scale = (4, 40, 30)
    bpy.context.view_layer.update()
    assert not bpy.ops.dualcolor.apply_orientation.poll()
    assert bpy.ops.dualcolor.suggest_orientation() == {"FINISHED"}
    found = orientations_of(slab)
    assert found[0]["height_mm"] == pytest.approx(4.0, abs=1e-3)
    assert drawn(DUALCOLOR_PT_orientation, slab).operators.count("dualcolor.apply_orientation") == len(found)
    low = bounds_mm([slab])[0, 2]
    assert bpy.ops.dualcolor.apply_orientation(number=0) == {"FINISHED"}
    assert np.ptp(bounds_mm([slab])[:, 2]) == pytest.approx(4.0, abs=1e-3)
    assert bounds_mm([slab])[0, 2] == pytest.approx(low, abs=1e-3)
    for number, one in enumerate(found):  # the list holds though the object has been turned
        bpy.ops.dualcolor.apply_orientation(number=number)
        assert np.ptp(bounds_mm([slab])[:, 2]) == pytest.approx(one["height_mm"], abs=1e-3)
    with pytest.raises(RuntimeError, match="only"):
        bpy.ops.dualcolor.apply_orientation(number=len(found))
    dualcolor.unregister()


@pytest.fixture
def wedge(tmp_path):
    path = tmp_path / "wedge.obj"
    corners = [(0, 0, 0), (20, 0, 0), (20, 20, 0), (0, 20, 0), (4, 4, 6), (16, 4, 6), (16, 16, 6), (4, 16, 6)]
    sides = ["1 4 3 2", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8"]
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {side}\n" for side in sides))
    return path


def test_command_writes_figures_and_pictures(wedge, tmp_path, capfd):
    names = {kind: tmp_path / f"{kind}.png" for kind in ("heatmap", "tracelines", "slopes")}
    options = [word for kind, path in names.items() for word in (f"--{kind}", str(path))]
    status = cli.main([
        "analyze", str(wedge), "--up", "z", "--preset", "paper", "--views", "front,left", "--pixels", "120",
        "--report", str(tmp_path / "r.json"), *options,
    ])  # fmt: skip
    assert status == 0
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["tracelines"]["deaths"] > 0 and report["pattern"]["probes"] > 0
    assert (
        sum(report["pattern"]["histogram"]["counts"])
        == report["pattern"]["probes"] - report["pattern"]["discarded_probes"]
    )
    assert {path.name for path in tmp_path.glob("*.png")} == {
        f"{kind}_{view}.png" for kind in names for view in ("front", "left")
    }
    assert "tracelines:" in capfd.readouterr().out


def test_command_refuses_a_heatmap_without_waves(wedge, tmp_path, capfd):
    assert cli.main(["analyze", str(wedge), "--up", "z", "--heatmap", str(tmp_path / "h.png")]) == 1
    assert "no waves" in capfd.readouterr().err and not list(tmp_path.glob("*.png"))
    assert cli.main(["analyze", str(wedge), "--up", "z"]) == 0

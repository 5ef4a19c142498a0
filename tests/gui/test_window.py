"""From the package to a painted print in a real window, by mouse and keys only.

BLENDER names the Blender, 4.5 or newer; DUALCOLOR_SCREENSHOTS a folder that keeps the pictures.
"""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shapely
from dualcolor.core.gcode.reader import read_gcode
from dualcolor.core.paths import Feature
from PIL import Image
from user import User
from window import missing

ROOT = Path(__file__).resolve().parents[2]
CAT = ROOT.parent / "shared" / "data" / "images" / "chelsea.png"
BLENDER = os.environ.get("BLENDER")
pytestmark = pytest.mark.skipif(bool(missing(BLENDER)), reason=missing(BLENDER))
STRANDS = "[held.name for held in bpy.data.collections if held.name.endswith('Dual-Color')]"
EVERYTHING = "[sorted(held.name for held in getattr(bpy.data, kind)) for kind in ('objects', 'collections', 'images')]"
RUNNING = "sys.modules[type(bpy.context.object.dualcolor).__module__.rpartition('.bridge')[0] + '.operators.job']"
RUNNING = f"{RUNNING}.JobOperator.running is not None"
PROOFED = "bpy.context.object.material_slots[0].material.name.endswith('Soft Proof')"
PIXELS = "sum(bpy.data.images['Suzanne Tone'].pixels[:])"


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    folder = tmp_path_factory.mktemp("package")
    command = [sys.executable, str(ROOT / "tools" / "package.py"), "--only-without-wheels", "--out", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    return shutil.move(next(folder.glob("*.zip")), folder / "dualcolor.zip")


@pytest.fixture
def user(tmp_path):
    made = User(BLENDER, tmp_path)
    yield made
    made.close()


VIEW = 0, 25, 1052, 722


@pytest.fixture
def shot(user, tmp_path):
    folder = Path(os.environ.get("DUALCOLOR_SCREENSHOTS", tmp_path)).resolve()
    return lambda name, box=VIEW: user.shot(folder / f"{name}.png", box, colors=48)


def generated(user: User) -> None:
    user.press("dualcolor.generate")
    user.until(RUNNING)
    user.until(f"not ({RUNNING})")


def painted(user: User, points: list[tuple[float, float]]) -> float:
    """Paint a stroke and wait until all of it is in the picture; how much darker the picture is then."""
    before = user.ask(PIXELS)
    user.drag(points)
    seen, now, end = before, user.ask(PIXELS), time.monotonic() + user.patience
    while (seen != now or now == before) and time.monotonic() < end:
        time.sleep(2.0)
        seen, now = now, user.ask(PIXELS)
    return before - now


def exported(user: User, path: Path) -> Path:
    user.press(f"dualcolor.export_{path.suffix[1:]}")
    user.choose_file(path)
    user.until(f"os.path.exists({str(path)!r})")
    return path


def brightness(user: User, place: tuple[float, float], wanted: Callable[[float], bool]) -> float:
    """Mean gray of a few pixels on the screen, once it is as wanted; shaders are compiled and drawn meanwhile."""
    x, y = map(int, place)
    end = time.monotonic() + user.patience
    while True:
        path = user.folder / "seen.png"
        user.shot(path, (x - 4, y - 4, x + 4, y + 4))
        with Image.open(path) as seen:
            gray = float(np.asarray(seen.convert("L")).mean())
        if wanted(gray):
            return gray
        assert time.monotonic() < end, f"the place on the screen is {gray:.0f}"
        time.sleep(0.5)


def set_back(plain: Path, painted: Path) -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) mm points of the white outer wall of the painted print, (N,) mm from the wall of the plain one."""
    walls = []
    for path in (plain, painted):
        moves = read_gcode(path.read_bytes(), path.stem).moves
        wall = (moves.feature == Feature.OUTER_WALL) & (moves.tool == 1) & (moves.width > 0)
        walls.append((moves.position, np.flatnonzero(wall), moves.layer))
    (before, old, old_layer), (after, new, new_layer) = walls
    lines = shapely.linestrings(np.stack([before[old - 1, :2], before[old, :2]], axis=1))
    far = np.full(len(new), np.nan)
    for layer in np.unique(new_layer[new]):
        there = new_layer[new] == layer
        all_lines = shapely.multilinestrings(lines[old_layer[old] == layer])
        far[there] = shapely.distance(shapely.points(after[new[there], :2]), all_lines)
    return after[new], far


def add_monkey(user, package):
    """Install the extension and add a monkey, 60 mm high, in its tab."""
    user.install(package)
    user.open_tab()
    user.move(*user.view())
    user.keys("a", "x", "Return")
    user.search("monkey")
    user.until("bpy.context.object is not None")
    user.press("dualcolor.scale_to_height")
    user.keys("Return")
    user.until("abs(bpy.context.object.dimensions.z - 60) < 0.1")


def test_from_the_package_to_a_painted_print(user, package, shot, tmp_path):
    add_monkey(user, package)
    user.press("dualcolor.show_bed")
    user.until("bpy.context.object.dualcolor.show_bed")
    user.press("dualcolor.check_model")
    user.until("bpy.context.object.dualcolor.findings")
    user.press("dualcolor.repair_model")
    user.until("not bpy.context.object.dualcolor.findings")

    user.press("dualcolor.unwrap_smart")
    user.until("len(bpy.context.object.data.uv_layers) == 2")
    before = user.ask(EVERYTHING)
    user.press("dualcolor.generate")
    user.until(RUNNING)
    user.keys("Escape")
    user.until(f"not ({RUNNING})")
    assert user.ask(EVERYTHING) == before and not user.ask(STRANDS)

    user.press("dualcolor.set_up_painting")
    user.until("bpy.context.object.mode == 'TEXTURE_PAINT'")
    plain = exported(user, tmp_path / "plain.gcode")
    user.press("dualcolor.show_print")
    user.until("not bpy.context.object.dualcolor.show_print")
    x, y = user.view()
    assert painted(user, [(x + step, y + 0.2 * step) for step in range(-90, 90, 8)]) > 100
    user.find("dualcolor.soft_proof")  # the panel Paint is seen
    user.move(x, y - 100)
    time.sleep(1.0)
    shot("paint")

    user.press("dualcolor.soft_proof")
    user.until(PROOFED)
    place = x, y - 60
    user.move(place[0], place[1] + 40)
    unpainted = brightness(user, place, lambda seen: seen > 130)  # behind the monkey it is darker
    assert painted(user, [(place[0] + step, place[1]) for step in range(-40, 40, 8)]) > 100
    user.move(place[0], place[1] + 40)
    brightness(user, place, lambda seen: seen < unpainted - 25)
    shot("soft_proof_stroke")
    user.press("dualcolor.soft_proof")
    user.until(f"not {PROOFED}")

    user.search("generate dual")  # in Texture Paint
    user.until("bpy.context.object.dualcolor.show_print")
    user.until(f"not ({RUNNING})")
    assert user.ask(STRANDS)
    user.find("dualcolor.generate")  # the results are seen below it
    user.move(*user.view())
    shot("strands")
    marked = exported(user, tmp_path / "painted.gcode")
    written = exported(user, tmp_path / "painted.x3g")
    assert written.stat().st_size > 100_000
    places, far = set_back(plain, marked)
    stroke = far > 0.2
    assert stroke.sum() > 20, "the stroke is not in the file"
    # Black in the picture moves the other tones a little within the printable range: 0.023 mm of set-back.
    assert stroke.mean() < 0.4 and np.median(far) < 0.05, "the wall has changed where nothing was painted"
    assert np.ptp(places[stroke], axis=0)[2] < 40


def test_select_shows_what_check_model_has_found(user, package, shot):
    add_monkey(user, package)
    user.press("dualcolor.check_model")
    user.until("bpy.context.object.dualcolor.findings")
    user.until(f"not ({RUNNING})")
    time.sleep(2.0)  # for the sidebar to be drawn
    shot("check")
    shot("sidebar", user.region("VIEW_3D", "UI"))
    user.press("dualcolor.select_finding", across=(0.95,))
    user.until("bpy.context.object.mode == 'EDIT'")
    user.until(f"not ({RUNNING})")
    user.move(*user.view())
    time.sleep(2.0)
    shot("select")
    user.keys("Tab")
    user.until("bpy.context.object.mode == 'OBJECT'")
    assert user.ask("sum(edge.select for edge in bpy.context.object.data.edges)") == 42


def test_a_colored_picture_becomes_a_plate_and_a_predicted_print(package, tmp_path):
    picture, render = tmp_path / "waves.png", tmp_path / "print.png"
    if CAT.exists():
        picture = shutil.copy(CAT, tmp_path / "cat.png")
    else:
        row, column = np.mgrid[0:128, 0:128] / 127
        colors = np.stack([0.5 + 0.5 * np.sin(6 * np.pi * column), 0.2 + 0.6 * row, 1 - column], axis=-1)
        Image.fromarray((255 * colors).astype(np.uint8)).save(picture)
    kept = Path(os.environ.get("DUALCOLOR_SCREENSHOTS", tmp_path)).resolve()
    user = User(BLENDER, tmp_path / "blender", patience=400.0)
    try:
        user.install(package)
        user.open_tab()
        user.move(*user.view())
        user.keys("a", "x", "Return")
        user.until("bpy.context.object is None")
        user.search("image plate")
        user.choose_file(picture)
        user.until("bpy.context.object is not None")
        assert user.ask("bpy.context.scene.unit_settings.length_unit") == "MILLIMETERS"
        user.press("dualcolor.gray_from_color")
        user.until("bpy.context.object.dualcolor.image is not None")
        user.shot(kept / "plate.png", VIEW, colors=48)
        generated(user)
        before = user.ask(EVERYTHING)
        rendering = "bpy.app.is_job_running('RENDER')"
        for stopped in (True, False):
            user.press("dualcolor.render_prediction")
            user.choose_file(render)
            user.until(rendering)
            time.sleep(5.0)
            assert user.ask(rendering) and user.ask(RUNNING) and not render.exists()  # it answers while it renders
            user.shot(kept / "rendering.png", (0, 0, 1280, 800), colors=48)
            if stopped:
                user.keys("Escape")
            user.until(f"not {RUNNING}")
            assert user.ask(f"not {rendering}") and user.ask("len(bpy.data.scenes)") == 1
            assert render.exists() != stopped
            if stopped:
                user.put_away("Blender Render")
        assert [sorted(set(now) - set(held)) for now, held in zip(user.ask(EVERYTHING), before, strict=True)] == [
            [], [], [render.name]
        ]  # fmt: skip
        shown = "area_of('IMAGE_EDITOR')[1].spaces.active.image.name"
        assert user.until(shown) == render.name
        user.front("Blender Render", (720, 720))
        user.move(400, 420)
        user.keys("shift+Home")  # all of the picture
        # The studio: until the window is drawn anew, the main one is seen, or what is beside the picture.
        brightness(user, (140, 95), lambda seen: seen > 120)
        user.shot(kept / "render.png", (40, 40, 760, 760), colors=32)
    finally:
        user.close()

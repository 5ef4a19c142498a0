"""A Blender in a window of its own under Xvfb, driven by mouse and keys only (xdotool)."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

WIDTH, HEIGHT = 1280, 800
PROBE = Path(__file__).with_name("probe.py")
TOOLS = ("Xvfb", "xdotool", "import")


class Window:
    """One Blender, from its start to its end."""

    def __init__(self, blender: str, folder: Path, patience: float = 90.0) -> None:
        self.folder, self.patience = folder, patience
        self._probe = folder / "probe"
        self._probe.mkdir(parents=True)
        reading, writing = os.pipe()
        self._screen = subprocess.Popen(
            ["Xvfb", "-displayfd", str(writing), "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "-nolisten", "tcp"],
            pass_fds=(writing,),
            stderr=subprocess.DEVNULL,
        )
        os.close(writing)
        with os.fdopen(reading) as told:
            self.display = f":{told.readline().strip()}"
        self._environment = os.environ | {
            "DISPLAY": self.display,
            "DUALCOLOR_PROBE": str(self._probe),
            "DUALCOLOR_SCREEN_HEIGHT": str(HEIGHT),
            "BLENDER_USER_RESOURCES": str(folder / "user"),
            "LIBGL_ALWAYS_SOFTWARE": "1",
        }
        with (folder / "blender.log").open("wb") as log:
            self._blender = subprocess.Popen(
                [blender, "--factory-startup", "--offline-mode", "--window-geometry", "0", "0", str(WIDTH), str(HEIGHT),
                 "--python", str(PROBE)],
                env=self._environment, stdout=log, stderr=log, cwd=folder,
            )  # fmt: skip
        self.ask("1")
        time.sleep(1.0)

    def close(self) -> None:
        """End both programs."""
        for started in (self._blender, self._screen):
            started.terminate()
            try:
                started.wait(10)
            except subprocess.TimeoutExpired:
                started.kill()

    def ask(self, expression: str) -> Any:
        """The value of a Python expression inside Blender."""
        (self._probe / "question.part").write_text(expression, encoding="utf-8")
        (self._probe / "question.part").rename(self._probe / "question")
        answer = self._probe / "answer"
        end = time.monotonic() + self.patience
        while not answer.exists():
            if time.monotonic() > end or self._blender.poll() is not None:
                log = (self.folder / "blender.log").read_text(errors="replace")[-2000:]
                raise TimeoutError(f"Blender does not answer {expression!r}\n{log}")
            time.sleep(0.01)
        found = json.loads(answer.read_text(encoding="utf-8"))
        answer.unlink()
        if "error" in found:
            raise RuntimeError(found["error"])
        return found["value"]

    def until(self, expression: str, seconds: float | None = None) -> Any:
        """Wait for an expression to be true, and return its value."""
        end = time.monotonic() + (seconds or self.patience)
        while not (value := self.ask(expression)):
            if time.monotonic() > end:
                self.shot(self.folder / "stuck.png")
                raise TimeoutError(f"never true: {expression} (see {self.folder / 'stuck.png'})")
            time.sleep(0.1)
        return value

    def _do(self, *words: object) -> None:
        subprocess.run(["xdotool", *map(str, words)], env=self._environment, check=True, stderr=subprocess.DEVNULL)

    def move(self, x: float, y: float) -> None:
        """Put the mouse there."""
        self._do("mousemove", int(x), int(y))

    def click(self, x: float, y: float, button: int = 1) -> None:
        """Press and release a button there."""
        self._do("mousemove", int(x), int(y), "sleep", 0.15, "mousedown", button, "sleep", 0.15, "mouseup", button,
                 "sleep", 0.2)  # fmt: skip

    def drag(self, points: list[tuple[float, float]]) -> None:
        """Move along points with the left button held."""
        first, *rest = points
        words: list[object] = ["mousemove", *map(int, first), "sleep", 0.15, "mousedown", 1, "sleep", 0.1]
        for point in rest:
            words += ["mousemove", *map(int, point), "sleep", 0.03]
        self._do(*words, "sleep", 0.1, "mouseup", 1, "sleep", 0.3)

    def keys(self, *names: str) -> None:
        """Press keys one after the other, such as shift+a."""
        for name in names:
            *held, key = name.split("+")
            for each in held:
                self._do("keydown", each, "sleep", 0.1)
            self._do("key", key, "sleep", 0.15)
            for each in held:
                self._do("keyup", each, "sleep", 0.1)
            time.sleep(0.15)

    def type(self, text: str) -> None:
        """Write a text."""
        self._do("type", "--delay", 40, text)
        time.sleep(0.5)

    def scroll(self, x: float, y: float, steps: int) -> None:
        """Turn the wheel; down if positive."""
        self.move(x, y)
        for _ in range(abs(steps)):
            self._do("click", 5 if steps > 0 else 4, "sleep", 0.05)
        time.sleep(0.3)

    def shot(self, path: Path, box: tuple[int, int, int, int] | None = None, colors: int = 64) -> None:
        """Save a picture of the screen, or of the box left, top, right, bottom, with few colors."""
        path.parent.mkdir(parents=True, exist_ok=True)
        left, top, right, bottom = box or (0, 0, WIDTH, HEIGHT)
        subprocess.run(
            ["import", "-window", "root", "-crop", f"{right - left}x{bottom - top}+{left}+{top}", "+repage",
             "+dither", "-colors", str(colors), "-define", "png:compression-level=9", f"png8:{path}"],
            env=self._environment, check=True,
        )  # fmt: skip


def missing(blender: str | None) -> str:
    """What there is not, for a test to be skipped with; empty if all is there."""
    if not blender or not shutil.which(blender):
        return "the environment variable BLENDER names no Blender with a window"
    lacking = [tool for tool in TOOLS if not shutil.which(tool)]
    return f"not installed: {', '.join(lacking)}" if lacking else ""

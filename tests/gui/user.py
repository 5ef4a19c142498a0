"""What a user does with mouse and keys: install, add, press buttons in the sidebar, paint a stroke."""

from __future__ import annotations

import time
from pathlib import Path

from window import HEIGHT, WIDTH, Window

TAB = "Dual Color"
# Probed across the sidebar's width and down it, to find what stands where: half a button's height.
STEP = 11
ACROSS = (0.2, 0.65)


class User(Window):
    """Someone in front of the window."""

    def region(self, area: str, kind: str) -> tuple[int, int, int, int]:
        """Left, top, right, bottom of a region on the screen."""
        return tuple(self.until(f"box({area!r}, {kind!r})"))

    def view(self) -> tuple[float, float]:
        """A place in the 3D view with nothing above it."""
        left, top, right, bottom = self.region("VIEW_3D", "WINDOW")
        return left + 0.4 * (right - left), (top + bottom) / 2

    def install(self, package: Path) -> None:
        """Preferences, Get Extensions, Install from Disk."""
        self.move(*self.view())
        self.keys("F4")
        self.type("p")
        self.until("area_of('PREFERENCES') is not None")
        self.front("Preferences")
        left, top, right, bottom = self.region("PREFERENCES", "UI")
        for y in range(top + 50, bottom, 2 * STEP):
            self.click((left + right) / 2, y)
            if self.ask("bpy.context.preferences.active_section") == "EXTENSIONS":
                break
        _, top, right, _ = self.region("PREFERENCES", "WINDOW")
        self.click(right - 19, top + 18)
        self.keys("Up", "Return")  # the last entry
        self.choose_file(package)
        self.until("hasattr(bpy.types, 'DUALCOLOR_PT_main')")
        self.put_away("Preferences")

    def choose_file(self, path: Path) -> None:
        """Write a path into the file browser and press its button."""
        self.until("area_of('FILE_BROWSER') is not None")
        time.sleep(0.5)
        self.front("Blender File View")
        left, top, right, bottom = self.region("FILE_BROWSER", "EXECUTE")
        chosen = "area_of('FILE_BROWSER')[1].spaces.active.params"
        field = left + 0.3 * (right - left), (top + bottom) / 2
        for _ in range(4):  # a busy machine loses keys
            if self.ask(f"{chosen}.directory.decode().rstrip('/')") != str(path.parent):
                self.move((left + right) / 2, top - 100)
                self.keys("ctrl+l", "ctrl+a")
                self.type(f"{path.parent}/")
                self.keys("Return")
                self.click(*field)  # leaves the other field
                time.sleep(0.5)
            elif self.ask(f"{chosen}.filename") != path.name:
                self.click(*field)
                self.keys("ctrl+a")
                self.type(path.name)
                self.keys("Return")
                time.sleep(0.5)
        assert self.ask(f"{chosen}.filename") == path.name
        self.click(right - 60, (top + bottom) / 2)
        self.until("area_of('FILE_BROWSER') is None")

    def open_tab(self) -> None:
        """Show the sidebar and turn to the tab."""
        self.move(*self.view())
        left, _, right, _ = self.region("VIEW_3D", "UI")
        if right - left < 10:
            self.keys("n")
            self.until("box('VIEW_3D', 'UI')[2] - box('VIEW_3D', 'UI')[0] > 100")
        _, top, right, bottom = self.region("VIEW_3D", "UI")
        for y in range(top + 20, bottom, 3 * STEP):
            if self.ask(f"tab() == {TAB!r}"):
                return
            self.click(right - 13, y)
        raise AssertionError(f"no tab {TAB}")

    def search(self, entry: str) -> None:
        """Run an entry of the 3D view's menus by F3."""
        self.move(*self.view())
        self.keys("F3")
        time.sleep(0.5)
        self.type(entry)
        time.sleep(0.5)
        self.keys("Return")

    def find(self, name: str, across: tuple[float, ...] = ACROSS) -> tuple[float, float] | None:
        """Where a button of the sidebar is, by the operator's or the property's identifier, scrolling if need be.

        `across` are the places in the sidebar's width, from 0 to 1, where buttons are looked for.
        """
        for patience in (0.12, 0.3):
            self.scroll(*self._in_sidebar(0.5, 0.5), -30)
            seen = None
            while seen != (found := self._buttons(name, patience, across)):
                if name in found:
                    return found[name]
                seen = found
                self.scroll(*self._in_sidebar(0.5, 0.5), 8)
        return None

    def _buttons(self, wanted: str, patience: float, across: tuple[float, ...]) -> dict[str, tuple[float, float]]:
        """What is seen of the sidebar without scrolling, until the wanted one comes."""
        left, top, right, bottom = self.region("VIEW_3D", "UI")
        found: dict[str, tuple[float, float]] = {}
        for y in range(top + 80, bottom, STEP):
            for share in across:
                place = left + share * (right - left - 30), y
                self.move(*place)
                time.sleep(patience)
                if name := self.ask("button()"):
                    found.setdefault(name, place)
                if name == wanted:
                    return found
        return found

    def press(self, name: str, across: tuple[float, ...] = ACROSS) -> None:
        """Click a button of the sidebar."""
        place = self.find(name, across)
        if place is None:
            self.shot(self.folder / "stuck.png")
            raise AssertionError(f"no button {name} in the sidebar (see {self.folder / 'stuck.png'})")
        self.click(*place)

    def _in_sidebar(self, across: float, down: float) -> tuple[float, float]:
        left, top, right, bottom = self.region("VIEW_3D", "UI")
        return left + across * (right - left), top + down * (bottom - top)

    def front(self, title: str, size: tuple[int, int] | None = None) -> None:
        """Move a window to where all of it is seen; without a window manager it opens half above the screen."""
        sized = ("windowsize", "%1", *size) if size else ()
        self._do("search", "--sync", "--onlyvisible", "--name", title, *sized, "windowmove", "%1", 40, 40,
                 "windowraise", "%1", "sleep", 0.5)  # fmt: skip

    def put_away(self, title: str) -> None:
        """Move a window out of the way; there is no window manager that could close it."""
        self._do("search", "--onlyvisible", "--name", title, "windowmove", WIDTH - 1, HEIGHT - 1, "sleep", 0.5)

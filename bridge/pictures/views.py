"""Picture files of the predicted print from several sides."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from io import BytesIO
from pathlib import Path

import bpy

from ...core.errors import OutputError
from ...core.files import write_file
from ...core.model import SurfaceModel
from ...core.pictures.viewing import (
    DISTANCES_MM,
    TURNTABLE,
    USUAL_VIEW,
    VIEWS,
    Picture,
    PictureOptions,
    contact_sheet,
    png,
    seen_from,
)
from ...core.progress import Progress, translated
from .render import Photographer, photographer

TURNTABLE_FRAMES = 24
_TURNTABLE_PIXELS = 480
_FRAME_MS = 100
_SHEET_DISTANCE = "desk"


def picture_steps(
    collection: bpy.types.Collection,
    files: Mapping[str, Path],
    options: PictureOptions,
    sheet: Path | None = None,
    model: SurfaceModel | None = None,
    background: float = 0.5,
    in_window: bool = False,
) -> Generator[Progress, None, None]:
    """Render a preview from several sides into PNG files, or as it turns into an animated GIF.

    Args:
        collection: made by `build_preview`.
        files: the file of each view, a key of `VIEWS` or `TURNTABLE`.
        options: how.
        sheet: PNG file for a contact sheet: the model with its own tones (if it is given), the predicted print, and the
            print from `options.distance` or from a desk; a row for each view that is not the turntable.
        model: what the print was made from.
        background: tone where nothing is painted on the model.
        in_window: see `photographer`; yields the share done and the view to come, again and again while it waits.

    Raises:
        PrintError: there are no strands to show.
        OutputError: a file cannot be written.
        RenderStoppedError: by the user.
    """
    for path in [*files.values(), *([sheet] if sheet else [])]:
        if not path.absolute().parent.is_dir():
            raise OutputError(f"{path} cannot be written, its folder does not exist", "choose another path")
    still = [view for view in files if view != TURNTABLE] or ([USUAL_VIEW] if sheet else [])
    rows = []
    shown = model if sheet else None
    if still:
        with photographer(
            collection, options.resolution, options.samples, options.whole_plate, shown, background, in_window
        ) as camera:
            for number, view in enumerate(still):
                step = number / len(files or still), f"rendering, {view}"
                yield step
                taken = _take(camera, view, files.get(view), options, sheet is not None, shown is not None)
                rows.append((yield from translated(taken, lambda _, step=step: step)))
    if sheet:
        write_file(sheet, png(contact_sheet(rows, _labels(options, shown is not None))))
    if TURNTABLE in files:
        yield from _turn(collection, files[TURNTABLE], options, (len(files) - 1) / len(files), in_window)


def _take(
    camera: Photographer, view: str, path: Path | None, options: PictureOptions, for_sheet: bool, with_model: bool
) -> Generator[None, None, list[Picture]]:
    """Write one view, and return its row of the contact sheet."""
    azimuth, elevation = VIEWS[view]
    azimuth += options.azimuth_deg
    near = yield from camera.picture(azimuth, elevation)
    if path:
        write_file(path, png(_from_distance(near, camera.mm_per_pixel, options.distance)))
    if not for_sheet:
        return []
    far = _from_distance(near, camera.mm_per_pixel, options.distance or _SHEET_DISTANCE)
    with_tones = [(yield from camera.picture(azimuth, elevation, painted=True))] if with_model else []
    return [*with_tones, near, far]


def _turn(
    collection: bpy.types.Collection, path: Path, options: PictureOptions, done: float, in_window: bool
) -> Generator[Progress, None, None]:
    """Write the turntable, the last of the files, when a share of them is done."""
    from PIL import Image

    shrink = min(1.0, _TURNTABLE_PIXELS / max(options.resolution))
    width, height = (max(round(pixels * shrink), 1) for pixels in options.resolution)
    frames = []
    size, plate = (width, height), options.whole_plate
    with photographer(collection, size, options.samples, plate, in_window=in_window) as camera:
        for number in range(TURNTABLE_FRAMES):
            turn = number / TURNTABLE_FRAMES
            step = done + (1 - done) * turn, f"rendering, turntable {number + 1}/{TURNTABLE_FRAMES}"
            yield step
            taken = camera.picture(options.azimuth_deg + 360.0 * turn, VIEWS["front"][1], steady=True)
            seen = yield from translated(taken, lambda _, step=step: step)
            frames.append(Image.fromarray(_from_distance(seen, camera.mm_per_pixel, options.distance)))
    animation = BytesIO()
    frames[0].save(animation, "GIF", save_all=True, append_images=frames[1:], duration=_FRAME_MS, loop=0)
    write_file(path, animation.getvalue())


def _from_distance(picture: Picture, mm_per_pixel: float, distance: str) -> Picture:
    return seen_from(picture, mm_per_pixel, DISTANCES_MM[distance]) if distance else picture


def _labels(options: PictureOptions, with_model: bool) -> list[str]:
    name = options.distance or _SHEET_DISTANCE
    far = DISTANCES_MM[name]
    seen = f"predicted print from {far:.0f} mm ({name})"
    return [*(["texture on the model"] if with_model else []), "predicted print", seen]

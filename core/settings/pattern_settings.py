"""The settings that decide how the picture is printed: pattern, texture and calibration."""

from __future__ import annotations

from functools import partial

from ..errors import SettingsError
from ..records import dataclass
from .declared import Declared, setting

_pattern = partial(setting, group="pattern")
_texture = partial(setting, group="texture")


@dataclass(frozen=True)
class PatternSettings(Declared):
    """How tones become shape.

    Raises:
        SettingsError: see `PrintSettings`.
    """

    # Pattern
    pattern: str = _pattern(
        "offset",
        "How tone is made: waves only (the paper), waves and setting the line back, or setting back alone",
        choices=("wave", "wave_offset", "offset"),
    )
    wavelength: float = _pattern(
        1.2, "Least spacing of the waves along the outline; the greatest is twice this", "mm", 0.4, 10
    )
    wave_depth_max: float = _pattern(0.75, "Depth of an unattenuated wave, peak to peak", "mm", 0.0, 3.0)
    wave_depth_min: float = _pattern(0.375, "Depth of a fully attenuated wave, peak to peak", "mm", 0.0, 3.0)
    offset_max: float = _pattern(0.35, "How far the line of a fully attenuated color is set back", "mm", 0.0, 2.0)
    offset_onset: float = _pattern(
        0.0, "Attenuation at which the line begins to be set back; below it only the wave gets shallower", "", 0.0, 0.95
    )
    max_unsupported: float = _pattern(
        0.3, "How far the middle of a strand may lie outside the strand below, by wave, set-back and slope together",
        "mm", 0.0, 3.0,
    )  # fmt: skip
    sampling: str = _pattern(
        "optimized",
        "Where the waves sit: planned for all layers at once for the fewest seams, or layer by layer (the paper)",
        choices=("optimized", "paper"),
    )
    projection_threshold: float = _pattern(
        0.6, "A sample farther than this from the next layer's outline is not carried on", "mm", 0.05, 5.0
    )
    relaxation: float = _pattern(
        0.05, "Share of the way to the middle of its neighbors that a sample moves", "", 0.0, 0.5
    )
    flat_layers: int = _pattern(0, "Layers at the bottom that are printed without a wave", "", 0, 1000)
    phase_shift_layers: int = _pattern(
        0,
        "Instead of the checkerboard, shift white waves against the black ones, by another eighth of a wave each time "
        "this many layers are printed; 0 is the checkerboard",
        "", 0, 1000,
    )  # fmt: skip
    mostly_white_below: int = _pattern(0, "Below this layer three of four layers are white; 0 is none", "", 0, 10000)
    mostly_black_above: int = _pattern(0, "From this layer on three of four layers are black; 0 is none", "", 0, 10000)
    chord_tolerance: float = _pattern(
        0.01, "Greatest distance between the printed polyline and the true wave", "mm", 0.001, 0.1
    )
    front: bool = _pattern(False, "Put the waves' seams on the side away from the front, as far as possible")
    front_angle: float = _pattern(
        0.0, "Direction of the front about the vertical axis: 0 is -Y, 90 is +X", "°", -180.0, 360.0
    )
    seam_visibility: str = _pattern(
        "",
        "Vertex group, image or image file that says where seams are visible: 1 or white fully, 0 or black not at all",
    )
    hide_seams: bool = _pattern(False, "Put seams into creases and where the picture is black, white or nearly so")
    solid_regions: str = _pattern(
        "none",
        "How large regions of pure black or white print: like all other tones, with the other color's line hidden "
        "behind, or by their own tool within the layer",
        choices=("none", "set_back", "tool_change"),
    )
    solid_region_area: float = _pattern(
        25.0, "Least area of a region of pure black or white that counts as one, in mm²", "", 1.0, 10000.0
    )
    solid_region_tolerance: float = _pattern(
        0.02, "How far from black (0) or white (1) a tone may be to count as pure", "", 0.0, 0.4
    )
    solid_set_back: float = _pattern(
        0.5, "How far the other color's line is set back in such a region, as far as max_unsupported allows", "mm",
        0.0, 2.0,
    )  # fmt: skip

    # Texture
    background_tone: float = _texture(
        0.5, "Tone where nothing is painted: 0 is the black filament, 1 the white one", "", 0.0, 1.0
    )
    texture_filter: str = _texture(
        "trilinear",
        "How a texture finer than the print is averaged: mip maps, or a Lanczos reduction to one texel per layer pair",
        choices=("trilinear", "lanczos"),
    )

    # Tone calibration
    calibration: str = _texture(
        "slope_aware",
        "Correct the tones so that the print shows the painted ones: by the response of an upright wall, of the wall's "
        "own slope, by a tone table of your own, or not at all",
        choices=("none", "upright", "slope_aware", "file"),
    )
    calibration_file: str = _texture("", "The tone table for calibration = file, made by build-table")
    gamut_mapping: str = _texture(
        "compress",
        "Tones out of reach: compress the picture's range to the printable one, or clip the tones beyond it",
        choices=("clip", "compress"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.wave_depth_min > self.wave_depth_max:
            raise SettingsError("wave_depth_min is greater than wave_depth_max", "make the minimum the smaller one")

    @property
    def wave_crest(self) -> float:
        """How far waves stand out of the outline at most, mm."""
        return 0.0 if self.pattern == "offset" else self.wave_depth_max / 2

"""Which settings do something beside the others as they are; the rest are drawn gray, as everywhere in Blender."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_WAVES = ("wave_depth_max", "wave_depth_min", "phase_shift_layers", "flat_layers", "sampling", "front", "front_angle",
          "seam_visibility", "hide_seams", "projection_threshold", "relaxation")  # fmt: skip
_SUPPORTS = ("support_auto", "support_from", "support_threshold_angle", "dont_support_bridges", "support_spacing",
             "support_xy_distance", "support_z_distance", "support_interface_layers", "support_interface_spacing",
             "support_speed")  # fmt: skip
_TOWER = ("tower_placement", "tower_x", "tower_y", "tower_rotation", "tower_distance", "tower_brim_width",
          "purge_volume", "tower_speed")  # fmt: skip

_NEEDS: tuple[tuple[Callable[[Any], bool], tuple[str, ...]], ...] = (
    (lambda chosen: chosen.pattern != "offset", _WAVES),
    (lambda chosen: chosen.pattern != "wave", ("offset_max", "offset_onset")),
    (lambda chosen: chosen.sampling == "paper", ("relaxation",)),
    (lambda chosen: chosen.front, ("front_angle",)),
    (lambda chosen: chosen.solid_regions != "none", ("solid_region_area", "solid_region_tolerance")),
    (lambda chosen: chosen.solid_regions == "set_back", ("solid_set_back",)),
    (lambda chosen: chosen.calibration == "file", ("calibration_file",)),
    (lambda chosen: chosen.calibration != "none", ("gamut_mapping",)),
    (lambda chosen: chosen.arrange, ("arrange_distance",)),
    (lambda chosen: chosen.infill_density > 0, ("infill_speed",)),
    (lambda chosen: 0 < chosen.infill_density < 100, ("infill_pattern", "solid_infill_below_area")),
    (lambda chosen: chosen.support_enable, _SUPPORTS),
    (lambda chosen: chosen.support_auto, ("support_threshold_angle", "dont_support_bridges")),
    (lambda chosen: chosen.support_interface_layers > 0, ("support_interface_spacing",)),
    (lambda chosen: chosen.brim_width > 0, ("brim_separation",)),
    (lambda chosen: chosen.raft_layers > 0, ("raft_margin", "raft_gap")),
    (lambda chosen: chosen.raft_layers == 0, ("elephant_foot_compensation",)),
    (lambda chosen: chosen.skirts > 0, ("skirt_distance",)),
    (lambda chosen: chosen.tower_type != "none", _TOWER),
    (lambda chosen: chosen.tower_placement == "manual", ("tower_x", "tower_y")),
    (lambda chosen: chosen.tower_placement == "auto", ("tower_distance",)),
    (lambda chosen: chosen.ooze_shield, ("ooze_shield_distance",)),
    (lambda chosen: chosen.standby_temperature_delta > 0, ("preheat_time",)),
    (lambda chosen: chosen.slowdown_below_layer_time > 0, ("min_print_speed",)),
    (lambda chosen: max(chosen.fan_speed, chosen.bridge_fan_speed) > 0, ("disable_fan_first_layers",)),
)
"""What has to hold for settings to do something; all of it for those that are named several times."""


def in_use(settings: Any, name: str) -> bool:
    """Whether a setting, of an object or of `PrintSettings`, does something beside the others."""
    return all(holds(settings) for holds, names in _NEEDS if name in names)

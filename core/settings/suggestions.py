"""Suggestions for the name of an unknown setting."""

from __future__ import annotations

from collections.abc import Iterable

# Names in PrusaSlicer and Cura that differ too much from ours to be found by similarity.
_ELSEWHERE = {
    "adhesion_type": "brim_width",
    "bed_temperature_layer_0": "first_layer_bed_temperature",
    "bottom_layers": "bottom_solid_layers",
    "brim_gap": "brim_separation",
    "cool_min_layer_time": "slowdown_below_layer_time",
    "draft_shield_enabled": "ooze_shield",
    "external_perimeter_speed": "wave_speed",
    "external_perimeters_first": "outer_wall_first",
    "idle_temperature": "standby_temperature_delta",
    "infill_line_distance": "infill_density",
    "infill_line_width": "extrusion_width",
    "inset_direction": "outer_wall_first",
    "line_width": "extrusion_width",
    "material_bed_temperature_layer_0": "first_layer_bed_temperature",
    "material_flow": "extrusion_multiplier_0",
    "material_print_temperature": "nozzle_temperature_0",
    "material_print_temperature_layer_0": "first_layer_temperature_0",
    "min_infill_area": "solid_infill_below_area",
    "nozzle_diameter": "extrusion_width",
    "perimeter_speed": "outline_speed",
    "prime_tower_enable": "tower_type",
    "prime_tower_min_volume": "purge_volume",
    "raft": "raft_layers",
    "raft_contact_distance": "raft_gap",
    "retract_lift": "z_hop",
    "retraction_amount": "retract_length",
    "retraction_combing": "avoid_crossing_perimeters",
    "retraction_hop": "z_hop",
    "skirt_line_count": "skirts",
    "solid_infill_speed": "skin_speed",
    "speed_infill": "infill_speed",
    "speed_layer_0": "first_layer_speed",
    "speed_print": "outline_speed",
    "speed_support": "support_speed",
    "speed_topbottom": "skin_speed",
    "speed_travel": "travel_speed",
    "speed_wall_0": "wave_speed",
    "support_angle": "support_threshold_angle",
    "support_infill_rate": "support_spacing",
    "support_material": "support_enable",
    "support_material_buildplate_only": "support_from",
    "support_material_threshold": "support_threshold_angle",
    "support_material_xy_spacing": "support_xy_distance",
    "support_type": "support_from",
    "switch_extruder_retraction_amount": "retract_length_toolchange",
    "temperature": "nozzle_temperature_0",
    "top_layers": "top_solid_layers",
    "wall_line_count": "perimeters",
    "wipe_tower": "tower_type",
    "xy_offset_layer_0": "elephant_foot_compensation",
    "z_seam_type": "seam_position",
}


def hint_for(name: str, known: Iterable[str]) -> str:
    """One sentence that helps to find the right name.

    Args:
        name: that was given.
        known: the names that there are.
    """
    from difflib import get_close_matches

    plain = name.lower().strip().replace("-", "_").replace(" ", "_")[:60]
    meant = [_ELSEWHERE[plain]] if plain in _ELSEWHERE else get_close_matches(plain, list(known), 3)
    everything = "docs/settings.md lists them all"
    return f"did you mean {' or '.join(meant)}? {everything}" if meant else everything

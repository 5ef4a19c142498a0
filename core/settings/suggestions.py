"""Suggestions for the name of an unknown setting."""

from __future__ import annotations

from collections.abc import Iterable

# Names in PrusaSlicer and Cura that differ too much from ours to be found by similarity.
_ELSEWHERE = {
    "adhesion_type": "brim_width",
    "bottom_layers": "bottom_solid_layers",
    "external_perimeter_speed": "wave_speed",
    "infill_line_distance": "infill_density",
    "line_width": "extrusion_width",
    "material_bed_temperature_layer_0": "first_layer_bed_temperature",
    "material_flow": "extrusion_multiplier_0",
    "material_print_temperature": "nozzle_temperature_0",
    "material_print_temperature_layer_0": "first_layer_temperature_0",
    "min_infill_area": "solid_infill_below_area",
    "nozzle_diameter": "extrusion_width",
    "perimeter_speed": "outline_speed",
    "prime_tower_enable": "tower_type",
    "raft": "raft_layers",
    "retract_lift": "z_hop",
    "retraction_amount": "retract_length",
    "skirt_line_count": "skirts",
    "speed_print": "outline_speed",
    "speed_travel": "travel_speed",
    "speed_wall_0": "wave_speed",
    "support_angle": "support_threshold_angle",
    "support_material": "support_enable",
    "support_material_threshold": "support_threshold_angle",
    "temperature": "nozzle_temperature_0",
    "top_layers": "top_solid_layers",
    "wall_line_count": "perimeters",
    "wipe_tower": "tower_type",
    "xy_offset_layer_0": "elephant_foot_compensation",
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

"""Which settings are shown in which panel of the sidebar, in their order; every setting in exactly one."""

from __future__ import annotations

from ..core.records import dataclass


@dataclass(frozen=True)
class Section:
    """A panel of the sidebar that holds settings.

    Attributes:
        key: part of the panel's identifier.
        title: the heading.
        settings: names of the settings, from the top.
        stage: key of the stage that it folds away under; empty for what a stage itself shows.
        switch: a setting shown in the heading, since without it the others do nothing.
    """

    key: str
    title: str
    settings: tuple[str, ...]
    stage: str = ""
    switch: str = ""


PAINT = Section("paint", "Paint", ("background_tone",))
PATTERN = Section("pattern", "Pattern", ("pattern", "wavelength", "wave_depth_max", "wave_depth_min", "offset_max"))
PRINT = Section(
    "print",
    "Print",
    ("layer_height", "extrusion_width", "perimeters", "infill_density", "bottom_solid_layers", "top_solid_layers"),
)
CALIBRATE = Section("calibrate", "Calibrate", ("calibration", "calibration_file", "gamut_mapping"))
STAGES = (PAINT, PATTERN, PRINT, CALIBRATE)

PREPARE_ADVANCED = Section(
    "placing",
    "Advanced",
    ("center_on_bed", "arrange", "arrange_distance", "gap_closing_radius"),
    stage="prepare",
)
PAINT_ADVANCED = Section(
    "texture",
    "Advanced",
    ("texture_filter",),
    stage="paint",
)
PATTERN_ADVANCED = Section(
    "pattern_detail",
    "Advanced",
    (
        "offset_onset",
        "max_unsupported",
        "flat_layers",
        "phase_shift_layers",
        "mostly_white_below",
        "mostly_black_above",
        "sampling",
        "front",
        "front_angle",
        "seam_visibility",
        "hide_seams",
        "projection_threshold",
        "relaxation",
        "chord_tolerance",
        "solid_regions",
        "solid_region_area",
        "solid_region_tolerance",
        "solid_set_back",
    ),
    stage="pattern",
)
PREDICT_ADVANCED = Section("prediction", "Advanced", ("sag",), stage="predict")
PRINT_DETAILS = (
    Section(
        "supports",
        "Supports",
        (
            "support_auto",
            "support_from",
            "support_threshold_angle",
            "dont_support_bridges",
            "support_spacing",
            "support_xy_distance",
            "support_z_distance",
            "support_interface_layers",
            "support_interface_spacing",
        ),
        stage="print",
        switch="support_enable",
    ),
    Section(
        "adhesion",
        "Brim, Raft and Skirt",
        (
            "brim_width",
            "brim_separation",
            "raft_layers",
            "raft_margin",
            "raft_gap",
            "skirts",
            "skirt_distance",
            "first_layer_height",
            "first_layer_extrusion_width",
            "elephant_foot_compensation",
        ),
        stage="print",
    ),
    Section(
        "tower",
        "Cleaning Tower and Ooze",
        (
            "tower_type",
            "tower_placement",
            "tower_x",
            "tower_y",
            "tower_rotation",
            "tower_distance",
            "tower_brim_width",
            "purge_volume",
            "ooze_shield",
            "ooze_shield_distance",
        ),
        stage="print",
    ),
    Section(
        "detail",
        "Walls and Fill",
        (
            "outer_wall_first",
            "seam_position",
            "infill_pattern",
            "infill_angle",
            "infill_overlap",
            "solid_infill_below_area",
        ),
        stage="print",
    ),
    Section(
        "speed",
        "Speed",
        (
            "wave_speed",
            "outline_speed",
            "skin_speed",
            "bridge_speed",
            "overhang_speed",
            "infill_speed",
            "tower_speed",
            "support_speed",
            "first_layer_speed",
            "travel_speed",
            "max_curve_acceleration",
            "min_move_time",
            "max_volumetric_speed",
        ),
        stage="print",
    ),
    Section(
        "extrusion",
        "Extrusion and Retraction",
        (
            "bridge_flow",
            "retract_length",
            "retract_length_toolchange",
            "retract_restart_extra",
            "retract_restart_extra_toolchange",
            "retract_speed",
            "deretract_speed",
            "retract_before_travel",
            "avoid_crossing_perimeters",
            "only_retract_when_crossing_perimeters",
            "wipe",
            "z_hop",
            "z_hop_toolchange",
        ),
        stage="print",
    ),
    Section(
        "filament",
        "Printer and Filament",
        (
            "printer",
            "black_tool",
            "filament_diameter_0",
            "filament_diameter_1",
            "extrusion_multiplier_0",
            "extrusion_multiplier_1",
            "filament_density",
            "filament_cost",
        ),
        stage="print",
    ),
    Section(
        "temperature",
        "Temperature and Cooling",
        (
            "nozzle_temperature_0",
            "nozzle_temperature_1",
            "first_layer_temperature_0",
            "first_layer_temperature_1",
            "standby_temperature_delta",
            "preheat_time",
            "bed_temperature",
            "first_layer_bed_temperature",
            "fan_speed",
            "bridge_fan_speed",
            "disable_fan_first_layers",
            "slowdown_below_layer_time",
            "min_print_speed",
        ),
        stage="print",
    ),
)
FOLDED = (PREPARE_ADVANCED, PAINT_ADVANCED, PATTERN_ADVANCED, *PRINT_DETAILS, PREDICT_ADVANCED)
SECTIONS = (*STAGES, *FOLDED)

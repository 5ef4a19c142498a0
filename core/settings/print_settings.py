"""Every setting of a print, its default, unit and limits; those of the pattern stand in `pattern_settings.py`.

The sidebar's properties, the command line and the header of the G-code are all made from `PrintSettings`.
"""

from __future__ import annotations

import math
from functools import partial

from ..records import dataclass
from .declared import setting
from .pattern_settings import PatternSettings
from .printer import PrinterProfile, printer_names, printer_profile

# Groups beside `print`; they decide which settings a preset of each kind holds (`presets.KINDS`).
_printer = partial(setting, group="printer")
_filament = partial(setting, group="filament")
_preview = partial(setting, group="preview")


@dataclass(frozen=True)
class PrintSettings(PatternSettings):
    """What to print and how; immutable, validated when made. Lengths are mm, temperatures °C, angles degrees.

    Raises:
        SettingsError: a value of the wrong type, not finite, out of its limits, or at odds with another one.
    """

    # Printer
    printer: str = _printer(
        "replicator_2x", "The printer: its reach, limits, motors, start and end", choices=printer_names()
    )

    # Slicing
    layer_height: float = setting(0.25, "Height of every layer above the first", "mm", 0.05, 0.5)
    first_layer_height: float = setting(0.25, "Height of the first layer", "mm", 0.05, 0.5)
    center_on_bed: bool = setting(True, "Move the object to the middle of the bed, its lowest point on the bed")
    arrange: bool = setting(False, "Put several objects side by side on the bed; else they keep their places")
    arrange_distance: float = setting(5.0, "Least distance of objects that are put side by side", "mm", 0.5, 100.0)
    gap_closing_radius: float = setting(0.05, "Gaps in an outline up to twice this are closed", "mm", 0.0, 2.0)

    # Walls and fill
    extrusion_width: float = setting(0.4, "Width of an extruded line", "mm", 0.2, 1.2)
    first_layer_extrusion_width: float = setting(0.4, "Width of the first layer's lines, on the bed", "mm", 0.2, 1.2)
    perimeters: int = setting(1, "Straight walls behind the waved outline", "", 0, 20)
    bottom_solid_layers: int = setting(3, "Solid layers at the bottom", "", 0, 100)
    top_solid_layers: int = setting(3, "Solid layers at the top", "", 0, 100)
    infill_density: float = setting(10.0, "Share of the inside that is filled", "%", 0.0, 100.0)
    infill_pattern: str = setting(
        "rectilinear",
        "Lines of sparse fill: in one direction per layer, two or three, a gyroid, or loops that follow the walls",
        choices=("rectilinear", "grid", "triangles", "gyroid", "concentric"),
    )
    solid_infill_below_area: float = setting(
        10.0, "Sparse fill of a smaller area than this, in mm², is solid; 0 leaves all of it sparse", "", 0.0, 10000.0
    )
    infill_angle: float = setting(
        45.0, "Direction of the fill; it alternates between + and - this angle", "°", 0.0, 90.0
    )
    infill_overlap: float = setting(
        15.0, "How far the fill reaches into the wall, in % of the line width", "%", 0.0, 50.0
    )

    # Order
    outer_wall_first: bool = setting(False, "Print the waved outline before the walls behind it")
    seam_position: str = setting(
        "rear", "Where outlines start and end", choices=("aligned", "rear", "nearest", "valley")
    )

    # Adhesion and tower
    elephant_foot_compensation: float = setting(
        0.0,
        "How far the first layer's outline is moved inwards where its lines are squashed wider on the bed; not on a "
        "raft, nor where the object is thinner than two lines",
        "mm", 0.0, 1.0,
    )  # fmt: skip
    brim_width: float = setting(0.0, "Width of the brim around the first layer; 0 is none", "mm", 0.0, 50.0)
    brim_separation: float = setting(0.0, "Air between the brim and what it surrounds", "mm", 0.0, 2.0)
    raft_layers: int = setting(0, "Layers of the raft below the object; 0 is none", "", 0, 20)
    raft_margin: float = setting(4.0, "How far the raft reaches beyond the first layer", "mm", 0.0, 20.0)
    raft_gap: float = setting(0.2, "Air between the raft and the object", "mm", 0.0, 1.0)
    skirts: int = setting(1, "Loops of the skirt around the first layer", "", 0, 10)
    skirt_distance: float = setting(6.0, "Distance of the skirt from the object", "mm", 1.0, 50.0)
    tower_type: str = setting("w", "Cleaning tower that primes a nozzle after each tool change", choices=("w", "none"))
    tower_placement: str = setting(
        "auto",
        "Where the tower stands: in free space near the object, or at tower_x, tower_y",
        choices=("auto", "manual"),
    )
    tower_x: float = setting(60.0, "X of the tower's middle when it is placed by hand", "mm", -150.0, 150.0)
    tower_y: float = setting(0.0, "Y of the tower's middle when it is placed by hand", "mm", -150.0, 150.0)
    tower_rotation: float = setting(
        0.0, "Direction of the tower's W; automatic placement also tries it across", "°", -180.0, 180.0
    )
    tower_distance: float = setting(
        4.0, "Least distance of the tower and its brim from all else, when it is placed automatically", "mm", 1.0, 100.0
    )
    tower_brim_width: float = setting(3.0, "Width of the tower's own brim on the first layer", "mm", 0.0, 20.0)
    purge_volume: float = setting(6.0, "Least plastic that goes into each layer of the tower", "mm3", 0.5, 100.0)
    ooze_shield: bool = setting(False, "Print a thin wall around the object that catches what the idle nozzle drips")
    ooze_shield_distance: float = setting(2.0, "Distance of the ooze shield from the object", "mm", 0.5, 20.0)

    # Supports
    support_enable: bool = setting(False, "Print supports under overhangs, each layer's in its own color")
    support_auto: bool = setting(
        True, "Support all overhangs flatter than the threshold angle; else only where supports are enforced"
    )
    support_from: str = setting(
        "everywhere", "Where supports may stand: on the bed only, or on the object too", choices=("bed", "everywhere")
    )
    support_threshold_angle: float = setting(
        30.0, "Overhangs flatter than this, from the horizontal, are supported", "°", 5.0, 85.0
    )
    dont_support_bridges: bool = setting(
        False, "No supports under bridges, which solid fill spans from side to side, unless they are enforced"
    )
    support_spacing: float = setting(2.5, "Distance of the lines of supports", "mm", 0.4, 20.0)
    support_xy_distance: float = setting(
        0.4, "Air between supports and the crests of the waved outline", "mm", 0.0, 10.0
    )
    support_z_distance: float = setting(
        0.25,
        "Air between supports and the object above and below, in whole layers, at least one unless it is 0",
        "mm",
        0.0,
        5.0,
    )
    support_interface_layers: int = setting(2, "Dense layers of supports right under the object", "", 0, 20)
    support_interface_spacing: float = setting(0.8, "Distance of the lines in the dense layers", "mm", 0.2, 10.0)

    # Speed
    outline_speed: float = setting(40.0, "Speed of walls", "mm/s", 1.0, 300.0)
    wave_speed: float = setting(30.0, "Speed of the waved outline along its path", "mm/s", 1.0, 300.0)
    skin_speed: float = setting(60.0, "Speed of solid top and bottom fill", "mm/s", 1.0, 300.0)
    overhang_speed: float = setting(
        15.0, "Greatest speed where walls hang over air; 0 does not slow them", "mm/s", 0.0, 300.0
    )
    bridge_speed: float = setting(40.0, "Speed of solid fill over air", "mm/s", 1.0, 300.0)
    infill_speed: float = setting(80.0, "Speed of sparse fill", "mm/s", 1.0, 300.0)
    tower_speed: float = setting(80.0, "Speed of the cleaning tower", "mm/s", 1.0, 300.0)
    support_speed: float = setting(60.0, "Speed of supports", "mm/s", 1.0, 300.0)
    first_layer_speed: float = setting(30.0, "Greatest extruding speed on the first layer", "mm/s", 1.0, 300.0)
    travel_speed: float = setting(150.0, "Speed of moves that do not extrude", "mm/s", 1.0, 300.0)
    max_curve_acceleration: float = setting(
        1000.0, "Greatest sideways acceleration in curves; more is faster and shakes more", "mm/s2", 100.0, 20000.0
    )
    min_move_time: float = setting(
        8.0, "Curves of shorter moves are printed more slowly, so that the printer's queue does not run dry", "ms",
        0.0, 50.0,
    )  # fmt: skip
    max_volumetric_speed: float = setting(8.0, "Most plastic melted per second; 0 is no limit", "mm3/s", 0.0, 50.0)

    # Extrusion and retraction
    bridge_flow: float = setting(1.0, "Factor on the amount extruded for solid fill and walls over air", "", 0.3, 2.0)
    retract_length: float = setting(1.3, "Filament pulled back before a travel", "mm", 0.0, 10.0)
    retract_length_toolchange: float = setting(4.0, "Filament pulled back before a tool change", "mm", 0.0, 20.0)
    retract_restart_extra: float = setting(0.0, "Filament fed in addition after a travel", "mm", 0.0, 2.0)
    retract_restart_extra_toolchange: float = setting(
        0.0, "Filament fed in addition after a tool change", "mm", 0.0, 5.0
    )
    retract_speed: float = setting(
        25.0, "Speed of pulling back; no more than the printer's filament drive does", "mm/s", 1.0, 200.0
    )
    deretract_speed: float = setting(
        25.0, "Speed of feeding retracted filament again; no more than the printer's filament drive does", "mm/s",
        1.0, 200.0,
    )  # fmt: skip
    avoid_crossing_perimeters: bool = setting(
        True, "Travels stay inside the outer wall where they can, along it rather than across it"
    )
    only_retract_when_crossing_perimeters: bool = setting(
        True, "No retraction on travels inside the outer wall that the next layer covers"
    )
    retract_before_travel: float = setting(1.5, "Shorter travels do not retract", "mm", 0.0, 50.0)
    wipe: float = setting(
        0.0, "Distance to move back over the line just printed while retracting; 0 wipes on the tower only", "mm",
        0.0, 10.0,
    )  # fmt: skip
    z_hop: float = setting(0.0, "Lift on travels with retraction", "mm", 0.0, 5.0)
    z_hop_toolchange: float = setting(0.4, "Lift at a tool change", "mm", 0.0, 5.0)

    # Filament and temperature (tool 0, right nozzle: black; tool 1, left nozzle: white)
    black_tool: int = _filament(0, "Tool with the black filament: 0 is the right nozzle, 1 the left", "", 0, 1)
    filament_diameter_0: float = _filament(1.75, "Diameter of the filament in tool 0", "mm", 1.0, 3.5)
    filament_diameter_1: float = _filament(1.75, "Diameter of the filament in tool 1", "mm", 1.0, 3.5)
    extrusion_multiplier_0: float = _filament(1.0, "Factor on all amounts that tool 0 extrudes", "", 0.5, 2.0)
    extrusion_multiplier_1: float = _filament(1.0, "Factor on all amounts that tool 1 extrudes", "", 0.5, 2.0)
    filament_density: float = _filament(1.04, "Density of the filament; ABS is 1.04", "g/cm3", 0.5, 5.0)
    filament_cost: float = _filament(25.0, "Price of the filament, in any currency", "per kg", 0.0, 10000.0)
    nozzle_temperature_0: float = _filament(230.0, "Temperature of tool 0", "°C", 0.0, 280.0)
    nozzle_temperature_1: float = _filament(235.0, "Temperature of tool 1", "°C", 0.0, 280.0)
    first_layer_temperature_0: float = _filament(
        0.0, "Temperature of tool 0 in the print's first layer; 0 is that of the others", "°C", 0.0, 280.0
    )
    first_layer_temperature_1: float = _filament(
        0.0, "Temperature of tool 1 in the print's first layer, if it prints there; 0 is that of the others", "°C",
        0.0, 280.0,
    )  # fmt: skip
    standby_temperature_delta: float = _filament(
        0.0, "How much colder the idle nozzle waits; 0 keeps it hot", "°C", 0.0, 200.0
    )
    preheat_time: float = _filament(
        0.0, "How long before its use a cooled nozzle is heated; never less than heating takes at 1.5 °C/s", "s",
        0.0, 600.0,
    )  # fmt: skip
    bed_temperature: float = _filament(110.0, "Temperature of the bed", "°C", 0.0, 130.0)
    first_layer_bed_temperature: float = _filament(
        0.0, "Temperature of the bed during the print's first layer; 0 is that of the others", "°C", 0.0, 130.0
    )
    fan_speed: float = _filament(
        0.0, "Fan that cools the print; Replicators only switch theirs on and off; 0 is off", "%", 0.0, 100.0
    )
    bridge_fan_speed: float = _filament(
        0.0, "Fan while bridges are printed, where that is more than fan_speed", "%", 0.0, 100.0
    )
    disable_fan_first_layers: int = _filament(1, "Layers on the bed that are printed without the fan", "", 0, 1000)
    slowdown_below_layer_time: float = _filament(
        8.0, "Layers that would take less are printed more slowly, so that each sets before the next; 0 slows none",
        "s", 0.0, 300.0,
    )  # fmt: skip
    min_print_speed: float = _filament(10.0, "Least speed that short layers are slowed to", "mm/s", 1.0, 300.0)

    # Predicted print
    sag: float = _preview(0.3, "How far a strand sinks at most where nothing carries it", "mm", 0.0, 2.0)

    @property
    def printer_profile(self) -> PrinterProfile:
        """The facts about the chosen printer.

        Raises:
            SettingsError: its file lacks a fact or has a wrong one.
        """
        return printer_profile(self.printer)

    @property
    def extrusion_multipliers(self) -> tuple[float, float]:
        """Factor on what each tool extrudes."""
        return self.extrusion_multiplier_0, self.extrusion_multiplier_1

    @property
    def filament_sections(self) -> tuple[float, float]:
        """Cross-section of the filament in each tool, mm²."""
        one, other = self.filament_diameter_0, self.filament_diameter_1
        return math.pi / 4 * (one * one), math.pi / 4 * (other * other)

    @property
    def is_solid(self) -> bool:
        """Whether the inside is filled throughout."""
        return self.infill_density >= 100.0

    @property
    def is_hollow(self) -> bool:
        """Whether nothing is printed inside but walls and skins."""
        return self.infill_density <= 0.0

"""Comments that tell layers and features apart: our own, and those that other programs' viewers go by.

The viewers follow plastic on the axis E only, so theirs stand in the files of printers that have it.
"""

from __future__ import annotations

from ..paths import Feature
from ..settings.printer import PrinterProfile

# Feature → its name in the viewers of PrusaSlicer and its kin, and of OctoPrint.
_ELSEWHERE = {
    Feature.OUTER_WALL: "External perimeter",
    Feature.INNER_WALL: "Perimeter",
    Feature.SKIN: "Solid infill",
    Feature.INFILL: "Internal infill",
    Feature.TOWER: "Wipe tower",
    Feature.SKIRT: "Skirt/Brim",
    Feature.SUPPORT: "Support material",
    Feature.SUPPORT_INTERFACE: "Support material interface",
    Feature.BRIM: "Skirt/Brim",
    Feature.RAFT: "Support material",
    Feature.OOZE_SHIELD: "Skirt/Brim",
    Feature.BRIDGE: "Bridge infill",
}
FEATURE_NAMES = {feature: feature.name.lower().replace("_", " ") for feature in Feature}


def feature_comments(printer: PrinterProfile) -> list[bytes]:
    """By `Feature`, the lines before its strands; our own name comes last, since the reader believes the last one."""
    own = [f"; {FEATURE_NAMES[feature]}\n" for feature in Feature]
    if printer.marlin:
        own = [f";TYPE:{_ELSEWHERE.get(feature, 'Custom')}\n{own[feature]}" for feature in Feature]
    return [line.encode("ascii") for line in own]


def layer_comments(layer: int, top: float, printer: PrinterProfile) -> list[str]:
    """The lines before a layer.

    Args:
        layer: its number, counted from the bed.
        top: mm, where the nozzle prints it.
        printer: that the file is for.
    """
    own = [f"; layer {layer}"]
    return [";LAYER_CHANGE", f";Z:{top:.3f}", *own] if printer.marlin else own

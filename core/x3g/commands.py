"""The commands of an X3G file: their numbers, sizes and fields, all little-endian.

Source: MakerBot's S3G protocol, host action commands 131 to 158, as the Sailfish firmware reads them.
"""

from __future__ import annotations

import struct
from enum import IntEnum

import numpy as np

AXES = 5  # X, Y, Z, A, B; bit n of an axes field is axis n
FILAMENT_AXES = 0b11000
POLL_MS = 100
NO_TIMEOUT_S = 0xFFFF
HOMING_TIMEOUT_S = 20
MAX_NAME = 24


class Command(IntEnum):
    """First byte of each command."""

    HOME_MINIMUM = 131
    HOME_MAXIMUM = 132
    DELAY = 133
    CHANGE_TOOL = 134
    WAIT_FOR_TOOL = 135
    TOOL_ACTION = 136
    SWITCH_AXES = 137
    MOVE_UNPLANNED = 139
    SET_POSITION = 140
    WAIT_FOR_BED = 141
    MOVE_TIMED = 142
    STORE_HOME = 143
    RECALL_HOME = 144
    MOTOR_CURRENT = 145
    LIGHT = 146
    BEEP = 147
    WAIT_FOR_BUTTON = 148
    MESSAGE = 149
    PROGRESS = 150
    SONG = 151
    FACTORY_RESET = 152
    BUILD_START = 153
    BUILD_END = 154
    MOVE = 155
    ACCELERATION = 156
    STREAM_VERSION = 157
    PAUSE_AT_Z = 158


class Action(IntEnum):
    """What a tool action (136) does."""

    NOZZLE_TEMPERATURE = 3
    FAN = 12
    VALVE = 13
    BED_TEMPERATURE = 31


# Bytes of each command, its number included; those of three commands depend on their content and are the least here.
SIZES = {
    Command.HOME_MINIMUM: 8,
    Command.HOME_MAXIMUM: 8,
    Command.DELAY: 5,
    Command.CHANGE_TOOL: 2,
    Command.WAIT_FOR_TOOL: 6,
    Command.TOOL_ACTION: 4,
    Command.SWITCH_AXES: 2,
    Command.MOVE_UNPLANNED: 25,
    Command.SET_POSITION: 21,
    Command.WAIT_FOR_BED: 6,
    Command.MOVE_TIMED: 26,
    Command.STORE_HOME: 2,
    Command.RECALL_HOME: 2,
    Command.MOTOR_CURRENT: 3,
    Command.LIGHT: 6,
    Command.BEEP: 6,
    Command.WAIT_FOR_BUTTON: 5,
    Command.MESSAGE: 6,
    Command.PROGRESS: 3,
    Command.SONG: 2,
    Command.FACTORY_RESET: 2,
    Command.BUILD_START: 6,
    Command.BUILD_END: 2,
    Command.MOVE: 32,
    Command.ACCELERATION: 2,
    Command.STREAM_VERSION: 21,
    Command.PAUSE_AT_Z: 5,
}

# A planned move: where to (steps; relative on the axes of the mask), steps/s of the axis with most steps, the way
# in mm and the speed along it in 1/64 mm/s.
MOVE = np.dtype(
    [
        ("command", "u1"),
        ("steps", "<i4", (AXES,)),
        ("rate", "<u4"),
        ("relative", "u1"),
        ("distance", "<f4"),
        ("speed", "<u2"),
    ]
)


def homing(command: Command, axes: int, interval_us: int) -> bytes:
    """Move the axes to their end stops, at this time between the steps of each."""
    return struct.pack("<BBIH", command, axes, interval_us, HOMING_TIMEOUT_S)


def change_tool(tool: int) -> bytes:
    """Make a tool the active one."""
    return bytes([Command.CHANGE_TOOL, tool])


def wait_for(command: Command, tool: int) -> bytes:
    """Wait until a tool (or the bed, whose number is 0) has its temperature."""
    return struct.pack("<BBHH", command, tool, POLL_MS, NO_TIMEOUT_S)


def temperature(action: Action, tool: int, celsius: int) -> bytes:
    """Set the target of a nozzle or of the bed."""
    return struct.pack("<BBBBH", Command.TOOL_ACTION, tool, action, 2, celsius)


def fan(tool: int, on: bool) -> bytes:
    """Switch the output that drives the fan, where the printer has one."""
    return bytes([Command.TOOL_ACTION, tool, Action.VALVE, 1, on])


def recall_home(axes: int) -> bytes:
    """Take over the positions that the printer has stored for its end stops."""
    return bytes([Command.RECALL_HOME, axes])


def switch_off_axes(axes: int) -> bytes:
    """Switch off the motors of these axes."""
    return bytes([Command.SWITCH_AXES, axes])


def set_position(steps: list[int]) -> bytes:
    """Say where the axes are."""
    return struct.pack("<B5i", Command.SET_POSITION, *steps)


def move_unplanned(steps: list[int], interval_us: int) -> bytes:
    """Move without acceleration, at this time between the steps of the axis with most steps."""
    return struct.pack("<B5iI", Command.MOVE_UNPLANNED, *steps, interval_us)


def progress(percent: int) -> bytes:
    """Show how much is done."""
    return bytes([Command.PROGRESS, percent, 0])


def song(number: int) -> bytes:
    """Play a tune."""
    return bytes([Command.SONG, number])


def build_start(name: str) -> bytes:
    """Begin a build; the printer shows the name's first 24 characters."""
    return struct.pack("<BI", Command.BUILD_START, 0) + name[:MAX_NAME].encode("ascii", "replace") + b"\0"


def build_end() -> bytes:
    """End the build."""
    return bytes([Command.BUILD_END, 0])

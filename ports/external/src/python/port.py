"""What the sensor `@NAME@` of a cell reads, sent by a program of yours. Needs @NEEDS@.

    with Port() as port:
        port.send(Reading(@EXAMPLE@), time.monotonic_ns())

This file is made by `cargo run -- external @NAME@`; make it anew when the sensor changes, and write nothing into it.
"""

import ctypes
@IMPORTS@from enum import IntEnum
from typing import Any, Iterator, NamedTuple, Optional

import @LIBRARY@

@PLACE@
RATE_HZ = @RATE@  # how many readings a second the cell expects
VERSION = 1
LAYOUT = @LAYOUT@  # of a reading
CONFIGURATION_WORDS = 16
MAX_JOINTS = @MAX_JOINTS@

@CLASSES@

class Robot(NamedTuple):
    """The measured state of the robot that the sensor belongs to."""

    joints: tuple  # positions [rad or m]; 0 beyond the robot's joints
    velocity: tuple  # [rad/s or m/s]
    position: tuple  # of the tool in the world, x, y, z [m]
    orientation: tuple  # the tool's unit quaternion, x, y, z, w
    wrench: Optional[tuple]  # force [N] and torque [N m] on the tool, of robots that tell it


class Order(NamedTuple):
    """The newest order of the cell."""

    step: int  # its step; a reading that is measured for it is sent with it
    time: int  # when it was sent [ns], as time.monotonic_ns() counts
    configuration: Configuration
    robot: Optional[Robot]


class SecondWriter(Exception):
    """Another program sends the readings of this sensor already."""


class _Message(ctypes.Structure):
    _fields_ = [
        ("version", ctypes.c_uint32),
        ("len", ctypes.c_uint32),
        ("layout", ctypes.c_uint64),
        ("step", ctypes.c_uint64),
        ("time", ctypes.c_uint64),
        ("words", ctypes.c_uint64 * 64),
    ]

    @staticmethod
    def type_name() -> str:
        return "mrroc_external_1"


@PORT_CLASS@


def _message(reading: Reading, measured_at: int, order: Optional[Order]) -> _Message:
    words = words_of(reading)
    message = _Message(VERSION, len(words), LAYOUT, order.step if order else 0, measured_at)
    message.words[: len(words)] = words
    return message


def _order(message: _Message) -> Order:
    if message.version != VERSION:
        raise OtherMessages(f"the cell has version {message.version} of the port, this module {VERSION}")
    words = list(message.words[: message.len])
    robot = _robot(words[CONFIGURATION_WORDS:])
    return Order(message.step, message.time, _get(CONFIGURATION, iter(words)), robot)


def words_of(reading: Reading) -> list:
    """The words of a reading, as they are sent."""
    words: list = []
    _put(READING, reading, words)
    return words


def reading_of(words: list) -> Reading:
    """The reading that these words say."""
    return _get(READING, iter(words))


def _put(shape: Any, value: Any, words: list) -> None:
    """Writes a value as words."""
    if shape == "float":
        words += struct.unpack("<Q", struct.pack("<d", value))
    elif shape == "single":
        words += struct.unpack("<I", struct.pack("<f", value))
    elif shape in ("unsigned", "signed"):
        words += struct.unpack("<Q", struct.pack("<Q" if shape == "unsigned" else "<q", value))
    elif shape == "truth":
        words.append(1 if value else 0)
    elif shape[0] == "choice":
        words.append(int(shape[1](value)))
    elif shape[0] == "array":
        if len(value) != shape[2]:
            raise ValueError(f"{len(value)} values where {shape[2]} are due")
        for item in value:
            _put(shape[1], item, words)
    else:
        names = shape[1]._fields
        if not isinstance(value, (tuple, list)) or len(value) != len(names):
            raise ValueError(f"{shape[1].__name__} has the fields {', '.join(names)}, which {value!r} does not say")
        for name, item, part in zip(names, value, shape[2]):
            try:
                _put(part, item, words)
            except (struct.error, TypeError) as error:
                raise ValueError(f"{shape[1].__name__}.{name} cannot be {item!r}: {error}") from None


@VALUES@


def _robot(words: list) -> Optional[Robot]:
    numbers = struct.unpack(f"<{len(words)}d", struct.pack(f"<{len(words)}Q", *words))
    if len(numbers) < 2 * MAX_JOINTS + 7:
        return None
    at = 2 * MAX_JOINTS
    joints, velocity = numbers[:MAX_JOINTS], numbers[MAX_JOINTS:at]
    return Robot(joints, velocity, numbers[at : at + 3], numbers[at + 3 : at + 7], numbers[at + 7 :] or None)


@ENDS@

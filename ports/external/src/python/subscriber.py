"""Looks on at the cell that is shown at port `@PORT@`. Needs iceoryx2==0.10.0, on the cell's machine.

    with Subscriber() as subscriber:
        while True:
            for name, image in subscriber.images():
                print(name, image.step, image.measured.joints)
            time.sleep(0.01)

This file is made by `cargo run -- external @PORT@`; make it anew when the cell's robots or sensors change, and write nothing into it.
"""

import ctypes
import os
import struct
from enum import IntEnum
from typing import Any, Iterator, NamedTuple, Optional, Tuple

import iceoryx2 as iox2

PORT = "@PORT@"
ROBOTS = (@ROBOTS@,)  # those of the cell
VERSION = @VERSION@
KEPT = @KEPT@  # messages that wait for this program; older ones are lost
MAX_JOINTS = @MAX_JOINTS@
MODES = ("holding", "moving", "bridging", "braking", "off")

@CLASSES@


# The layout of each sensor's readings, and what their words say.
SENSORS: dict = {
@SENSORS@
}


class State(NamedTuple):
    """One state of a robot."""

    joints: tuple  # positions [rad or m]
    velocity: tuple  # [rad/s or m/s]
    position: tuple  # of the tool in the world, x, y, z [m]
    orientation: tuple  # the tool's unit quaternion, x, y, z, w


class Image(NamedTuple):
    """What a robot does when a step begins."""

    step: int
    time: float  # of the cell [s]
    sent: int  # when [ns], as time.monotonic_ns() counts
    mode: str  # one of MODES
    demanded: State
    measured: State


class Step(NamedTuple):
    """What the coordinator does when a step begins."""

    step: int
    time: float  # of the cell [s]
    sent: int  # when [ns], as time.monotonic_ns() counts
    path_time: float  # of the step [s]; 0 while it is suspended
    duration: float  # of the step [s]
    speed: float  # that the operator wants, 0 to 1
    suspended: bool
    reduced: bool  # whether reduced speed is in force
    aborting: bool
    stopping: bool
    over: bool  # whether its program is over
    fault: Optional[str]  # the first one that stopped it, until a reset


class Reading(NamedTuple):
    """A reading of a virtual sensor that the cell has collected: one for each step in which it has, new or not."""

    sensor: str
    robot: Optional[str]  # whose ECP has collected it; None: the MP has
    step: int  # in which it was collected
    time: float  # of the cell [s]
    sent: int  # when [ns], as time.monotonic_ns() counts
    taken: int  # the step in which it was taken: step - taken is its age
    value: Any  # of the class of the sensor's readings


@ENDS@


class _RobotMessage(ctypes.Structure):
    _fields_ = [
        ("version", ctypes.c_uint32),
        ("joints", ctypes.c_uint32),
        ("step", ctypes.c_uint64),
        ("time", ctypes.c_uint64),
        ("sent", ctypes.c_uint64),
        ("mode", ctypes.c_uint64),
        ("words", ctypes.c_uint64 * @WORDS@),
    ]

    @staticmethod
    def type_name() -> str:
        return "mrroc_image_1"


class _CellMessage(ctypes.Structure):
    _fields_ = [
        ("version", ctypes.c_uint32),
        ("flags", ctypes.c_uint32),
        ("step", ctypes.c_uint64),
        ("time", ctypes.c_uint64),
        ("sent", ctypes.c_uint64),
        ("path_time", ctypes.c_double),
        ("duration", ctypes.c_double),
        ("speed", ctypes.c_double),
        ("fault", ctypes.c_uint8 * @TEXT@),
    ]

    @staticmethod
    def type_name() -> str:
        return "mrroc_step_1"


class _ReadingMessage(ctypes.Structure):
    _fields_ = [
        ("version", ctypes.c_uint32),
        ("len", ctypes.c_uint32),
        ("layout", ctypes.c_uint64),
        ("step", ctypes.c_uint64),
        ("time", ctypes.c_uint64),
        ("sent", ctypes.c_uint64),
        ("taken", ctypes.c_uint64),
        ("sensor", ctypes.c_uint8 * @NAME@),
        ("words", ctypes.c_uint64 * @READING_WORDS@),
    ]

    @staticmethod
    def type_name() -> str:
        return "mrroc_reading_1"


class Subscriber:
    """Sees what the cell shows, and changes nothing. It may begin before the cell, and see several runs of it."""

    def __init__(self) -> None:
        self._node = _node()
        self._images = {name: self._end(f"{name}/images", _RobotMessage) for name in ROBOTS}
        self._steps = self._end("steps", _CellMessage)
        names = {None: "sensors"} | {name: f"{name}/sensors" for name in ROBOTS}
        self._readings = {robot: self._end(name, _ReadingMessage) for robot, name in names.items()}

    def _end(self, name: str, message: Any) -> Any:
        return _channel(self._node, f"mrroc/{PORT}/{name}", message, KEPT).subscriber_builder().create()

    def images(self) -> Iterator[Tuple[str, Image]]:
        """What the robots have shown since the last call, each robot's in its order; a step that is missing was lost."""
        for name, end in self._images.items():
            for message in _messages(end):
                numbers = struct.unpack("@WORDS@d", bytes(message.words))
                time, mode = message.time / 1e9, MODES[message.mode]
                demanded, measured = _state(numbers, message.joints), _state(numbers[2 * MAX_JOINTS + 7 :], message.joints)
                yield name, Image(message.step, time, message.sent, mode, demanded, measured)

    def steps(self) -> Iterator[Step]:
        """What the coordinator has shown since the last call."""
        for message in _messages(self._steps):
            flags = [bool(message.flags >> bit & 1) for bit in range(5)]
            fault = bytes(message.fault).rstrip(b"\0").decode() or None
            numbers = (message.path_time, message.duration, message.speed)
            yield Step(message.step, message.time / 1e9, message.sent, *numbers, *flags, fault)

    def readings(self) -> Iterator[Reading]:
        """The readings that the cell has collected since the last call, those of each process in their order."""
        for robot, end in self._readings.items():
            for message in _messages(end):
                sensor = bytes(message.sensor).rstrip(b"\0").decode()
                layout, shape = SENSORS.get(sensor, (None, None))
                if message.layout != layout:
                    raise OtherMessages(f"sensor `{sensor}` has other readings: make this module anew")
                value = _get(shape, iter(message.words))
                yield Reading(sensor, robot, message.step, message.time / 1e9, message.sent, message.taken, value)

    def close(self) -> None:
        """Looks on no more."""
        for end in (*self._images.values(), self._steps, *self._readings.values()):
            end.delete()
        del self._images, self._steps, self._readings, self._node

    def __enter__(self) -> "Subscriber":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()


def _messages(end: Any) -> Iterator[Any]:
    while (sample := end.receive()) is not None:
        message = sample.payload().contents
        if message.version != VERSION:
            raise OtherMessages(f"the cell has version {message.version} of the port, this module {VERSION}")
        yield message


def _state(numbers: tuple, joints: int) -> State:
    velocity, pose = numbers[MAX_JOINTS:], numbers[2 * MAX_JOINTS :]
    return State(numbers[:joints], velocity[:joints], pose[:3], pose[3:7])


@VALUES@

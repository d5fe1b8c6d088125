"""A simulator for robots of a cell, in Python. Needs iceoryx2==0.10.0, on the cell's machine.

    with Plant() as plant:
        for orders in plant:
            for name, joints in orders.begins.items():
                ...                                    # let this robot stand at these joints
            ...                                        # simulate orders.seconds, towards orders.demanded
            plant.answer({name: State(position, velocity, wrench) for name in orders.demanded})

This file is made by `cargo run -- external @NAME@`; make it anew when the cell's robots change, and write nothing into it.
"""

import collections
import ctypes
import math
import os
import time
from typing import Any, Dict, Iterator, NamedTuple, Optional, Sequence

import iceoryx2 as iox2

PORT = "@PORT@"
ROBOTS = (@ROBOTS@,)  # those of the cell that are in this simulator
VERSION = @VERSION@
LAYOUT = @LAYOUT@  # of both messages
ORDERS = @ORDERS@  # that wait for this program
MAX_JOINTS = @MAX_JOINTS@
NAME = 24

BEGIN, FOLLOW, STAND_BY, END = 1, 2, 3, 4  # what an order asks for
PLACED, STEPPED, FAILED = 1, 2, 3  # what a state says

LOST = 0.1  # of a cell in real time: who orders nothing for so long [s] has no power any more


class State(NamedTuple):
    """What a robot's encoders read, and the wrench at its flange."""

    position: Sequence  # of each joint [rad or m]
    velocity: Sequence  # [rad/s or m/s]
    wrench: Optional[Sequence] = None  # force [N] and torque [N m] of the surroundings on the flange, in its frame


class Orders(NamedTuple):
    """What the cell asks for: where its robots are to be when `seconds` have passed."""

    period: int  # the servo period, counted from the cell's start
    seconds: float  # to simulate; 0 when a robot begins
    begins: Dict[str, tuple]  # robots that begin, and where they stand [rad or m]
    demanded: Dict[str, tuple]  # of each robot that has begun: where it is to be [rad or m]
    powered: Dict[str, bool]  # whether it has power; its brakes are applied otherwise
    late: int  # answers that came too late for the cell so far, of all robots
    is_real: bool  # whether the cell runs in real time, or waits for this program


class SecondSimulator(Exception):
    """Another program simulates these robots already."""


@ENDS@


class _Order(ctypes.Structure):
    _fields_ = [
        ("version", ctypes.c_uint32),
        ("kind", ctypes.c_uint32),
        ("layout", ctypes.c_uint64),
        ("session", ctypes.c_uint64),
        ("period", ctypes.c_uint64),
        ("time", ctypes.c_uint64),
        ("length", ctypes.c_uint64),
        ("late", ctypes.c_uint64),
        ("clock", ctypes.c_uint32),
        ("joints", ctypes.c_uint32),
        ("robot", ctypes.c_uint8 * NAME),
        ("demanded", ctypes.c_double * MAX_JOINTS),
    ]

    @staticmethod
    def type_name() -> str:
        return "mrroc_plant_order_1"


class _State(ctypes.Structure):
    _fields_ = [
        ("version", ctypes.c_uint32),
        ("kind", ctypes.c_uint32),
        ("layout", ctypes.c_uint64),
        ("session", ctypes.c_uint64),
        ("period", ctypes.c_uint64),
        ("time", ctypes.c_uint64),
        ("joints", ctypes.c_uint32),
        ("has_wrench", ctypes.c_uint32),
        ("robot", ctypes.c_uint8 * NAME),
        ("position", ctypes.c_double * MAX_JOINTS),
        ("velocity", ctypes.c_double * MAX_JOINTS),
        ("wrench", ctypes.c_double * 6),
    ]

    @staticmethod
    def type_name() -> str:
        return "mrroc_plant_state_1"


class _Robot:
    """The two ends that this program has of a robot's port."""

    def __init__(self, node: Any, name: str) -> None:
        self.name = name
        self.orders = _channel(node, f"mrroc/{PORT}/{name}/orders", _Order, ORDERS)
        states = _channel(node, f"mrroc/{PORT}/{name}/states", _State, 1)
        try:
            self.sends = states.publisher_builder().create()
        except iox2.PublisherCreateError:
            raise SecondSimulator(f"another program simulates `{name}` at port `{PORT}`; end it first") from None
        self.takes = self.orders.subscriber_builder().create()
        self.queue: collections.deque = collections.deque()
        self.forget()

    def forget(self) -> None:
        """Nobody orders anything."""
        self.has_begun, self.session, self.joints, self.demanded, self.powered = False, 0, 0, (), False
        self.first, self.late, self.heard = None, 0, time.monotonic()

    def hear(self) -> None:
        """Takes the orders that have come."""
        while (sample := self.takes.receive()) is not None:
            order = sample.payload().contents
            if order.version != VERSION or order.layout != LAYOUT:
                raise OtherMessages("the cell has another version of the port: make this module anew")
            if order.kind == BEGIN:
                self.queue.clear()
            self.queue.append(_Order.from_buffer_copy(order))
            self.heard = time.monotonic()

    def take(self) -> None:
        """Takes over what the first order of the queue says."""
        order = self.queue.popleft()
        self.first = order.period if self.first is None else self.first
        self.late = order.late
        if order.kind in (BEGIN, FOLLOW):
            self.joints, self.demanded = order.joints, tuple(order.demanded[: order.joints])
        self.powered = order.kind == FOLLOW

    def answer(self, kind: int, period: int, state: State) -> None:
        """Sends a state."""
        message = _State(VERSION, kind, LAYOUT, self.session, period, time.monotonic_ns(), len(state.position))
        message.robot[: len(self.name)] = self.name.encode()
        message.position[: len(state.position)] = [float(x) for x in state.position]
        message.velocity[: len(state.velocity)] = [float(x) for x in state.velocity]
        if state.wrench is not None:
            message.has_wrench, message.wrench[:] = 1, [float(x) for x in state.wrench]
        self.sends.send_copy(message)


class Plant:
    """The orders of a cell's servo periods, one after the other, and the states that answer them."""

    def __init__(self) -> None:
        self._node = _node()
        self._robots = {name: _Robot(self._node, name) for name in ROBOTS}
        self._period = None  # the last one that was simulated
        self._unanswered: list = []

    def __iter__(self) -> Iterator[Orders]:
        since = looked = time.monotonic()
        while True:
            if self._unanswered:
                raise RuntimeError("answer() has not been called for the last orders")
            orders = self._next()
            if orders is not None:
                yield orders
                since = looked = time.monotonic()
                continue
            now = time.monotonic()
            time.sleep(20e-6 if now - since < 0.1 else 1e-3)
            if now - looked > 0.1:
                self._forget_the_dead()
                looked = now

    def _next(self) -> Optional[Orders]:
        robots = self._robots.values()
        for robot in robots:
            robot.hear()
        for robot in robots:
            while robot.queue and robot.queue[0].kind in (BEGIN, END):
                order = robot.queue[0]
                if order.kind == END:
                    robot.forget()
                    robot.queue.popleft()
                    continue
                if order.session != robot.session:
                    self._forget_the_dead()
                robot.take()
                robot.has_begun, robot.session = True, order.session
                # Whoever begins while others are on their way and does not know the period is waited for from its first order on.
                robot.first = order.period if order.period > 0 or self._period is None else None
                return self._orders(PLACED, order, 0.0, {robot.name: robot.demanded}, [robot])
            if not robot.has_begun:
                robot.queue.clear()  # of a cell that has gone
        begun = [robot for robot in robots if robot.has_begun]
        if not begun:
            self._period = None
        ready = [robot for robot in begun if robot.queue]
        if not ready:
            return None
        first = min((robot.queue[0] for robot in ready), key=lambda order: order.period)
        missed = [robot for robot in begun if not robot.queue and robot.first is not None and robot.first <= first.period]
        if missed:
            # In real time who is late by half a period is not waited for: the robot stays on its way to where it was to be.
            late = time.monotonic_ns() - first.time > first.length // 2
            if not (first.clock == 1 and late):
                return None
            for robot in missed:
                robot.powered &= time.monotonic() - robot.heard < LOST
        if self._period is not None and first.period <= self._period:
            # It came when its period was over. What it demands is the newest there is.
            for robot in ready:
                if robot.queue[0].period == first.period:
                    robot.take()
            return None
        for robot in ready:
            # One whose first order is of a later period has left this one out.
            if robot.queue[0].period == first.period:
                robot.take()
        passed = 1 if self._period is None else first.period - self._period
        self._period = first.period
        return self._orders(STEPPED, first, passed * first.length / 1e9, {}, begun)

    def _orders(self, kind: int, order: _Order, seconds: float, begins: dict, answers: list) -> Orders:
        begun = [robot for robot in self._robots.values() if robot.has_begun]
        self._unanswered = [(robot, kind, order.period) for robot in answers]
        return Orders(
            order.period,
            seconds,
            begins,
            {robot.name: robot.demanded for robot in begun},
            {robot.name: robot.powered for robot in begun},
            sum(robot.late for robot in begun),
            order.clock == 1,
        )

    def answer(self, states: Dict[str, State]) -> None:
        """Sends the states at the end of the period, of each robot that has begun."""
        for robot, kind, period in self._unanswered:
            state = states[robot.name]
            if len(state.position) != robot.joints or len(state.velocity) != robot.joints:
                raise ValueError(f"`{robot.name}` has {robot.joints} joints")
            if not all(map(math.isfinite, [*state.position, *state.velocity])):
                kind = FAILED
            robot.answer(kind, period, state)
        self._unanswered = []

    def _forget_the_dead(self) -> None:
        """Robots whose cell was killed are waited for no more."""
        self._node.try_cleanup_dead_nodes()
        for robot in self._robots.values():
            if robot.has_begun and robot.orders.dynamic_config.number_of_publishers == 0 and not robot.queue:
                robot.forget()

    def close(self) -> None:
        """Gives the port back."""
        for robot in self._robots.values():
            robot.sends.delete()
            robot.takes.delete()
            del robot.sends, robot.takes, robot.orders
        self._robots = {}
        del self._node

    def __enter__(self) -> "Plant":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

"""Durations by Ruckig (PyPI `ruckig`, 0.19.4), for generators-lib/tests/jerk_reference.rs.

    python3 -m venv target/peers/ruckig && target/peers/ruckig/bin/pip install ruckig==0.19.4
    target/peers/ruckig/bin/python tests/benches/peers/ruckig_reference.py > generators-lib/tests/reference/ruckig.csv

One row per random case: kind, per axis p0 v0 a0 p1 v1 v_max v_min a_max a_min j (axes that a kind lacks are left out),
then the duration. Cases that Ruckig refuses are drawn anew.
"""
import random
import sys

import ruckig

random.seed(2014)


def uniform(low, high):
    """Four decimals: short to write, and the same number to both sides."""
    return round(random.uniform(low, high), 4)


def limits(symmetric):
    v, a, j = uniform(0.1, 3.0), uniform(0.2, 8.0), uniform(0.5, 60.0)
    if symmetric:
        return v, -v, a, -a, j
    return v, -uniform(0.1, 3.0), a, -uniform(0.2, 8.0), j


def axis(kind):
    v_max, v_min, a_max, a_min, j = limits(not kind.startswith("asymmetric"))
    p0, p1 = uniform(-2.0, 2.0), uniform(-2.0, 2.0)
    if kind == "near":
        p1 = round(p0 + random.choice([-1, 1]) * 10.0 ** uniform(-6, 0), 8)
    v0 = a0 = v1 = 0.0
    if "rest" not in kind:
        v0, a0 = uniform(0.95 * v_min, 0.95 * v_max), uniform(0.95 * a_min, 0.95 * a_max)
        if "velocity" in kind:
            v1 = uniform(0.95 * v_min, 0.95 * v_max)
    return p0, v0, a0, p1, v1, v_max, v_min, a_max, a_min, j


def duration(axes):
    given = ruckig.InputParameter(len(axes))
    given.current_position = [x[0] for x in axes]
    given.current_velocity = [x[1] for x in axes]
    given.current_acceleration = [x[2] for x in axes]
    given.target_position = [x[3] for x in axes]
    given.target_velocity = [x[4] for x in axes]
    given.max_velocity = [x[5] for x in axes]
    given.min_velocity = [x[6] for x in axes]
    given.max_acceleration = [x[7] for x in axes]
    given.min_acceleration = [x[8] for x in axes]
    given.max_jerk = [x[9] for x in axes]
    trajectory = ruckig.Trajectory(len(axes))
    result = ruckig.Ruckig(len(axes)).calculate(given, trajectory)
    return trajectory.duration if result == ruckig.Result.Working else None


def within(x):
    """Whether the start neither has left nor must leave the velocity limits: what a plan is made from here."""
    p0, v0, a0, p1, v1, v_max, v_min, a_max, a_min, j = x
    reached = v0 + a0 * abs(a0) / (2.0 * j)
    return v_min <= reached <= v_max


print("kind,axes")
KINDS = [
    ("rest", 1), ("asymmetric-rest", 1), ("state", 1), ("near", 1), ("velocity", 1), ("asymmetric-velocity", 1),
    ("rest", 6), ("velocity", 2), ("velocity", 6), ("asymmetric-velocity", 3),
]
for kind, count in KINDS:
    left = 2000 if count == 1 else 500 if count < 6 else 400
    while left:
        axes = [axis(kind) for _ in range(count)]
        if not all(within(x) for x in axes):
            continue
        try:
            time = duration(axes)
        except RuntimeError as error:
            print(error, file=sys.stderr)
            continue
        if time is None:
            continue
        numbers = [repr(x) for one in axes for x in one] + [f"{time:.17g}"]
        print(f"{kind}-{count},{','.join(numbers)}")
        left -= 1

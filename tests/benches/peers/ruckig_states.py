"""Durations by Ruckig (PyPI `ruckig`, 0.19.4) to targets with an acceleration, and from starts outside the limits, for
generators-lib/tests/jerk_reference.rs.

    python3 -m venv target/peers/ruckig && target/peers/ruckig/bin/pip install ruckig==0.19.4
    target/peers/ruckig/bin/python tests/benches/peers/ruckig_states.py > generators-lib/tests/reference/ruckig_states.csv

One row per random case: kind, per axis p0 v0 a0 p1 v1 a1 v_max v_min a_max a_min j (axes that a kind lacks are left out),
then the duration. Cases that Ruckig refuses are drawn anew.
"""
import random
import sys

import ruckig

random.seed(160)


def uniform(low, high):
    """Four decimals: short to write, and the same number to both sides."""
    return round(random.uniform(low, high), 4)


def axis(kind):
    v, a, j = uniform(0.1, 3.0), uniform(0.2, 8.0), uniform(0.5, 60.0)
    low_v, low_a = (-uniform(0.1, 3.0), -uniform(0.2, 8.0)) if "asymmetric" in kind else (-v, -a)
    beyond = 2.5 if "outside" in kind else 0.95
    p0, p1 = uniform(-2.0, 2.0), uniform(-2.0, 2.0)
    v0, a0 = uniform(beyond * low_v, beyond * v), uniform(beyond * low_a, beyond * a)
    v1 = a1 = 0.0
    if "velocity" in kind or "acceleration" in kind:
        v1 = uniform(0.95 * low_v, 0.95 * v)
    if "acceleration" in kind:
        a1 = uniform(0.95 * low_a, 0.95 * a)
    return p0, v0, a0, p1, v1, a1, v, low_v, a, low_a, j


def duration(axes):
    given = ruckig.InputParameter(len(axes))
    names = ["current_position", "current_velocity", "current_acceleration", "target_position", "target_velocity",
             "target_acceleration", "max_velocity", "min_velocity", "max_acceleration", "min_acceleration", "max_jerk"]
    for i, name in enumerate(names):
        setattr(given, name, [x[i] for x in axes])
    trajectory = ruckig.Trajectory(len(axes))
    result = ruckig.Ruckig(len(axes)).calculate(given, trajectory)
    return trajectory.duration if result == ruckig.Result.Working else None


def from_within(x):
    """Whether the target can be reached from within the velocity limits: what a plan is made for here."""
    v1, a1, v, low_v, j = x[4], x[5], x[6], x[7], x[10]
    before = v1 - a1 * abs(a1) / (2.0 * j)
    return low_v <= before <= v


print("kind,axes")
KINDS = [
    ("acceleration", 1), ("asymmetric-acceleration", 1), ("outside", 1), ("asymmetric-outside-velocity", 1),
    ("outside-acceleration", 1), ("acceleration", 3), ("outside", 2), ("asymmetric-outside-acceleration", 6),
]
for kind, count in KINDS:
    left = 1500 if count == 1 else 300
    while left:
        axes = [axis(kind) for _ in range(count)]
        if not all(from_within(x) for x in axes):
            continue
        try:
            time = duration(axes)
        except RuntimeError as error:
            print(kind, error, axes, file=sys.stderr)
            continue
        if time is None:
            continue
        numbers = [repr(x) for one in axes for x in one] + [f"{time:.17g}"]
        print(f"{kind}-{count},{','.join(numbers)}")
        left -= 1

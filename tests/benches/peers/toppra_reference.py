"""Durations by TOPPRA (PyPI `toppra`, 0.6.10), for generators-lib/tests/timing_reference.rs.

    python3 -m venv target/peers/toppra && target/peers/toppra/bin/pip install toppra==0.6.10
    target/peers/toppra/bin/python tests/benches/peers/toppra_reference.py > generators-lib/tests/reference/toppra.csv

Per case rows `kind,case,numbers`: `knots`; `point`, the joints at a knot, of a natural cubic spline; `velocity`,
`acceleration`, and `torque` where it is limited, per joint; `speeds` of the path at its start and end; `duration`, of a
grid of so many cells per knot span, in which cells are equally long, and the duration.

Torques are those of an arm of two links of 0.5 m that swings in a vertical plane, a mass of 1 kg at the end of each:
`dynamics` below.
"""
import math
import random

import numpy
import toppra
from toppra import algorithm, constraint

toppra.setup_logging("CRITICAL")
random.seed(2018)
CELLS = [10, 20, 50, 400]


def dynamics(q, v, a):
    length, mass, gravity = 0.5, 1.0, 9.81
    c, s, k = math.cos(q[1]), math.sin(q[1]), mass * length * length
    first = k * ((3 + 2 * c) * a[0] + (1 + c) * a[1] - s * (2 * v[0] * v[1] + v[1] ** 2))
    second = k * ((1 + c) * a[0] + a[1] + s * v[0] ** 2)
    g1, g2 = (mass * gravity * length * math.cos(x) for x in (q[0], q[0] + q[1]))
    return numpy.array([first + 2 * g1 + g2, second + g2])


def row(kind, case, numbers):
    print(f"{kind},{case},{','.join(repr(float(x)) for x in numbers)}")


def uniform(low, high):
    return round(random.uniform(low, high), 4)


def durations(case, knots, points, velocity, acceleration, torque, speeds):
    path = toppra.SplineInterpolator(knots, points, bc_type="natural")
    both = lambda most: numpy.array([[-x, x] for x in most])
    limits = [constraint.JointVelocityConstraint(both(velocity)),
              constraint.JointAccelerationConstraint(
                  both(acceleration), discretization_scheme=constraint.DiscretizationType.Interpolation)]
    if torque:
        limits.append(constraint.JointTorqueConstraint(
            dynamics, both(torque), numpy.zeros(2),
            discretization_scheme=constraint.DiscretizationType.Interpolation))
    found = []
    for cells in CELLS:
        parts = [numpy.linspace(a, b, cells, endpoint=False) for a, b in zip(knots, knots[1:])]
        grid = numpy.append(numpy.concatenate(parts), knots[-1])
        planner = algorithm.TOPPRA(limits, path, gridpoints=grid, parametrizer="ParametrizeConstAccel")
        _, speed, _ = planner.compute_parameterization(*speeds)
        if speed is None:
            return False
        found.append((cells, float(numpy.sum(2 * numpy.diff(grid) / (speed[1:] + speed[:-1])))))
    row("knots", case, knots)
    for point in points:
        row("point", case, point)
    row("velocity", case, velocity)
    row("acceleration", case, acceleration)
    if torque:
        row("torque", case, torque)
    row("speeds", case, speeds)
    for pair in found:
        row("duration", case, pair)
    return True


print("kind,case,numbers")
case = 0
while case < 40:
    torque = case % 4 == 3
    joints = 2 if torque else random.choice([2, 6])
    count = random.choice([3, 4, 6])
    knots = numpy.cumsum([0.0] + [uniform(0.5, 1.5) for _ in range(count - 1)])
    points = numpy.array([[uniform(-1.5, 1.5) for _ in range(joints)] for _ in knots])
    velocity, acceleration = ([uniform(low, high) for _ in range(joints)] for low, high in [(0.5, 3), (1, 10)])
    limit = [uniform(18, 30), uniform(8, 15)] if torque else None
    speeds = [uniform(0, 0.3), uniform(0, 0.3)] if case % 4 == 2 else [0.0, 0.0]
    case += durations(case, knots, points, velocity, acceleration, limit, speeds)

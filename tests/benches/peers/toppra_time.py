"""Time of TOPPRA (PyPI `toppra`, 0.6.10) per path of six joints, for `tests/benches/peers/timing`: grid points, least time
per path [us], sum of all durations [s]. The paths are those of generators-lib/benches/timing.rs."""
import time

import numpy
import toppra
from toppra import algorithm, constraint

toppra.setup_logging("CRITICAL")


def waypoint(k, i, j):
    return ((k * 7 + i * 13 + j * 29) * 0.6180339887498949) % 1.0 * 2.0 - 1.0


def both(most):
    return numpy.array([[-most, most]] * 6)


limits = [constraint.JointVelocityConstraint(both(1.0)), constraint.JointAccelerationConstraint(both(4.0))]
knots = numpy.linspace(0.0, 1.0, 6)
paths = [
    toppra.SplineInterpolator(knots, [[waypoint(k, i, j) for j in range(6)] for i in range(6)], bc_type="natural")
    for k in range(20)
]
for points in [101, 201, 1001]:
    grid, least = numpy.linspace(0.0, 1.0, points), float("inf")
    for _ in range(5):
        start, total = time.perf_counter(), 0.0
        for path in paths:
            planner = algorithm.TOPPRA(limits, path, gridpoints=grid, parametrizer="ParametrizeConstAccel")
            _, speed, _ = planner.compute_parameterization(0.0, 0.0)
            total += numpy.sum(2 * numpy.diff(grid) / (speed[1:] + speed[:-1]))
        least = min(least, (time.perf_counter() - start) / len(paths))
    print(f"toppra {points} {least * 1e6:.1f} {total:.6f}")

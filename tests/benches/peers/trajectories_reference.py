"""Polynomials between points of joint trajectories by scipy (PyPI `scipy`, 1.17.1), for generators-lib/tests/trajectory.rs.

    python3 tests/benches/peers/trajectories_reference.py > generators-lib/tests/reference/trajectories.csv

Rows `kind,case,what,numbers`, after a line with their names. Kinds: `five` (`BPoly.from_derivatives` of positions, velocities and accelerations),
`three` (`CubicHermiteSpline` of positions and velocities), `bare` (`CubicSpline` of positions, clamped: the velocity of the start, and 0 at the end; its
first and last span are `BPoly.from_derivatives` of the spline's values at one end, and of the start's acceleration, or of 0, at the other).
`start` is position, velocity and acceleration before the first point, at time 0; then come the `point`s, each with its time, position, velocity and
acceleration, of which a kind uses what it needs; then `at` time, position, velocity, acceleration.
"""
import random

import numpy
from scipy.interpolate import BPoly, CubicHermiteSpline, CubicSpline

random.seed(39)


def number():
    return random.uniform(-1, 1)


def row(kind, case, what, numbers):
    print(f"{kind},{case},{what},{','.join(repr(float(x)) for x in numpy.ravel(numbers))}")


def curve(kind, times, knots):
    if kind == "five":
        return BPoly.from_derivatives(times, knots)
    if kind == "three":
        return CubicHermiteSpline(times, [k[0] for k in knots], [k[1] for k in knots])
    spline = CubicSpline(times, [k[0] for k in knots], bc_type=((1, knots[0][1]), (1, 0.0)))
    inner = [[spline(t), spline(t, 1), spline(t, 2)] for t in times]
    inner[0] = knots[0]
    inner[-1] = [knots[-1][0], 0.0, 0.0]
    return BPoly.from_derivatives(times, inner)


print("kind,case,what,numbers")
for kind in ("five", "three", "bare"):
    for case in range(20):
        count = random.choice([1, 2, 3, 5, 12])
        start = [number(), number(), number() if kind != "three" else 0.0]
        times = numpy.cumsum([0.05 + random.random() for _ in range(count)])
        points = [[number(), number(), number()] for _ in times]
        points[-1][1] = 0.0
        row(kind, case, "start", start)
        for time, point in zip(times, points):
            row(kind, case, "point", [time, *point])
        curves = curve(kind, numpy.concatenate([[0.0], times]), [start, *points])
        for k in range(23):
            # Not at a point, where accelerations have steps.
            at = times[-1] * (k + 0.37) / 23.5
            row(kind, case, "at", [at, curves(at), curves(at, 1), curves(at, 2)])

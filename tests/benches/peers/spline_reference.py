"""Cubic splines by scipy (PyPI `scipy`, 1.17.1), for generators-lib/tests/curve_reference.rs.

    python3 tests/benches/peers/spline_reference.py > generators-lib/tests/reference/cubic_splines.csv

Per case: a row `knots` of the knots, rows `point` of a knot's three values, a row `ends` of the end slopes (empty for
the natural spline), then rows `at` of the parameter, the values, their first and second derivatives.
"""
import random

import numpy
from scipy.interpolate import CubicSpline

random.seed(7)
print("kind,case,numbers")


def row(kind, case, numbers):
    print(f"{kind},{case},{','.join(repr(float(x)) for x in numbers)}")


for case in range(40):
    count = random.choice([3, 4, 5, 8, 20])
    knots = numpy.cumsum([0.0] + [round(random.uniform(0.05, 2.0), 4) for _ in range(count - 1)])
    points = numpy.array([[round(random.uniform(-2.0, 2.0), 4) for _ in range(3)] for _ in knots])
    slopes = numpy.array([[round(random.uniform(-1.0, 1.0), 4) for _ in range(3)] for _ in range(2)])
    clamped = case % 2 == 1
    ends = ((1, slopes[0]), (1, slopes[1])) if clamped else "natural"
    spline = CubicSpline(knots, points, bc_type=ends)
    row("knots", case, knots)
    for point in points:
        row("point", case, point)
    row("ends", case, slopes.flatten() if clamped else [])
    for u in numpy.linspace(knots[0], knots[-1], 31):
        row("at", case, [u, *spline(u), *spline(u, 1), *spline(u, 2)])

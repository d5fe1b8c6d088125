"""Lengths and points of NURBS that G5.2 and G6.2 programs give, by scipy: prints nurbs.csv.

A rational B-spline is the quotient of two polynomial ones: of the weighted control points, and of the weights.
"""

import numpy as np
from scipy.integrate import quad
from scipy.interpolate import BSpline

# The control points with weights, the degree, and the knots: open and uniform for G5.2 (LinuxCNC), as written for G6.2.
CURVES = {
    "linuxcnc": ([(0, 0, 1), (0, 1, 1), (2, 2, 1), (2, 0, 1), (0, 0, 2)], 2, None),
    "heavy_start": ([(0, 0, 5), (10, 20, 1), (25, -5, 2), (40, 10, 0.5), (30, 30, 1)], 3, None),
    "knotted": ([(0, 0, 1), (5, 12, 2), (15, 12, 0.7), (22, -3, 1), (30, 4, 1.5)], 3, [0, 0, 0, 0, 0.3, 1, 1, 1, 1]),
}

print("name,length,x_at_half,y_at_half,first_knot,last_knot")
for name, (controls, degree, knots) in CURVES.items():
    points = np.array([(x, y) for x, y, _ in controls], float)
    weights = np.array([w for _, _, w in controls], float)
    if knots is None:
        spans = len(controls) - degree
        knots = [min(max(i - degree, 0), spans) for i in range(len(controls) + degree + 1)]
    above = BSpline(knots, points * weights[:, None], degree)
    below = BSpline(knots, weights, degree)
    d_above, d_below = above.derivative(), below.derivative()

    def speed(u):
        a, b, da, db = above(u), below(u), d_above(u), d_below(u)
        return np.hypot(*((da * b - a * db) / b**2))

    breaks = sorted(set(knots))
    length = sum(quad(speed, a, b, epsabs=1e-12, epsrel=1e-12, limit=400)[0] for a, b in zip(breaks, breaks[1:]))
    half = (breaks[0] + breaks[-1]) / 2
    x, y = above(half) / below(half)
    print(f"{name},{length:.9f},{x:.9f},{y:.9f},{breaks[0]},{breaks[-1]}")

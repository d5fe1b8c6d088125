"""Curves by scipy (PyPI `scipy`, 1.17.1) and Pinocchio (PyPI `pin`, 4.1.0), for generators-lib/tests/curve_reference.rs.

    python3 tests/benches/peers/curves_reference.py > generators-lib/tests/reference/curves.csv

Rows `kind,case,what,numbers`. Kinds:
`smoothing`: `make_smoothing_spline`; `knots`, `point`s, `weights`, `lambda`, then `at` parameter, values, first and second
  derivatives;
`rotation`: `RotationSpline`; `knots`, `point`s (quaternions x y z w), then `at` parameter, quaternion, angular velocity and
  acceleration in the moving frame;
`nurbs`: `BSpline` of `(w P, w)` divided by its last coordinate, derivatives by the rule for quotients; `degree`, `knots`,
  `point`s, `weights`, then `at` parameter, value, first and second derivative, and `length`;
`slerp`: `Slerp`; two `point`s, then `at` share, quaternion;
`screw`: Pinocchio's `SE3.Interpolate`; two `point`s (position, quaternion), then `at` share, position, quaternion.
"""
import random

import numpy
import pinocchio
from scipy.integrate import quad
from scipy.interpolate import BSpline, make_smoothing_spline
from scipy.spatial.transform import Rotation, RotationSpline, Slerp

random.seed(14)
# The iteration of angular velocities to the end.
RotationSpline.TOL, RotationSpline.MAX_ITER = 1e-15, 1000


def row(kind, case, what, numbers):
    print(f"{kind},{case},{what},{','.join(repr(float(x)) for x in numpy.ravel(numbers))}")


def uniform(low, high):
    return round(random.uniform(low, high), 4)


def vector(size, most):
    return [uniform(-most, most) for _ in range(size)]


def rising(count):
    return numpy.cumsum([0.0] + [uniform(0.1, 2.0) for _ in range(count - 1)])


def inside(knots, count):
    return numpy.linspace(knots[0], knots[-1], count)


print("kind,case,what,numbers")
for case in range(12):
    knots = rising(random.choice([5, 6, 9, 20]))
    points = numpy.array([vector(3, 2.0) for _ in knots])
    weights = numpy.array([uniform(0.2, 3.0) for _ in knots])
    smooth = 10.0 ** uniform(-4, 3) if case else 0.0
    spline = make_smoothing_spline(knots, points, weights, lam=smooth)
    row("smoothing", case, "knots", knots)
    for point in points:
        row("smoothing", case, "point", point)
    row("smoothing", case, "weights", weights)
    row("smoothing", case, "lambda", [smooth])
    for u in inside(knots, 15):
        row("smoothing", case, "at", [u, *spline(u), *spline(u, 1), *spline(u, 2)])

for case in range(10):
    knots = rising(random.choice([2, 3, 5, 8]))
    turns, rotation = [Rotation.identity()], Rotation.from_rotvec(vector(3, 1.0))
    points = []
    for _ in knots:
        points.append(rotation.as_quat())
        rotation = rotation * Rotation.from_rotvec(vector(3, 0.9))
    spline = RotationSpline(knots, Rotation.from_quat(points))
    row("rotation", case, "knots", knots)
    for point in points:
        row("rotation", case, "point", point)
    for u in inside(knots, 23):
        row("rotation", case, "at", [u, *spline(u).as_quat(), *spline(u, 1), *spline(u, 2)])

for case in range(10):
    degree = random.choice([1, 2, 3, 5])
    count = degree + random.choice([1, 2, 5])
    inner = sorted(uniform(0.1, 2.9) for _ in range(count - degree - 1))
    knots = [0.0] * (degree + 1) + inner + [3.0] * (degree + 1)
    points = [vector(3, 1.0) for _ in range(count)]
    weights = [uniform(0.3, 3.0) for _ in range(count)]
    lifted = BSpline(knots, [[*(w * numpy.array(p)), w] for p, w in zip(points, weights)], degree)

    def at(u):
        a, b, c = lifted(u), lifted(u, 1), lifted(u, 2)
        value = a[:3] / a[3]
        first = (b[:3] - b[3] * value) / a[3]
        return value, first, (c[:3] - 2 * b[3] * first - c[3] * value) / a[3]

    row("nurbs", case, "degree", [degree])
    row("nurbs", case, "knots", knots)
    for point in points:
        row("nurbs", case, "point", point)
    row("nurbs", case, "weights", weights)
    for u in inside(knots, 19):
        row("nurbs", case, "at", [u, *at(u)[0], *at(u)[1], *at(u)[2]])
    parts = sorted(set(knots))
    speed = lambda u: numpy.linalg.norm(at(u)[1])
    total = sum(quad(speed, a, b, epsabs=1e-13, epsrel=1e-13, limit=500)[0] for a, b in zip(parts, parts[1:]))
    row("nurbs", case, "length", [total])

for case in range(10):
    ends = [Rotation.from_rotvec(vector(3, 1.7)) for _ in range(2)]
    slerp = Slerp([0.0, 1.0], Rotation.concatenate(ends))
    for end in ends:
        row("slerp", case, "point", end.as_quat())
    for s in numpy.linspace(0.0, 1.0, 9):
        row("slerp", case, "at", [s, *slerp(s).as_quat()])

for case in range(10):
    # From half a turn down to a turn of 1e-6.
    size = 1.7 if case < 6 else 10.0 ** (4 - case)
    first = Rotation.from_rotvec(vector(3, 1.7))
    rotations = [first, first * Rotation.from_rotvec(numpy.array(vector(3, 1.0)) * size)]
    places = [vector(3, 1.0), vector(3, 1.0)]
    ends = [pinocchio.SE3(r.as_matrix(), numpy.array(p)) for r, p in zip(rotations, places)]
    for place, rotation in zip(places, rotations):
        row("screw", case, "point", [*place, *rotation.as_quat()])
    for s in numpy.linspace(0.0, 1.0, 9):
        pose = pinocchio.SE3.Interpolate(ends[0], ends[1], float(s))
        row("screw", case, "at", [s, *pose.translation, *Rotation.from_matrix(pose.rotation).as_quat()])

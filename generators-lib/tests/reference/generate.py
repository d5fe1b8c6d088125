#!/usr/bin/env python3
"""Reference spans of cubic splines, from scipy.interpolate.CubicSpline (pip install scipy==1.17.1).

usage: python3 generate.py        writes windows.csv (A), chain.csv (B), global.csv (D) beside points.csv
"""
import csv
import pathlib

import numpy as np
from scipy.interpolate import CubicSpline

HERE = pathlib.Path(__file__).parent
COLUMNS = "dataset,param,ends,start,u,x,y,z,dx,dy,dz,ddx,ddy,ddz".split(",")
ALPHA = {"uniform": 0.0, "centripetal": 0.5, "chord": 1.0}


def datasets():
    sets = {}
    with open(HERE / "points.csv") as file:
        for row in csv.DictReader(file):
            sets.setdefault(row["dataset"], []).append([float(row[k]) for k in "xyz"])
    return {name: np.array(points) for name, points in sets.items()}


def knots(points, param):
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1) ** ALPHA[param]
    return np.concatenate([[0.0], np.cumsum(steps)])


def rows(spline, t, span, label, start, us):
    for u in us:
        at = t[span] + u * (t[span + 1] - t[span])
        # Derivatives at a span's end are those of this span, not of the next one.
        piece = [
            sum(spline.c[k, span] * f * (at - t[span]) ** p for k, f, p in terms)
            for terms in (
                [(0, 1, 3), (1, 1, 2), (2, 1, 1), (3, 1, 0)],
                [(0, 3, 2), (1, 2, 1), (2, 1, 0)],
                [(0, 6, 1), (1, 2, 0)],
            )
        ]
        yield [*label, start, u, *(f"{x:.17g}" for part in piece for x in part)]


def windows(points, param, label):
    t, p = knots(points, param)[:8], points[:8]
    first, last = (p[1] - p[0]) / (t[1] - t[0]), (p[-1] - p[-2]) / (t[-1] - t[-2])
    natural = (2, np.zeros(3))
    cases = {
        "natural": (natural, natural),
        "not-a-knot": ("not-a-knot", "not-a-knot"),
        "slope/natural": ((1, first), natural),
        "slope/slope": ((1, first), (1, last)),
    }
    for ends, condition in cases.items():
        yield from rows(CubicSpline(t, p, bc_type=condition), t, 0, [*label, ends], 0, (0.0, 0.25, 0.5, 1.0))


def chain(points, param, label):
    t, natural, slope = knots(points, param), (2, np.zeros(3)), None
    for i in range(len(points) - 1):
        window = slice(i, min(i + 8, len(points)))
        start = natural if slope is None else (1, slope)
        spline = CubicSpline(t[window] - t[i], points[window], bc_type=(start, natural))
        yield from rows(spline, t[window] - t[i], 0, [*label, "carried"], i, (0.5, 1.0))
        slope = spline(t[i + 1] - t[i], 1)


def whole(points, param, label):
    t, natural = knots(points, param), (2, np.zeros(3))
    spline = CubicSpline(t, points, bc_type=(natural, natural))
    for i in range(len(points) - 1):
        yield from rows(spline, t, i, [*label, "natural"], i, (0.5,))


for name, kind in (("windows", windows), ("chain", chain), ("global", whole)):
    with open(HERE / f"{name}.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(COLUMNS)
        for dataset, points in datasets().items():
            for param in ALPHA:
                out.writerows(kind(points, param, [dataset, param]))

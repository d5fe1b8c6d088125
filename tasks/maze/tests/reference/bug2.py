#!/usr/bin/env python3
"""Worlds of boxes, and the bound of Bug2 for a ball among them: PyPI's shapely computes perimeters and crossings.

Writes bug2.csv: the bound D + sum n_i p_i / 2 [m] (Lumelsky and Stepanov, 1987), and the boxes [m].
D is the distance from start to goal, p_i the perimeter of obstacle i grown by the ball, n_i how often the straight line crosses that.
"""
import random

from shapely.geometry import LineString, box
from shapely.ops import unary_union

RADIUS, START, GOAL, SIDE = 0.002, (0.03, 0.05), (0.37, 0.33), 0.4
line = LineString([START, GOAL])
chance = random.Random(22)


def obstacle():
    x, y = chance.uniform(0.06, 0.28), chance.uniform(0.06, 0.28)
    w, h, t = chance.uniform(0.03, 0.1), chance.uniform(0.03, 0.1), chance.uniform(0.004, 0.012)
    kind = chance.choice(["box", "box", "L", "U", "wall"])
    if kind == "box":
        return [(x, y, x + w, y + h)]
    if kind == "wall":
        return [(x, y, x + t, y + h)] if chance.random() < 0.5 else [(x, y, x + w, y + t)]
    if kind == "L":
        return [(x, y, x + w, y + t), (x, y, x + t, y + h)]
    # Open to the left or to below: the straight line may lead into it.
    if chance.random() < 0.5:
        return [(x, y, x + w, y + t), (x, y + h, x + w, y + h + t), (x + w - t, y, x + w, y + h + t)]
    return [(x, y, x + t, y + h), (x + w, y, x + w + t, y + h), (x, y + h - t, x + w + t, y + h)]


def world():
    while True:
        shapes = [obstacle() for _ in range(chance.randint(1, 4))]
        bodies = [unary_union([box(*b) for b in boxes]) for boxes in shapes]
        apart = all(a.distance(b) > 0.022 for i, a in enumerate(bodies) for b in bodies[:i])
        inside = all(b.bounds[2] < SIDE - 0.022 and b.bounds[3] < SIDE - 0.022 for b in bodies)
        clear = all(b.distance(LineString([p, p])) > 0.02 for b in bodies for p in (START, GOAL))
        if not (apart and inside and clear):
            continue
        grown = [b.buffer(RADIUS, quad_segs=32) for b in bodies]
        crossings = [len(getattr(c, "geoms", [c])) if not c.is_empty else 0 for c in (g.exterior.intersection(line) for g in grown)]
        if sum(crossings) == 0:
            continue
        bound = line.length + sum(n * g.exterior.length / 2 for n, g in zip(crossings, grown))
        return bound, [b for boxes in shapes for b in boxes]


with open("bug2.csv", "w", encoding="utf-8") as out:
    out.write("bound,boxes\n")
    for _ in range(40):
        bound, boxes = world()
        out.write(f"{bound:.6f}," + ";".join(" ".join(f"{v:.4f}" for v in b) for b in boxes) + "\n")

#!/usr/bin/env python3
"""Shortest paths of a ball in the mazes of this folder, by shapely and pyvisgraph: writes shortest.csv.

    python3 -m venv venv && venv/bin/pip install pyvisgraph shapely tqdm && venv/bin/python shortest.py

Walls are inflated as `src/shortest.rs` does: each box by the ball's radius, with three vertices at each corner; then united by shapely.
The goal is a point here: the middle of its cell.
"""
import math
import pathlib

import pyvisgraph as vg
from shapely.geometry import Polygon, box
from shapely.ops import unary_union

PITCH, THICKNESS, RADIUS = 0.025, 0.002, 0.002
HERE = pathlib.Path(__file__).parent


def inflated(x0, y0, x1, y1):
    d = RADIUS * math.sqrt(0.5)
    r = RADIUS
    return Polygon([
        (x0 - r, y0), (x0 - d, y0 - d), (x0, y0 - r), (x1, y0 - r), (x1 + d, y0 - d), (x1 + r, y0),
        (x1 + r, y1), (x1 + d, y1 + d), (x1, y1 + r), (x0, y1 + r), (x0 - d, y1 + d), (x0 - r, y1),
    ])


def read(path):
    lines = path.read_text().splitlines()
    rows, columns = len(lines) // 2, len(lines[0]) // 4
    walls, places = [], {}
    h = THICKNESS / 2
    for number, line in enumerate(lines):
        y = (rows - number / 2) * PITCH
        for x in range(columns + 1):
            left = x * PITCH
            if number % 2 == 0 and line[4 * x + 1:4 * x + 4] == "---":
                walls.append(inflated(left - h, y - h, left + PITCH + h, y + h))
            if number % 2 == 1:
                if line[4 * x:4 * x + 1] == "|":
                    walls.append(inflated(left - h, y - PITCH / 2 - h, left + h, y + PITCH / 2 + h))
                mark = line[4 * x + 2:4 * x + 3]
                if mark in "SG" and mark:
                    places[mark] = (left + PITCH / 2, y)
    return unary_union(walls), places, columns * PITCH, rows * PITCH


def main():
    out = ["maze,length"]
    for path in sorted(HERE.glob("*.txt")):
        walls, places, width, height = read(path)
        polygons = walls.geoms if walls.geom_type == "MultiPolygon" else [walls]
        rings = []
        for polygon in polygons:
            # What is outside of the frame is of no interest; its holes are where the ball may be.
            if not polygon.bounds[0] < 0:
                rings.append(polygon.exterior)
            rings.extend(polygon.interiors)
        graph = vg.VisGraph()
        graph.build([[vg.Point(round(x, 12), round(y, 12)) for x, y in ring.coords[:-1]] for ring in rings], status=False)
        way = graph.shortest_path(vg.Point(*places["S"]), vg.Point(*places["G"]))
        length = sum(math.dist((a.x, a.y), (b.x, b.y)) for a, b in zip(way, way[1:]))
        out.append(f"{path.stem},{length:.12f}")
    (HERE / "shortest.csv").write_text("\n".join(out) + "\n")


main()

#!/usr/bin/env python3
"""Shortest paths of a ball in the mazes of this folder, by shapely: writes shortest.csv.

    python3 -m venv venv && venv/bin/pip install shapely && venv/bin/python shortest.py

Walls are inflated as `src/shortest.rs` does: each box by the ball's radius, with three vertices at each corner; then united by shapely. Of the
vertices of the union each pair is tried, whether the line between them keeps out of it, and Dijkstra's algorithm finds the shortest way.
(pyvisgraph 0.2 was tried first: it gave ways through walls here.)
The goal is a point here: the middle of its cell.
"""
import heapq
import math
import pathlib

from shapely import prepare
from shapely.geometry import LineString, Polygon
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
            if number % 2 == 0:
                walls.append(inflated(left - h, y - h, left + h, y + h))
            if number % 2 == 0 and line[4 * x + 1:4 * x + 4] == "---":
                walls.append(inflated(left - h, y - h, left + PITCH + h, y + h))
            if number % 2 == 1:
                if line[4 * x:4 * x + 1] == "|":
                    walls.append(inflated(left - h, y - PITCH / 2 - h, left + h, y + PITCH / 2 + h))
                mark = line[4 * x + 2:4 * x + 3]
                if mark in "SG" and mark:
                    places[mark] = (left + PITCH / 2, y)
    return unary_union(walls), places, columns * PITCH, rows * PITCH


def shortest(walls, start, goal):
    inside = walls.buffer(-1e-10)
    prepare(inside)
    polygons = walls.geoms if walls.geom_type == "MultiPolygon" else [walls]
    rings = [ring for polygon in polygons for ring in [polygon.exterior, *polygon.interiors]]
    nodes = [start, goal, *{point for ring in rings for point in ring.coords}]
    best = {0: 0.0}
    queue = [(0.0, 0)]
    while queue:
        length, at = heapq.heappop(queue)
        if at == 1:
            return length
        if length > best[at]:
            continue
        for to in range(len(nodes)):
            further = length + math.dist(nodes[at], nodes[to])
            if further < best.get(to, math.inf) and not inside.intersects(LineString([nodes[at], nodes[to]])):
                best[to] = further
                heapq.heappush(queue, (further, to))
    return math.nan


def main():
    out = ["maze,length"]
    for path in sorted(HERE.glob("*.txt")):
        walls, places, width, height = read(path)
        length = shortest(walls, places["S"], places["G"])
        out.append(f"{path.stem},{length:.12f}")
    (HERE / "shortest.csv").write_text("\n".join(out) + "\n")


main()

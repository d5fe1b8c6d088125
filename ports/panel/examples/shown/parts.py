"""Writes the shapes of the links of arm.urdf beside this file: boxes of so many millimetres, as STL in text."""

from itertools import product
from pathlib import Path

# From one corner to the opposite one, in the frame of each link.
PARTS = {
    "base": ((-120, -120, 0), (120, 120, 300)),
    "upper": ((-60, -60, 0), (60, 60, 500)),
    "fore": ((-40, -40, 0), (40, 40, 400)),
}

for name, (low, high) in PARTS.items():
    lines = [f"solid {name}"]
    for axis, end in product(range(3), (0, 1)):
        others = [i for i in range(3) if i != axis]
        corners = []
        for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
            corner = [0, 0, 0]
            corner[axis] = (low, high)[end][axis]
            corner[others[0]] = (low, high)[a][others[0]]
            corner[others[1]] = (low, high)[b][others[1]]
            corners.append(corner)
        # Corners run anticlockwise as seen from outside.
        if (end == 1) == (axis == 1):
            corners.reverse()
        normal = [0, 0, 0]
        normal[axis] = 1 if end else -1
        for triangle in ((0, 1, 2), (0, 2, 3)):
            lines += [f" facet normal {normal[0]} {normal[1]} {normal[2]}", "  outer loop"]
            lines += ["   vertex {} {} {}".format(*corners[i]) for i in triangle]
            lines += ["  endloop", " endfacet"]
    Path(__file__).with_name(f"{name}.stl").write_text("\n".join([*lines, f"endsolid {name}", ""]))

"""Prints the figures of two planners beside each other: beside.py OURS THEIRS, files of JSON lines as vamp_paths.py prints them.

A ratio is ours by theirs: below 1 we are faster, or shorter. Exits with 1 where a set is missing on one side.
"""

import json
import sys

TIMES = [(f"{name}_us", f"{name} [us]", of) for name in ("plan", "simplify", "total", "wall") for of in ("median", "p95")]
COSTS = [(f"cost_{name}", f"length {name} [rad]", of) for name in ("before", "after") for of in ("median", "mean")]


def lines(path):
    with open(path) as file:
        found = [json.loads(line) for line in file if line.startswith("{")]
    return {(line["robot"], line["set"]): line for line in found}


def value(line, key, of):
    return (line.get(key) or {}).get(of)


def main():
    ours, theirs = map(lines, sys.argv[1:])
    for key in theirs:
        if key not in ours:
            print(f"{' '.join(key)}: not planned by us")
            continue
        a, b = ours[key], theirs[key]
        print(f"{' '.join(key)}: {b['problems']} problems, solved {a['solved']:.2%} ({b['planner']} {b['solved']:.2%})")
        # All figures of all problems; of a set those that are asked for most.
        for name, title, of in TIMES + COSTS if key[1] == "all" else [TIMES[0], TIMES[1], COSTS[2]]:
            x, y = value(a, name, of), value(b, name, of)
            if x is not None and y:
                print(f"  {title} {of}: {x:.4g}, {b['planner']} {y:.4g}, ratio {x / y:.3f}")
    sys.exit(theirs.keys() != ours.keys())


if __name__ == "__main__":
    main()

"""Reference torques and mass matrices of the library's robots by Pinocchio (PyPI `pin`), from their exported URDFs.

Usage, with the Python of `tests/peers/dynamics/run`:
    cargo run -p mrroc-robots --example dynamics -- FOLDER 3
    python dynamics.py FOLDER > dynamics.csv
Columns: robot, q, qdot, qddot, the tip's wrench, tau, M column by column; of RNT: q, qdot, h, M. As in the example.
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[3] / "tests/peers/dynamics"))
import compare  # noqa: E402

# Not those to which the example gives masses: their files have none.
LEFT_OUT = ("gantry", "palletiser", "seven_axes")

for path in sorted(pathlib.Path(sys.argv[1]).glob("*.urdf")):
    if path.stem in LEFT_OUT:
        continue
    for given, _, theirs in compare.compared(path):
        wanted = [theirs[1], theirs[0]] if path.stem == "rnt" else [theirs[0], theirs[4]]
        numbers = [repr(float(x)) for part in (*given, *wanted) for x in part]
        print(path.stem, *numbers, sep=",")

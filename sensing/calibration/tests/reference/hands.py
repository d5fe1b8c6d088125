"""Tables for `calibrate tcp` and `calibrate hand-eye` by SciPy's rotations, with one mistake each: writes hands.json beside this file.

The camera is at (40, -25, 90) mm on the flange, turned by the rotation vector (0.3, -0.2, 1.1) rad; the tip at (10, -8, 150) mm. Noise is 0.3 mm and 1 mrad of the
board, and 0.2 mm of the tip. Needs numpy and scipy from PyPI.
"""

import json
import pathlib

import numpy
from scipy.spatial.transform import Rotation


def product(a, b):
    return (a[0] * b[0], a[1] + a[0].apply(b[1]))


def inverse(a):
    return (a[0].inv(), -a[0].inv().apply(a[1]))


CAMERA = (Rotation.from_rotvec([0.3, -0.2, 1.1]), numpy.array([0.04, -0.025, 0.09]))
BOARD = (Rotation.from_euler("xyz", [0.05, -0.1, 0.4]), numpy.array([0.65, 0.1, 0.02]))
TIP, POINT = numpy.array([0.01, -0.008, 0.15]), numpy.array([0.5, 0.1, 0.05])
random = numpy.random.default_rng(1)


def noisy(pose, length, angle):
    return (pose[0] * Rotation.from_rotvec(random.normal(0, angle, 3)), pose[1] + random.normal(0, length, 3))


def downwards(yaw, pitch, roll):
    return Rotation.from_euler("zyx", [yaw, pitch, numpy.pi + roll])


def touching(turns):
    return [(turn, POINT - turn.apply(TIP) + random.normal(0, 2e-4, 3)) for turn in turns]


# How numbers write an orientation, and the names of their columns.
NAMES = {"vector": "rx_rad,ry_rad,rz_rad", "quaternion": "qw,qx,qy,qz", "angles": "a_deg,b_deg,c_deg"}
FORMS = {
    "vector": ("vector", lambda r: r.as_rotvec()),
    "vector in degrees": ("vector", lambda r: numpy.degrees(r.as_rotvec())),
    "roll, pitch, yaw": ("vector", lambda r: r.as_euler("xyz")),
    "wxyz": ("quaternion", lambda r: numpy.roll(r.as_quat(), 1)),
    "xyzw": ("quaternion", lambda r: r.as_quat()),
    "zyx": ("angles", lambda r: r.as_euler("ZYX", degrees=True)),
    "zyx in radians": ("angles", lambda r: r.as_euler("ZYX")),
    "xyz": ("angles", lambda r: r.as_euler("XYZ", degrees=True)),
}


def table(flanges, form="zyx", boards=None, board_form="vector", factor=1.0):
    parts = [("", form, flanges, 1.0)] + ([("board_", board_form, boards, factor)] if boards else [])
    names = [prefix + name for prefix, form, _, _ in parts for name in ("x_mm,y_mm,z_mm," + NAMES[FORMS[form][0]]).split(",")]
    lines = [",".join(names)]
    for i in range(len(flanges)):
        row = []
        for _, form, poses, scale in parts:
            row += [*(1e3 * scale * poses[i][1]), *FORMS[form][1](poses[i][0])]
        lines.append(",".join(f"{number:.6f}" for number in row))
    return "\n".join(lines) + "\n"


def at(index, pose, poses):
    return [pose if i == index else own for i, own in enumerate(poses)]


def main():
    flanges = []
    for _ in range(12):
        yaw, (pitch, roll) = random.uniform(-0.8, 0.8), random.uniform(-0.5, 0.5, 2)
        flanges.append((downwards(yaw, pitch, roll), random.uniform([0.4, -0.2, 0.3], [0.7, 0.2, 0.6])))
    boards = [noisy(product(inverse(product(flange, CAMERA)), BOARD), 3e-4, 1e-3) for flange in flanges]
    flipped = (boards[3][0] * Rotation.from_rotvec([0, 0, numpy.pi]), boards[3][1])
    beside = (boards[7][0], boards[7][1] + [0.03, 0, 0])
    turns = [downwards(*turn) for turn in [(0, 0, 0), (0.6, 0.2, 0), (-0.5, 0, 0.5), (0.2, -0.5, 0.3), (1.2, 0.4, -0.4), (-1, 0.1, -0.5)]]
    tips = touching(turns)
    hand_eye = {
        "right": table(flanges, "zyx", boards),
        "2.3 % too long": table(flanges, "zyx", boards, factor=1.023),
        "in m": table(flanges, "zyx", boards, factor=1e-3),
        "--angles xyz": table(flanges, "xyz", boards),
        "angles of the flange are radians": table(flanges, "zyx in radians", boards),
        "angles of the board are degrees": table(flanges, "zyx", boards, "vector in degrees"),
        "of the flange have the scalar w last": table(flanges, "xyzw", boards),
        "of the board have the scalar w last": table(flanges, "zyx", boards, "xyzw"),
        "fixed axes": table(flanges, "zyx", boards, "roll, pitch, yaw"),
        "the board's poses are inverse": table(flanges, "zyx", [inverse(board) for board in boards]),
        "eye-to-hand": table([inverse(flange) for flange in flanges], "zyx", boards),
        "line 5 does not fit": table(flanges, "zyx", at(3, flipped, boards)),
        "line 9 does not fit": table(flanges, "zyx", at(7, beside, boards)),
        "one row below": table(flanges, "zyx", boards[-1:] + boards[:-1]),
    }
    off = (tips[2][0], tips[2][1] + [0.02, 0, 0])
    tcp = {
        "right": table(tips),
        "--angles xyz": table(tips, "xyz"),
        "the scalar w last": table(tips, "xyzw"),
        "angles of the flange are degrees": table(tips, "vector in degrees"),
        "line 4 does not fit": table(at(2, off, tips)),
    }
    for degrees in (1.1, 3, 30):
        a = numpy.radians(degrees)
        tcp[f"{degrees} degrees"] = table(touching([downwards(*turn) for turn in [(0, 0, 0), (0, 0, a), (0, 0, -a), (0, a, 0), (0, -a, 0)]]))
    here = pathlib.Path(__file__)
    here.with_suffix(".json").write_text(json.dumps({"hand-eye": hand_eye, "tcp": tcp}, indent=1) + "\n")


main()

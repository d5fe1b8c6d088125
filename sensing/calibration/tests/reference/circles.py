"""Grids of circles: rendered photos, and what OpenCV makes of them.

    circles.py FOLDER                   renders ten photos each of circles:7x6:25mm and asymmetric-circles:4x11:20mm into FOLDER/straight and FOLDER/shifted
    circles.py FOLDER KIND CORNERS LENS compares what `calibrate camera --corners CORNERS --out LENS` has found in these with the truth and with OpenCV

The camera is that of tilted.py, with a lens that does not distort. Needs numpy, scipy and opencv-python-headless from PyPI.
"""

import csv
import pathlib
import sys
import tomllib

import cv2
import numpy
from scipy.spatial.transform import Rotation

CAMERA = numpy.array([[1000, 0, 639.5], [0, 1000, 479.5], [0, 0, 1.0]])
SIZE, FINER, PIXELS = (1280, 960), 4, 4000  # pixels of the drawn board for a metre
KINDS = {"straight": ((7, 6), 0.025, 0.008), "shifted": ((4, 11), 0.02, 0.0075)}


def points(kind):
    (across, down), step, _ = KINDS[kind]
    shifted = kind == "shifted"
    return numpy.array([[(2 * i + j % 2 if shifted else i) * step, j * step, 0] for j in range(down) for i in range(across)])


def drawn(kind):
    places, rim = points(kind), 0.04
    size = ((places.max(axis=0) + 2 * rim) * PIXELS).astype(int)
    board = numpy.full((size[1], size[0]), 235, numpy.uint8)
    for x, y, _ in places:
        middle = ((x + rim) * PIXELS, (y + rim) * PIXELS)
        fixed = tuple(int(round(number * 256)) for number in middle)
        cv2.circle(board, fixed, int(KINDS[kind][2] * PIXELS * 256), 25, -1, cv2.LINE_AA, 8)
    return board, rim


def photo(kind, turn, place, seed):
    board, rim = drawn(kind)
    to_metres = numpy.array([[1 / PIXELS, 0, -rim], [0, 1 / PIXELS, -rim], [0, 0, 1.0]])
    half = (FINER - 1) / 2
    finer = numpy.array([[FINER, 0, half], [0, FINER, half], [0, 0, 1.0]])
    plane = finer @ CAMERA @ numpy.column_stack([turn[:, 0], turn[:, 1], place]) @ to_metres
    size = (SIZE[0] * FINER, SIZE[1] * FINER)
    image = cv2.warpPerspective(board, plane, size, borderMode=cv2.BORDER_CONSTANT, borderValue=110)
    image = cv2.resize(image, SIZE, interpolation=cv2.INTER_AREA).astype(float)
    image += numpy.random.default_rng(seed).normal(0, 2, image.shape)
    seen = (turn @ points(kind).T).T + place
    truth = seen[:, :2] / seen[:, 2:] * 1000 + CAMERA[:2, 2]
    return numpy.clip(image, 0, 255).astype(numpy.uint8), truth


def held(kind, count, tilt=30):
    random = numpy.random.default_rng(7)
    middle = points(kind).mean(axis=0)
    for i in range(count):
        about = 2 * numpy.pi * i / count
        tilted = Rotation.from_rotvec(numpy.radians(tilt) * numpy.array([numpy.cos(about), numpy.sin(about), 0]))
        turn = (tilted * Rotation.from_rotvec([0, 0, random.uniform(-0.6, 0.6)])).as_matrix()
        x, y, z = random.uniform(-0.05, 0.05), random.uniform(-0.03, 0.03), random.uniform(0.36, 0.45)
        yield turn, numpy.array([x, y, z]) - turn @ middle


def opencv(kind, image):
    flag = cv2.CALIB_CB_ASYMMETRIC_GRID if kind == "shifted" else cv2.CALIB_CB_SYMMETRIC_GRID
    found, middles = cv2.findCirclesGrid(image, KINDS[kind][0], flags=flag)
    return middles.reshape(-1, 2) if found else None


def nearest(seen, truth):
    return numpy.array([numpy.linalg.norm(truth - one, axis=1).min() for one in seen])


def rms(numbers):
    return float(numpy.sqrt(numpy.mean(numpy.square(numbers))))


def main():
    folder = pathlib.Path(sys.argv[1])
    if len(sys.argv) == 2:
        for kind in KINDS:
            (folder / kind).mkdir(parents=True, exist_ok=True)
            for i, pose in enumerate(held(kind, 10)):
                cv2.imwrite(str(folder / kind / f"{i:02}.png"), photo(kind, *pose, i)[0])
        return
    kind, corners, lens = sys.argv[2:]
    own = {}
    for row in csv.DictReader(open(corners)):
        own.setdefault(pathlib.Path(row["photo"]).name, []).append([float(row["u_px"]), float(row["v_px"])])
    off, theirs, boards, seen = [], [], [], []
    for i, pose in enumerate(held(kind, 10)):
        image, truth = photo(kind, *pose, i)
        off += list(nearest(numpy.array(own[f"{i:02}.png"]), truth))
        if (middles := opencv(kind, image)) is not None:
            theirs += list(nearest(middles, truth))
            boards.append(points(kind).astype(numpy.float32))
            seen.append(middles.astype(numpy.float32))
    result, matrix, *_ = cv2.calibrateCamera(boards, seen, SIZE, None, None)
    mine = tomllib.load(open(lens, "rb"))
    print(f"middles: {rms(off):.3f} px rms from the truth, OpenCV {rms(theirs):.3f} ({len(seen)} photos of 10)")
    print(f"fx, fy, cx, cy: {mine['focal']} {mine['centre']}, truly 1000, 1000, 639.5, 479.5")
    print(f"OpenCV: {matrix[0, 0]:.3f} {matrix[1, 1]:.3f} {matrix[0, 2]:.3f} {matrix[1, 2]:.3f}, {result:.3f} px rms left")


main()

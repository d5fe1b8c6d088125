"""Corners that OpenCV sees in rendered photos of a chessboard that is tilted by 0, 2 and 30 degrees: writes tilted.csv beside this file.

The camera has fx = fy = 1000 pixels, its centre at (639.5, 479.5), 1280 x 960 pixels and no distortion. Each photo is rendered three times finer, averaged, and has
noise of 2 grey values. Needs numpy, scipy and opencv-python-headless from PyPI.
"""

import csv
import pathlib

import cv2
import numpy
from scipy.spatial.transform import Rotation

CAMERA = numpy.array([[1000, 0, 639.5], [0, 1000, 479.5], [0, 0, 1.0]])
SIZE, FINER = (1280, 960), 3
SHAPE, SQUARE = (9, 6), 0.025
PIXELS = 40  # of a square of the drawn board


def drawn():
    board = numpy.full(((SHAPE[1] + 3) * PIXELS, (SHAPE[0] + 3) * PIXELS), 255, numpy.uint8)
    for j in range(SHAPE[1] + 1):
        for i in range(SHAPE[0] + 1):
            if (i + j) % 2 == 0:
                board[(j + 1) * PIXELS : (j + 2) * PIXELS, (i + 1) * PIXELS : (i + 2) * PIXELS] = 20
    return board


def photo(turn, place, seed):
    per, first = SQUARE / PIXELS, (0.5 - 2 * PIXELS) * SQUARE / PIXELS
    to_metres = numpy.array([[per, 0, first], [0, per, first], [0, 0, 1.0]])
    half = (FINER - 1) / 2
    finer = numpy.array([[FINER, 0, half], [0, FINER, half], [0, 0, 1.0]])
    plane = finer @ CAMERA @ numpy.column_stack([turn[:, 0], turn[:, 1], place]) @ to_metres
    size = (SIZE[0] * FINER, SIZE[1] * FINER)
    image = cv2.warpPerspective(drawn(), plane, size, borderMode=cv2.BORDER_CONSTANT, borderValue=110)
    image = cv2.resize(image, SIZE, interpolation=cv2.INTER_AREA).astype(float)
    image += numpy.random.default_rng(seed).normal(0, 2, image.shape)
    return numpy.clip(image, 0, 255).astype(numpy.uint8)


def main():
    middle = numpy.array([(SHAPE[0] - 1) * SQUARE / 2, (SHAPE[1] - 1) * SQUARE / 2, 0])
    ends = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 30, 0.001)
    rows = []
    for tilt in (0, 2, 30):
        random = numpy.random.default_rng(7)
        for i in range(6):
            about = 2 * numpy.pi * i / 6
            tilted = Rotation.from_rotvec(numpy.radians(tilt) * numpy.array([numpy.cos(about), numpy.sin(about), 0]))
            turn = (tilted * Rotation.from_rotvec([0, 0, random.uniform(-0.3, 0.3)])).as_matrix()
            x, y, z = random.uniform(-0.06, 0.06), random.uniform(-0.04, 0.04), random.uniform(0.33, 0.45)
            image = photo(turn, numpy.array([x, y, z]) - turn @ middle, i)
            found, corners = cv2.findChessboardCorners(image, SHAPE, None)
            assert found, (tilt, i)
            corners = cv2.cornerSubPix(image, corners, (5, 5), (-1, -1), ends)
            rows += [[tilt, i, f"{u:.4f}", f"{v:.4f}"] for u, v in corners.reshape(-1, 2)]
    with open(pathlib.Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["tilt_deg", "photo", "u_px", "v_px"])
        writer.writerows(rows)


main()

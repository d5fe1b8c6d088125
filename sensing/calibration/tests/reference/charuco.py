"""ChArUco boards: OpenCV's dictionaries, rendered photos, and what OpenCV makes of them.

    charuco.py dictionaries FILE          writes the bits of OpenCV's dictionaries, as `sensing/sensors/src/aggregation/charuco/markers.txt` has them
    charuco.py                            writes charuco.png, one photo of half the size, and charuco.csv, where its corners truly are, beside this file
    charuco.py FOLDER                     renders ten photos of charuco:8x6:30mm:22mm:DICT_5X5_100 into FOLDER
    charuco.py FOLDER CORNERS LENS        compares what `calibrate camera --corners CORNERS --out LENS` has found in these with the truth and with OpenCV

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
SIZE, FINER, PIXELS = (1280, 960), 4, 100  # pixels of a square of the drawn board
SQUARES, SQUARE, MARKER = (8, 6), 0.03, 0.022
BOARD = cv2.aruco.CharucoBoard(SQUARES, SQUARE, MARKER, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100))


def dictionaries(file):
    lines = ["# Markers of ArUco as OpenCV's predefined dictionaries have them (Apache-2.0): bits along a side, then the bits of 1000 markers, row by row, white is 1."]
    for side in (4, 5, 6, 7):
        of = lambda count: cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{side}X{side}_{count}"))
        whole = of(1000)
        # The smaller ones are the beginning of the largest.
        for count in (50, 100, 250):
            assert (of(count).bytesList == whole.bytesList[:count]).all()
        words = [str(side)]
        for row in whole.bytesList:
            bits = cv2.aruco.Dictionary.getBitsFromByteList(row[None], side).ravel()
            words.append(format(int("".join(map(str, bits)), 2), "x"))
        lines.append(" ".join(words))
    pathlib.Path(file).write_text("\n".join(lines) + "\n")


def photo(turn, place, seed, noise=2):
    rim = PIXELS
    size = (SQUARES[0] * PIXELS + 2 * rim, SQUARES[1] * PIXELS + 2 * rim)
    board = BOARD.generateImage(size, marginSize=rim)
    board = (25 + 0.82 * board).astype(numpy.uint8)
    per = SQUARE / PIXELS
    to_metres = numpy.array([[per, 0, (0.5 - rim) * per], [0, per, (0.5 - rim) * per], [0, 0, 1.0]])
    half = (FINER - 1) / 2
    finer = numpy.array([[FINER, 0, half], [0, FINER, half], [0, 0, 1.0]])
    plane = finer @ CAMERA @ numpy.column_stack([turn[:, 0], turn[:, 1], place]) @ to_metres
    size = (SIZE[0] * FINER, SIZE[1] * FINER)
    image = cv2.warpPerspective(board, plane, size, borderMode=cv2.BORDER_CONSTANT, borderValue=110)
    image = cv2.resize(image, SIZE, interpolation=cv2.INTER_AREA).astype(float)
    image += numpy.random.default_rng(seed).normal(0, noise, image.shape)
    seen = (turn @ BOARD.getChessboardCorners().T).T + place
    truth = seen[:, :2] / seen[:, 2:] * 1000 + CAMERA[:2, 2]
    return numpy.clip(image, 0, 255).astype(numpy.uint8), truth


def held(count):
    random = numpy.random.default_rng(7)
    middle = BOARD.getChessboardCorners().mean(axis=0)
    for i in range(count):
        about = 2 * numpy.pi * i / count
        tilted = Rotation.from_rotvec(numpy.radians(30) * numpy.array([numpy.cos(about), numpy.sin(about), 0]))
        turn = (tilted * Rotation.from_rotvec([0, 0, random.uniform(-0.6, 0.6)])).as_matrix()
        x, y, z = random.uniform(-0.04, 0.04), random.uniform(-0.03, 0.03), random.uniform(0.38, 0.48)
        yield turn, numpy.array([x, y, z]) - turn @ middle


def rms(numbers):
    return float(numpy.sqrt(numpy.mean(numpy.square(numbers))))


def main():
    if len(sys.argv) == 1:
        image, truth = photo(*list(held(10))[3], 3, 0)
        here = pathlib.Path(__file__)
        half = image.reshape(SIZE[1] // 2, 2, SIZE[0] // 2, 2).mean(axis=(1, 3)).round().astype(numpy.uint8)
        cv2.imwrite(str(here.with_suffix(".png")), half)
        with open(here.with_suffix(".csv"), "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["u_px", "v_px"])
            # The middle of the first pixel is that of four.
            writer.writerows([f"{u:.4f}", f"{v:.4f}"] for u, v in (truth - 0.5) / 2)
        return
    if sys.argv[1] == "dictionaries":
        return dictionaries(sys.argv[2])
    folder = pathlib.Path(sys.argv[1])
    if len(sys.argv) == 2:
        folder.mkdir(parents=True, exist_ok=True)
        for i, pose in enumerate(held(10)):
            cv2.imwrite(str(folder / f"{i:02}.png"), photo(*pose, i)[0])
        return
    own = {}
    for row in csv.DictReader(open(sys.argv[2])):
        own.setdefault(pathlib.Path(row["photo"]).name, []).append([float(row["u_px"]), float(row["v_px"])])
    off, theirs, boards, seen = [], [], [], []
    for i, pose in enumerate(held(10)):
        image, truth = photo(*pose, i)
        # In the order of OpenCV's board.
        if f"{i:02}.png" in own:
            off += list(numpy.linalg.norm(numpy.array(own[f"{i:02}.png"]) - truth, axis=1))
        corners, ids, _, _ = cv2.aruco.CharucoDetector(BOARD).detectBoard(image)
        if ids is not None:
            theirs += list(numpy.linalg.norm(corners.reshape(-1, 2) - truth[ids.ravel()], axis=1))
            boards.append(BOARD.getChessboardCorners()[ids.ravel()])
            seen.append(corners)
    result, matrix, *_ = cv2.calibrateCamera(boards, seen, SIZE, None, None)
    mine = tomllib.load(open(sys.argv[3], "rb"))
    print(f"corners: {len(off)}, {rms(off):.3f} px rms from the truth, OpenCV {len(theirs)}, {rms(theirs):.3f}")
    print(f"fx, fy, cx, cy: {mine['focal']} {mine['centre']}, truly 1000, 1000, 639.5, 479.5")
    print(f"OpenCV: {matrix[0, 0]:.3f} {matrix[1, 1]:.3f} {matrix[0, 2]:.3f} {matrix[1, 2]:.3f}, {result:.3f} px rms left")


main()

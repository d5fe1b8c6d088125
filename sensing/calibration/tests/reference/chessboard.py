"""Corners of chessboards and intrinsics by OpenCV, from photos.

    chessboard.py FOLDER                    writes chessboard.csv and chessboard.json beside this file, from FOLDER/left*.jpg
    chessboard.py FOLDER CORNERS LENS       compares what `calibrate camera --corners CORNERS --out LENS` has found in these

The photos are left01.jpg to left14.jpg of Debian's package opencv-doc. Needs numpy and opencv-python-headless from PyPI.
"""

import csv
import json
import pathlib
import sys
import tomllib

import cv2
import numpy

ENDS = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 30, 0.001)
SHAPE = (9, 6)
SQUARE = 0.025


def photos(folder):
    for file in sorted(pathlib.Path(folder).glob("left[0-9]*.jpg")):
        image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
        found, corners = cv2.findChessboardCorners(image, SHAPE, None)
        if found:
            yield file.name, image, corners


def intrinsics(size, corners):
    board = numpy.zeros((SHAPE[0] * SHAPE[1], 3), numpy.float32)
    board[:, :2] = SQUARE * numpy.mgrid[0 : SHAPE[0], 0 : SHAPE[1]].T.reshape(-1, 2)
    rms, matrix, lens, _, _, sigma, _, left = cv2.calibrateCameraExtended(
        [board] * len(corners), [one.astype(numpy.float32) for one in corners], size, None, None
    )
    k1, k2, p1, p2, k3 = lens.ravel()
    values = [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], k1, k2, p1, p2, k3]
    return {"rms": rms, "values": values, "sigmas": sigma.ravel()[:9].tolist(), "left": left.ravel().tolist()}


def refined(image, corners, window):
    return cv2.cornerSubPix(image, corners.copy(), (window, window), (-1, -1), ENDS)


def write(folder):
    here = pathlib.Path(__file__).parent
    rows, seen = [], []
    for name, image, corners in photos(folder):
        # As OpenCV's tutorial has it: windows of 23 pixels for all.
        corners = refined(image, corners, 11)
        seen.append(corners)
        rows += [[name, i, f"{u:.4f}", f"{v:.4f}"] for i, (u, v) in enumerate(corners.reshape(-1, 2))]
    with open(here / "chessboard.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["photo", "corner", "u_px", "v_px"])
        writer.writerows(rows)
    # From the corners as they are written.
    seen = numpy.array([[float(u), float(v)] for _, _, u, v in rows]).reshape(len(seen), -1, 1, 2)
    found = intrinsics((image.shape[1], image.shape[0]), seen)
    (here / "chessboard.json").write_text(json.dumps(found, indent=1) + "\n")
    print(f"OpenCV {cv2.__version__}: {len(seen)} photos, {found['rms']:.4f} px rms")


def compare(folder, corners, lens):
    own = {}
    for row in csv.DictReader(open(corners)):
        own.setdefault(pathlib.Path(row["photo"]).name, []).append([float(row["u_px"]), float(row["v_px"])])
    same, usual, missed, tutorial = [], [], [], []
    for name, image, corners in photos(folder):
        if name not in own:
            missed.append(name)
            continue
        mine = numpy.array(own[name])
        grid = mine.reshape(SHAPE[1], SHAPE[0], 2)
        across = numpy.linalg.norm(numpy.diff(grid, axis=1), axis=2)
        down = numpy.linalg.norm(numpy.diff(grid, axis=0), axis=2)
        far = numpy.full(grid.shape[:2], numpy.inf)
        far[:, 1:], far[:, :-1] = numpy.minimum(far[:, 1:], across), numpy.minimum(far[:, :-1], across)
        far[1:], far[:-1] = numpy.minimum(far[1:], down), numpy.minimum(far[:-1], down)
        windows = numpy.clip((0.3 * far.ravel()).astype(int), 2, 11)
        tutorial.append(refined(image, corners, 11))
        nearest = [numpy.argmin(numpy.linalg.norm(corners.reshape(-1, 2) - one, axis=1)) for one in mine]
        assert sorted(nearest) == list(range(len(mine))), f"{name}: not the same corners"
        for one, window, at in zip(mine, windows, nearest):
            theirs = refined(image, corners[at : at + 1], int(window)).ravel()
            same.append(numpy.linalg.norm(theirs - one))
            usual.append(numpy.linalg.norm(tutorial[-1][at].ravel() - one))
    size = (image.shape[1], image.shape[0])
    theirs = intrinsics(size, tutorial)
    mine = tomllib.load(open(lens, "rb"))
    same, usual = numpy.array(same), numpy.array(usual)
    print(f"OpenCV {cv2.__version__}: {len(own)} photos, not found {missed or 'none'}, {len(same)} corners")
    print(f"corners, window as here:  within 0.1 px {(same < 0.1).mean():.1%}, median {numpy.median(same):.4f}, largest {same.max():.3f} px")
    print(f"corners, window 11:       within 0.1 px {(usual < 0.1).mean():.1%}, median {numpy.median(usual):.4f}, largest {usual.max():.3f} px")
    print(f"left: OpenCV {theirs['rms']:.4f} px rms, here {mine['left']['rms']:.4f} px rms")
    for name, a, b, sigma in zip(mine["parameters"]["names"], theirs["values"], mine["parameters"]["values"], theirs["sigmas"]):
        print(f"{name}: OpenCV {a:.5f} (sigma {sigma:.5f}), here {b:.5f}")
    good = not missed and same.max() < 0.1 and mine["left"]["rms"] <= theirs["rms"]
    print("as OpenCV" if good else "NOT as OpenCV")
    return 0 if good else 1


if __name__ == "__main__":
    if len(sys.argv) == 2:
        write(sys.argv[1])
    elif len(sys.argv) == 4:
        sys.exit(compare(*sys.argv[1:]))
    else:
        sys.exit(__doc__)

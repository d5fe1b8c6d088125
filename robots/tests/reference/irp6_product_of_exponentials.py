"""Reference poses of the IRp-6 flange by the product of exponentials.

X(q) = exp(S1 q1) .. exp(S6 q6) X(0), with numpy and scipy's general matrix exponential: no formula is
shared with the Rust code. The screws S = (omega, -omega x point) are read off the arm at q = 0:
the lower link points forwards (theta2 = 0), the upper link hangs down from its end (theta3 = 90 deg), the
wrist link continues it (theta4 = 90 deg).

Usage: python3 irp6_product_of_exponentials.py > irp6_poses.csv
Columns: model, q1..q6 [rad], p [m], rotation matrix row by row.
"""

import numpy as np
from scipy.linalg import expm

MODELS = {"nominal": (0.455, 0.67, 0.19), "calibrated": (0.4596, 0.6729, 0.1903)}


def hat(omega, point):
    w = np.array([[0, -omega[2], omega[1]], [omega[2], 0, -omega[0]], [-omega[1], omega[0], 0]], float)
    twist = np.zeros((4, 4))
    twist[:3, :3] = w
    twist[:3, 3] = -w @ point
    return twist


def flange(model, q):
    a2, a3, d5 = MODELS[model]
    shoulder = np.zeros(3)
    elbow = np.array([a2, 0, 0])
    wrist = np.array([a2, 0, -a3])
    end = np.array([a2, 0, -a3 - d5])
    down = np.array([0, 0, -1.0])
    pitch = np.array([0, 1.0, 0])
    # At q = 0 the flange's z lies along the axis of T; its x continues the rule u = (c1 s4, .., c4) at theta4 = 90 deg.
    start = np.eye(4)
    start[:3, :3] = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], float)
    start[:3, 3] = end
    screws = [
        (np.array([0, 0, 1.0]), shoulder),
        (pitch, shoulder),
        (pitch, elbow),
        (pitch, wrist),
        (down, end),
        (start[:3, 2], end),
    ]
    pose = np.eye(4)
    for (omega, point), angle in zip(screws, q):
        pose = pose @ expm(hat(omega, point) * angle)
    return pose @ start


def main():
    random = np.random.default_rng(6)
    lower = np.radians([-170, -130, -25, -90, -180, -165])
    upper = np.radians([170, -50, 40, 92, 360, 168])
    print("model,q1,q2,q3,q4,q5,q6,px,py,pz,r11,r12,r13,r21,r22,r23,r31,r32,r33")
    for model in MODELS:
        for _ in range(200):
            q = random.uniform(lower, upper)
            pose = flange(model, q)
            values = [*q, *pose[:3, 3], *pose[:3, :3].ravel()]
            print(model + "," + ",".join(repr(float(v)) for v in values))


if __name__ == "__main__":
    main()

"""Makes the two made-up data sets of this folder: python3 make.py. Needs numpy.

What is made up is more than the model that `calibrate` fits: links that bend under their weight, encoders whose discs are off
centre, friction that leaves a joint where it came from, noise, and a row that was written down wrongly. So residuals are not
those of a perfect model, and postures that were left out tell more than those that were used.
"""

import pathlib

import numpy as np

HERE = pathlib.Path(__file__).parent


def about(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    X = np.eye(4)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    X[i, i], X[i, j], X[j, i], X[j, j] = c, -s, s, c
    return X


def shift(x, y, z):
    X = np.eye(4)
    X[:3, 3] = x, y, z
    return X


def small(rng, length, angle):
    X = shift(*rng.normal(size=3) * length)
    for axis in range(3):
        X = X @ about(axis, rng.normal() * angle)
    return X


class Arm:
    """Distal Denavit-Hartenberg rows (theta, d, a, alpha) [rad, m], with errors behind each joint."""

    def __init__(self, rng, rows, length, angle, zero, sag, eccentricity, friction):
        self.rows, n = rows, len(rows)
        self.behind = [small(rng, length, angle) @ about(2, rng.normal() * zero) for _ in rows]
        self.sag = sag
        self.eccentric = rng.normal(size=(n, 2)) * eccentricity
        self.friction = friction

    def flange(self, read, rng):
        # Friction leaves each joint on one side of where its encoder's mean says, and encoders are off centre.
        q = read + self.eccentric[:, 0] * np.cos(read) + self.eccentric[:, 1] * np.sin(read)
        q = q + self.friction * rng.choice([-1.0, 1.0], size=len(q))
        # The level links bend: by how far the flange is out, once more.
        bare = self.chain(q)
        out = np.array([np.hypot(*bare[:2, 3])] * len(q))
        return self.chain(q + self.sag * out)

    def chain(self, q):
        X = np.eye(4)
        for (theta, d, a, alpha), angle, behind in zip(self.rows, q, self.behind):
            X = X @ about(2, angle) @ behind @ about(2, theta) @ shift(0, 0, d) @ shift(a, 0, 0) @ about(0, alpha)
        return X


def quaternion(R):
    w = 0.5 * np.sqrt(max(0.0, 1.0 + np.trace(R)))
    if w > 0.1:
        return [w, (R[2, 1] - R[1, 2]) / (4 * w), (R[0, 2] - R[2, 0]) / (4 * w), (R[1, 0] - R[0, 1]) / (4 * w)]
    i = int(np.argmax(np.diag(R)))
    j, k = (i + 1) % 3, (i + 2) % 3
    x = 0.5 * np.sqrt(1.0 + R[i, i] - R[j, j] - R[k, k])
    q = [(R[k, j] - R[j, k]) / (4 * x), 0, 0, 0]
    q[1 + i], q[1 + j], q[1 + k] = x, (R[j, i] + R[i, j]) / (4 * x), (R[k, i] + R[i, k]) / (4 * x)
    return q


ARM_HEADER = """\
## Made up by make.py: an arm with six axes, a laser tracker, three balls on the flange; joints in degrees, points in mm.
# title = "six axes, 36 postures, three points"
# robot = "arm.toml"
#
# [joints]
# columns = ["q1", "q2", "q3", "q4", "q5", "q6"]
# unit = "deg"
#
## Each row measures one ball; the column `ball` says which.
# [[measures]]
# instrument = "tracker"
# kind = "point"
# columns = ["x", "y", "z"]
# unit = "mm"
# point = { column = "ball" }
"""

POSITIONER_HEADER = """\
## Made up by make.py: a table that tilts and turns, and a camera that looks at a board on it.
## Joints in rad; the board's pose in the camera in m, with a quaternion. The board was printed 1.5 % too small, which nobody has noticed.
# title = "two axes, 26 postures"
# robot = "positioner.toml"
# columns = ["tilt", "turn", "x", "y", "z", "qx", "qy", "qz", "qw", "corner_x", "corner_y", "corner_z"]
# separator = ";"
#
# [joints]
# columns = ["tilt", "turn"]
# unit = "rad"
#
# [[measures]]
# instrument = "camera"
# kind = "pose"
# rotation = "quaternion xyzw"
# columns = ["x", "y", "z", "qx", "qy", "qz", "qw"]
# unit = "m"
# point = "board"
#
## The far corner of the board, by the same pictures.
# [[measures]]
# instrument = "camera"
# kind = "point"
# columns = ["corner_x", "corner_y", "corner_z"]
# unit = "m"
# point = "corner"
#
## By a ruler.
# [[distances]]
# between = ["board", "corner"]
# length = 0.3546
# sigma = 0.0002
# unit = "m"
"""

ROWS = [
    (0.0, 0.29, 0.0, -np.pi / 2),
    (-np.pi / 2, 0.0, 0.27, 0.0),
    (0.0, 0.0, 0.07, -np.pi / 2),
    (0.0, 0.302, 0.0, np.pi / 2),
    (0.0, 0.0, 0.0, -np.pi / 2),
    (np.pi, 0.072, 0.0, 0.0),
]


def arm():
    rng = np.random.default_rng(20261124)
    arm = Arm(rng, ROWS, 4e-4, 8e-4, 6e-3, np.array([0, 3e-4, 2e-4, 0, 0, 0]), 8e-5, 4e-5)
    tracker = shift(1.9, -0.8, 0.35) @ about(2, 2.3) @ about(0, 0.02)
    base = np.linalg.inv(tracker)
    balls = np.array([[0.062, 0.003, 0.055], [-0.034, 0.051, 0.021], [-0.029, -0.055, 0.094]])
    low, high = np.radians([-150, -70, -80, -150, -100, -170]), np.radians([150, 80, 50, 150, 100, 170])
    for name, count, wrong in (("arm.csv", 36, 17), ("arm_unseen.csv", 30, None)):
        lines = [ARM_HEADER, "pose,ball,q1,q2,q3,q4,q5,q6,x,y,z\n"]
        for pose in range(count):
            degrees = np.round(np.degrees(rng.uniform(low, high)), 3)
            X = base @ arm.flange(np.radians(degrees), rng)
            for i, ball in enumerate(balls):
                p = 1e3 * (X[:3, :3] @ ball + X[:3, 3]) + rng.normal(size=3) * 0.02
                if pose == wrong and i == 1:
                    p[1] += 6.0
                cells = [f"{pose + 1}", "ABC"[i]] + [f"{q:.3f}" for q in degrees] + [f"{v:.4f}" for v in p]
                lines.append(",".join(cells) + "\n")
        (HERE / name).write_text("".join(lines))
    rows = "".join(
        f"[[joints]]\ntheta = {np.degrees(t):g}\nd = {1e3 * d:g}\na = {1e3 * a:g}\nalpha = {np.degrees(alpha):g}\n\n"
        for t, d, a, alpha in ROWS
    )
    head = 'name = "six-axis arm"\nconvention = "distal"\nlength_unit = "mm"\nangle_unit = "deg"\n\n'
    (HERE / "arm.toml").write_text("# Made up by make.py: a small arm as designed.\n" + head + rows.rstrip() + "\n")


def positioner():
    rng = np.random.default_rng(7)
    rows = [(0.0, 0.0, 0.0, np.pi / 2), (0.0, 0.15, 0.0, 0.0)]
    table = Arm(rng, rows, 5e-4, 1e-3, 0.0, np.array([2e-3, 0.0]), 2e-4, 1e-4)
    camera = shift(0.1, -0.4, 1.1) @ about(0, 2.7) @ about(2, 0.3)
    board = shift(-0.08, 0.06, 0.01) @ about(2, 0.5)
    corner = board @ np.array([0.27, 0.2299, 0.0, 1.0])
    lines = [POSITIONER_HEADER]
    for _ in range(26):
        q = np.round(rng.uniform([-0.9, -2.8], [0.9, 2.8]), 5)
        X = np.linalg.inv(camera) @ table.flange(q, rng)
        seen = X @ board
        # The camera believes the board larger than it is, and so farther away.
        p = (seen[:3, 3] + rng.normal(size=3) * [1e-4, 1e-4, 2e-4]) / 0.985
        c = ((X @ corner)[:3] + rng.normal(size=3) * [1e-4, 1e-4, 2e-4]) / 0.985
        turn = np.eye(4)
        for axis in range(3):
            turn = turn @ about(axis, rng.normal() * 3e-4)
        w, x, y, z = quaternion(seen[:3, :3] @ turn[:3, :3])
        cells = [f"{v:.5f}" for v in q] + [f"{v:.6f}" for v in p] + [f"{v:.7f}" for v in (x, y, z, w)]
        lines.append(";".join(cells + [f"{v:.6f}" for v in c]) + "\n")
    (HERE / "positioner.csv").write_text("".join(lines))
    (HERE / "positioner.toml").write_text(
        '# Made up by make.py: it tilts about a level axis and turns about the table\'s own.\n'
        'name = "positioner"\nconvention = "distal"\nlength_unit = "m"\nangle_unit = "deg"\n\n'
        '[[joints]]\nname = "tilt"\ntheta = 0\nd = 0\na = 0\nalpha = 90\n\n'
        '[[joints]]\nname = "turn"\ntheta = 0\nd = 0.15\na = 0\nalpha = 0\n'
    )


arm()
positioner()

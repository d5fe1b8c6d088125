"""Makes fits.json: calibration problems, and their solutions by SciPy.

    python3 fits.py [--time FOLDER]

Needs numpy and scipy. An arm with the dimensions of a small six-axis arm has errors in all places; a tracker measures three balls on its
flange, or two theodolites do. Everything is written here in another way than in the crate: homogeneous matrices, all poses at once.

With --time it measures instead what SciPy takes for the problem of 40 poses, 3 balls and 2 theodolites, and writes that problem
for the crate's own bench (tests/benches/peers/calibration).
"""

import json
import pathlib
import sys
import time

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

# theta, d, a, alpha of the distal convention [rad, m].
DH = np.array([
    [0.0, 0.29, 0.0, -np.pi / 2],
    [-np.pi / 2, 0.0, 0.27, 0.0],
    [0.0, 0.0, 0.07, -np.pi / 2],
    [0.0, 0.302, 0.0, np.pi / 2],
    [0.0, 0.0, 0.0, -np.pi / 2],
    [np.pi, 0.072, 0.0, 0.0],
])
BALLS = np.array([[0.05, 0.0, 0.06], [-0.03, 0.045, 0.03], [-0.02, -0.05, 0.09]])


def transform(vectors, turns):
    """Homogeneous matrices of shifts and rotation vectors, of any number of them."""
    turns = np.asarray(turns, float)
    out = np.zeros(turns.shape[:-1] + (4, 4))
    out[..., :3, :3] = Rotation.from_rotvec(turns.reshape(-1, 3)).as_matrix().reshape(turns.shape[:-1] + (3, 3))
    out[..., :3, 3] = vectors
    out[..., 3, 3] = 1.0
    return out


def about_z(angles):
    c, s = np.cos(angles), np.sin(angles)
    out = np.zeros(angles.shape + (4, 4))
    out[..., 0, 0], out[..., 0, 1], out[..., 1, 0], out[..., 1, 1] = c, -s, s, c
    out[..., 2, 2] = out[..., 3, 3] = 1.0
    return out


def rest(row):
    theta, d, a, alpha = row
    return transform([0, 0, d], [0, 0, theta]) @ transform([a, 0, 0], [alpha, 0, 0])


REST = np.array([rest(row) for row in DH])


def flanges(q, displacements):
    """By pose the flange in the base; the displacement stands between a joint's motion and the rest of its row."""
    X = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    behind = transform(displacements[:, :3], displacements[:, 3:]) @ REST
    for i in range(6):
        X = X @ about_z(q[:, i]) @ behind[i]
    return X


class Case:
    """A problem: which displacements are free, how far they are believed to be off, and what measures."""

    def __init__(self, seed, poses, free, tolerance, theodolites, outliers=0):
        rng = np.random.default_rng(seed)
        low = np.array([-2.5, -1.2, -1.4, -2.5, -1.8, -2.5])
        self.free, self.tolerance, self.theodolites = free, tolerance, theodolites
        self.q = rng.uniform(low, [2.5, 1.4, 0.9, 2.5, 1.8, 2.5], (poses, 6))
        self.unseen = rng.uniform(low, [2.5, 1.4, 0.9, 2.5, 1.8, 2.5], (20, 6))
        scale = np.array([5e-4] * 3 + [1e-3] * 3)
        true = rng.normal(size=(6, 6)) * scale
        true[:, 5] = rng.normal(size=6) * 5e-3
        self.base_start = np.array([1.1, 0.2, 0.05, 0.0, 0.0, 0.4])
        base = self.base_start + rng.normal(size=6) * [0.02] * 6
        self.balls_start = BALLS
        balls = BALLS + rng.normal(size=(3, 3)) * 3e-3
        self.sigma = 2e-5 if theodolites is None else 1e-5
        self.north = None
        if theodolites is not None:
            self.places = np.array(theodolites)
            self.north_start = self.places[1].copy()
            # Angles tell no lengths: the distance of the theodolites is known, how the second one is turned is not.
            self.places[1, 3:] += rng.normal(size=3) * 0.01
        x = np.concatenate([base, balls.ravel()])
        if theodolites is not None:
            x = np.concatenate([x, self.places[1, 3:]])
        read = self.predict(x, true, self.q)
        self.read = read + rng.normal(size=read.shape) * self.sigma
        for _ in range(outliers):
            self.read[rng.integers(poses), rng.integers(3)] += rng.normal(size=self.read.shape[-1]) * 4e-3

    def points(self, x, displacements, q):
        base, balls = x[:6], x[6:15].reshape(3, 3)
        X = transform(base[:3], base[3:]) @ flanges(q, displacements)
        return np.einsum("pij,bj->pbi", X[:, :3, :3], balls) + X[:, None, :3, 3]

    def predict(self, x, displacements, q):
        points = self.points(x, displacements, q)
        if self.theodolites is None:
            return points
        read = []
        for place in (self.places[0], np.concatenate([self.places[1, :3], x[15:18]])):
            inverse = np.linalg.inv(transform(place[:3], place[3:]))
            p = points @ inverse[:3, :3].T + inverse[:3, 3]
            read += [np.arctan2(p[..., 1], p[..., 0]), np.arctan2(p[..., 2], np.hypot(p[..., 0], p[..., 1]))]
        return np.stack(read, -1)

    def split(self, x):
        n = 15 if self.theodolites is None else 18
        displacements = np.zeros((6, 6))
        displacements[tuple(self.free.T)] = x[n:]
        return x[:n], displacements

    def residuals(self, x):
        frames, displacements = self.split(x)
        off = self.read - self.predict(frames, displacements, self.q)
        if self.theodolites is not None:
            off = (off + np.pi) % (2 * np.pi) - np.pi
            off[..., [0, 2]] *= np.cos(self.read[..., [1, 3]])
        off = off.ravel() / self.sigma
        if self.tolerance is not None:
            off = np.concatenate([off, x[len(frames):] / self.tolerance])
        return off

    def start(self):
        frames = [self.base_start, self.balls_start.ravel()]
        if self.theodolites is not None:
            frames.append(self.north_start[3:])
        return np.concatenate(frames + [np.zeros(len(self.free))])

    def solve(self, loss="linear", method="trf"):
        return least_squares(self.residuals, self.start(), loss=loss, method=method, x_scale="jac",
                             ftol=1e-14, xtol=1e-14, gtol=1e-14, max_nfev=500)

    def problem(self):
        out = {"dh": DH.tolist(), "q": self.q.tolist(), "unseen": self.unseen.tolist(), "read": self.read.tolist(),
               "sigma": self.sigma, "tolerance": self.tolerance, "base": self.base_start.tolist(),
               "balls": self.balls_start.tolist(), "free": self.free.tolist()}
        if self.theodolites is not None:
            out["theodolites"] = [self.places[0].tolist(), self.north_start.tolist()]
        return out


ALL = np.array([(i, axis) for i in range(6) for axis in range(6)])
# The zeros that can be told from the base and from the balls.
ZEROS = np.array([(i, 5) for i in range(1, 5)])
THEODOLITES = [[-1.5, -1.5, 0.1, 0.0, 0.0, 0.0], [-1.2, 1.9, 0.2, 0.0, 0.0, 0.0]]


def main():
    if "--time" in sys.argv:
        return measure(pathlib.Path(sys.argv[sys.argv.index("--time") + 1]))
    cases = {
        "geometry": (Case(1, 36, ALL, None, None), "linear"),
        "zeros": (Case(2, 25, ZEROS, 1e-2, None), "linear"),
        "huber": (Case(3, 36, ALL, None, None, outliers=6), "huber"),
        "cauchy": (Case(4, 36, ALL, None, None, outliers=6), "cauchy"),
        "theodolites": (Case(5, 30, ALL, None, THEODOLITES), "linear"),
    }
    told = {}
    for name, (case, loss) in cases.items():
        best = case.solve(loss)
        again = least_squares(case.residuals, best.x, loss=loss, jac="3-point", x_scale="jac", ftol=1e-15, xtol=1e-15, gtol=1e-15)
        frames, displacements = case.split(again.x)
        jacobian = least_squares(case.residuals, again.x, jac="3-point", max_nfev=1).jac
        jacobian = jacobian[: case.read.size]
        values = np.linalg.svd(jacobian / np.linalg.norm(jacobian, axis=0), compute_uv=False)
        told[name] = case.problem() | {
            "loss": loss,
            "cost": again.cost,
            "rank": int((values > 1e-8 * values[0]).sum()),
            "foretold": case.points(frames, displacements, case.unseen).tolist(),
            "displacements": displacements.tolist(),
        }
        if name == "zeros":
            covariance = np.linalg.inv(again.jac.T @ again.jac)
            told[name]["sigmas_of"] = [np.sqrt(np.diag(covariance))[-len(ZEROS):].tolist()]
        print(name, "cost", again.cost, "rank", told[name]["rank"], "of", len(values), file=sys.stderr)
    out = pathlib.Path(__file__).with_name("fits.json")
    rounded = json.loads(json.dumps(told), parse_float=lambda text: float(f"{float(text):.15g}"))
    out.write_text(json.dumps(rounded) + "\n")


def measure(folder):
    """The problem of the issue: 40 poses, 3 balls, 2 theodolites; the shortest of ten runs of each of SciPy's methods."""
    case = Case(6, 40, ALL, 1e-3, THEODOLITES)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "problem.json").write_text(json.dumps(case.problem() | {"loss": "linear"}))
    for method in ("trf", "lm"):
        times = []
        for _ in range(10):
            began = time.perf_counter()
            found = least_squares(case.residuals, case.start(), method=method, x_scale="jac")
            times.append(time.perf_counter() - began)
        print(f"scipy {method} {min(times) * 1e3:.2f} ms cost {found.cost:.6f} evaluations {found.nfev}")


main()

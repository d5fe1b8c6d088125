"""All joint positions of some poses of the arms in `urdf/` that have closed forms, by restarts of Newton's iteration with
Pinocchio (PyPI `pin`), which knows nothing of closed forms.

Of an arm with seven joints, only the positions at one arm angle and half a turn from it are looked for: a seventh
equation sin(psi - psi_0) = 0, where psi is taken from Pinocchio's frames (shoulder S, wrist W, axis 4) as `Serial::arm_angle`
describes it.

Usage: pip install pin; python3 urdf_solutions.py > urdf_solutions.csv
Columns: arm, psi_0 [rad] (0 with six joints), number of solutions n, q of the pose [rad], n times q [rad, -pi to pi].
"""

import pathlib

import numpy as np
import pinocchio

# Tip, and for seven joints the joints whose frames lie in S and W.
ARMS = {
    "three_parallel": ("wrist_3", None),
    "three_parallel_beside": ("tool", None),
    "seven_axes": ("flange", ("a2", "a6")),
    "offset_elbow": ("tool", ("j2", "j6")),
}
POSES = 10
# So many restarts in a row must find no new solution.
IDLE_LIMIT = 120


class Arm:
    def __init__(self, path, tip, centres):
        self.model = pinocchio.buildModelFromUrdf(str(path))
        self.data = self.model.createData()
        self.frame = self.model.getFrameId(tip, pinocchio.BODY)
        self.centres = centres and [self.model.getJointId(name) for name in centres]

    def pose(self, q):
        pinocchio.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.frame].copy()

    def axis(self, joint, q):
        """The direction of a joint's axis in the world, by its column of the Jacobian."""
        columns = pinocchio.computeJointJacobians(self.model, self.data, q)
        return columns[3:, self.model.joints[joint].idx_v].copy()

    def arm_angle(self, q):
        self.pose(q)
        line = self.data.oMi[self.centres[1]].translation - self.data.oMi[self.centres[0]].translation
        w = line / np.linalg.norm(line)
        e1 = np.cross(self.axis(1, q), w)
        e1 /= np.linalg.norm(e1)
        n = self.axis(4, q)
        return np.arctan2(n @ np.cross(w, e1), n @ e1)

    def error(self, q, wanted, psi):
        error = pinocchio.log6(self.pose(q).inverse() * wanted).vector
        return error if self.centres is None else np.append(error, np.sin(psi - self.arm_angle(q)))

    def solve(self, q, wanted, psi):
        for _ in range(60):
            error = self.error(q, wanted, psi)
            if np.abs(error).max() < 1e-12:
                return (q + np.pi) % (2 * np.pi) - np.pi
            step = 1e-6
            shifts = np.eye(len(q)) * step
            jacobian = np.column_stack(
                [(self.error(q + s, wanted, psi) - self.error(q - s, wanted, psi)) / (2 * step) for s in shifts]
            )
            change = -np.linalg.lstsq(jacobian, error, rcond=1e-10)[0]
            q = q + change * min(1.0, 0.5 / np.abs(change).max())
        return None


def apart(a, b):
    return np.abs((a - b + np.pi) % (2 * np.pi) - np.pi).max()


def main():
    random = np.random.default_rng(2013)
    here = pathlib.Path(__file__).parent / "urdf"
    for name, (tip, centres) in ARMS.items():
        arm = Arm(here / f"{name}.urdf", tip, centres)
        lower = np.maximum(arm.model.lowerPositionLimit, -np.pi)
        upper = np.minimum(arm.model.upperPositionLimit, np.pi)
        for _ in range(POSES):
            q = random.uniform(lower, upper)
            wanted = arm.pose(q)
            psi = arm.arm_angle(q) if centres else 0.0
            found, idle = [], 0
            while idle < IDLE_LIMIT:
                solution = arm.solve(random.uniform(-np.pi, np.pi, len(q)), wanted, psi)
                if solution is None:
                    idle += 1
                elif all(apart(solution, other) > 1e-6 for other in found):
                    found.append(solution)
                    idle = 0
                else:
                    idle += 1
            values = np.concatenate([q, *sorted(found, key=tuple)])
            print(f"{name},{psi!r},{len(found)},".replace("np.float64(", "").replace(")", ""), end="")
            print(",".join(repr(float(value)) for value in values), flush=True)


if __name__ == "__main__":
    main()

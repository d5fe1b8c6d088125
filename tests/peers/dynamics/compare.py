"""Compares the dynamics of the library's robots with Pinocchio, which reads the URDFs that they were exported as.

Usage: compare.py FOLDER, with what `cargo run --example dynamics` wrote there; its page says what is in the files. Pinocchio reads
every URDF without mimicry; what mimics is added here (velocities S qdot, forces S^T f). The error of a torque is divided by
the largest torque of its robot in all states, and so for accelerations, mass matrices and energies: 1e-9 is allowed. Free
motion for 10 s may change the energy by 1e-6 of the largest kinetic energy, by which the integration errs. RNT's loops are
closed by the Jacobians of the points where they are cut. Exits with 1 where anything falls short.
"""

import csv
import pathlib
import re
import sys
import xml.etree.ElementTree as xml

import numpy as np
import pinocchio as pin

ALLOWED, DRIFT = 1e-9, 1e-6


class Peer:
    """A robot as Pinocchio reads it, moved by the coordinates that do not mimic."""

    def __init__(self, path):
        self.model = pin.buildModelFromUrdf(str(path))
        self.model.gravity.linear = np.array([0.0, 0.0, -9.80665])
        self.data = self.model.createData()
        joints = [j for j in xml.parse(path).getroot().findall("joint") if j.get("type") != "fixed"]
        self.names = [j.get("name") for j in joints if j.find("mimic") is None]
        self.size = len(self.names)
        self.map, self.offset = np.zeros((self.model.nv, self.size)), np.zeros(self.model.nv)
        for joint in joints:
            mimic = joint.find("mimic")
            row = self.model.joints[self.model.getJointId(joint.get("name"))].idx_v
            leader = joint.get("name") if mimic is None else mimic.get("joint")
            self.map[row, self.names.index(leader)] = 1.0 if mimic is None else float(mimic.get("multiplier"))
            self.offset[row] = 0.0 if mimic is None else float(mimic.get("offset"))

    def positions(self, q):
        """Pinocchio's positions: an endless joint has a cosine and a sine."""
        value, out = self.map @ q + self.offset, np.zeros(self.model.nq)
        for joint in list(self.model.joints)[1:]:
            angle = value[joint.idx_v]
            out[joint.idx_q : joint.idx_q + joint.nq] = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
        return out

    def forces(self, frame, positions, wrench):
        """A wrench at the origin of a frame, along the world's axes, as Pinocchio takes it."""
        pin.framesForwardKinematics(self.model, self.data, positions)
        place, joint = self.data.oMf[frame], self.model.frames[frame].parentJoint
        at_frame = pin.SE3(np.eye(3), place.translation).act(pin.Force(wrench))
        forces = [pin.Force.Zero() for _ in range(self.model.njoints)]
        forces[joint] = self.data.oMi[joint].actInv(at_frame)
        return forces

    def mass(self, positions):
        upper = np.triu(pin.crba(self.model, self.data, positions))
        full = upper + upper.T - np.diag(np.diag(upper))
        return self.map.T @ full @ self.map


def tree(path):
    """Of a robot whose joints are a tree: per state what was given, what we say of it, and what Pinocchio says."""
    peer = Peer(path)
    n = peer.size
    frame = peer.model.getFrameId("flange", pin.BODY)
    zero = np.zeros(peer.model.nv)
    torque = lambda *arguments: peer.map.T @ pin.rnea(peer.model, peer.data, *arguments)
    for row in np.fromfile(path.with_suffix(".f64"), "<f8").reshape(-1, 7 * n + 6 + n * n + 2):
        q, v, a, wrench, *ours = np.split(row, np.cumsum([n, n, n, 6, n, n, n, n, n * n]))
        at, speed, change = peer.positions(q), peer.map @ v, peer.map @ a
        forces = peer.forces(frame, at, wrench)
        mass = peer.mass(at)
        # Accelerations by articulated bodies, where nothing mimics.
        if n == peer.model.nv:
            back = pin.aba(peer.model, peer.data, at, speed, ours[0], forces)
        else:
            back = np.linalg.solve(mass, ours[0] - torque(at, speed, zero, forces))
        kinetic = pin.computeKineticEnergy(peer.model, peer.data, at, speed)
        potential = pin.computePotentialEnergy(peer.model, peer.data, at)
        tau, bias, weight = torque(at, speed, change, forces), torque(at, speed, zero), torque(at, zero, zero)
        energies = np.array([kinetic, potential])
        yield (q, v, a, wrench), ours, [tau, back, bias, weight, mass.flatten("F"), energies]


def rnt(path):
    """Of RNT: M and h in the actuators' lengths, its loops closed by Jacobians of the points where they are cut."""
    peer = Peer(path)
    model, data, n = peer.model, peer.data, 6
    rows = np.fromfile(path.with_suffix(".f64"), "<f8").reshape(-1, 2 * n + n * n + n)
    text = path.read_text()
    numbers = lambda found: np.array([float(x) for x in found.split()])
    points = [numbers(x) for x in re.findall(r"\(([-0-9.e ]+)\)", text.split("Closed loops")[1].split("Transmission")[0])]
    rod, tail, foot2, crank, foot3, rocker = points
    ids = {name: model.getFrameId(f"{name}_link", pin.BODY) for name in ("column", "rod", "forearm", "upper_arm", "rocker")}
    place = lambda *names: [model.joints[model.getJointId(name)].idx_v for name in names]
    own = place("column", "wrist_4", "wrist_5", "flange_6")
    free = place("rocker", "rod", "upper_arm", "forearm")
    shoulder = model.jointPlacements[model.getJointId("upper_arm")].translation

    def assembled(q2, q3):
        """Elevations of rocker, rod, upper arm and forearm, each from the one before, by laws of cosines."""

        def angle(foot, length, crank):
            d, c = np.linalg.norm(foot - shoulder), np.linalg.norm(crank)
            direction = np.arctan2(*(foot - shoulder)[[2, 0]])
            return direction, np.arccos((d * d + c * c - length * length) / (2 * d * c))

        (below, turned), (behind, folded) = angle(foot2, q2, crank), angle(foot3, q3, rocker)
        upper, back = below + turned, behind - folded
        elbow = model.jointPlacements[model.getJointId("forearm")].translation[0] * np.exp(1j * upper)
        end = rocker[0] * np.exp(1j * back)
        # T on the circles about the rocker's end and the elbow, to the left of the line between them.
        way, (long, short) = elbow - end, (rod[0], tail[0])
        along = (abs(way) ** 2 + long**2 - short**2) / (2 * abs(way))
        reach = way / abs(way) * (along + 1j * np.sqrt(long**2 - along**2))
        forearm = (end + reach - elbow) / short
        return np.angle([np.exp(1j * back), reach / np.exp(1j * back), np.exp(1j * upper), forearm / np.exp(1j * upper)])

    def point(name, there, at):
        """Place, Jacobian and drift of a point of a link, in the axes of the column."""
        place = data.oMf[ids[name]]
        turned = data.oMf[ids["column"]].rotation.T
        arm = place.rotation @ there
        jacobian = pin.getFrameJacobian(model, data, ids[name], pin.LOCAL_WORLD_ALIGNED)
        drift = pin.getFrameClassicalAcceleration(model, data, ids[name], pin.LOCAL_WORLD_ALIGNED)
        spin = pin.getFrameVelocity(model, data, ids[name], pin.LOCAL_WORLD_ALIGNED).angular
        linear = jacobian[:3] - pin.skew(arm) @ jacobian[3:]
        pushed = drift.linear + np.cross(drift.angular, arm) + np.cross(spin, np.cross(spin, arm))
        return place.translation + arm, linear, pushed, turned

    for row in rows:
        q, v, mass, bias = np.split(row, np.cumsum([n, n, n * n]))
        # The tree's coordinates by Newton's iteration, which begins in the assembly that is built.
        s = np.zeros(model.nv)
        s[own], s[free] = q[[0, 3, 4, 5]], assembled(q[1], q[2])
        rate = np.zeros(model.nv)

        def constraints(s, rate):
            pin.forwardKinematics(model, data, s, rate, np.zeros(model.nv))
            pin.computeJointJacobians(model, data, s)
            pin.updateFramePlacements(model, data)
            (t, jt, dt, turned), (r, jr, dr, _) = point("forearm", tail, s), point("rod", rod, s)
            rows, values, drifts = [], [], []
            for k in (0, 2):
                values.append((turned @ (t - r))[k])
                rows.append((turned @ (jt - jr))[k])
                drifts.append((turned @ (dt - dr))[k])
            for k, (name, end, foot) in enumerate((("upper_arm", crank, foot2), ("rocker", rocker, foot3))):
                (p, jp, dp, _), (f, jf, df, _) = point(name, end, s), point("column", foot, s)
                way, length = p - f, np.linalg.norm(p - f)
                values.append(length - q[1 + k])
                rows.append(way @ (jp - jf) / length)
                speed = (jp - jf) @ rate
                drifts.append((way @ (dp - df) + speed @ speed - (way @ speed / length) ** 2) / length)
            return np.array(values), np.array(rows), np.array(drifts)

        for _ in range(30):
            values, jacobian, _ = constraints(s, rate)
            s[free] -= np.linalg.solve(jacobian[:, free], values)
            if np.abs(values).max() < 1e-15:
                break
        _, jacobian, _ = constraints(s, rate)
        # ds/dq: the four coordinates that joints are; the others keep the loops closed and the lengths as told.
        g = np.zeros((model.nv, n))
        g[own, [0, 3, 4, 5]] = 1.0
        given = np.zeros((4, n))
        given[2, 1] = given[3, 2] = 1.0
        g[free] = np.linalg.solve(jacobian[:, free], given - jacobian[:, own] @ g[own])
        rate = g @ v
        _, jacobian, drifts = constraints(s, rate)
        pushed = np.zeros(model.nv)
        pushed[free] = np.linalg.solve(jacobian[:, free], -drifts)
        open_mass = pin.crba(model, data, s)
        open_mass = np.triu(open_mass) + np.triu(open_mass, 1).T
        peer_mass = g.T @ open_mass @ g
        peer_bias = g.T @ pin.rnea(model, data, s, rate, pushed)
        yield (q, v), [mass, bias], [peer_mass.flatten("F"), peer_bias]


def compared(path):
    """Per state as `tree`."""
    return rnt(path) if path.stem == "rnt" else tree(path)


def main():
    folder = pathlib.Path(sys.argv[1])
    falls_short = []
    print(f"{'robot':24}{'states':>8}  largest error by the largest value: tau, qddot, bias, weight, M, energies (rnt: M, h)")
    for path in sorted(folder.glob("*.urdf")):
        seen = [
            [(np.abs(x - y).max(), np.abs(y).max()) for x, y in zip(ours, theirs)] for _, ours, theirs in compared(path)
        ]
        largest, sizes = np.array(seen).transpose(2, 1, 0).max(axis=2)
        states, errors = len(seen), largest / np.maximum(sizes, 1e-300)
        print(f"{path.stem:24}{states:8}  " + "  ".join(f"{error:.1e}" for error in errors))
        if not errors.max() < ALLOWED:
            falls_short.append(path.stem)
    for name, _, _, most, drift in csv.reader((folder / "energy.csv").open()):
        share = float(drift) / max(float(most), 1e-300)
        print(f"{name:24} energy drifts by {share:.1e} of {float(most):.2e} J in 10 s of free motion")
        if not share < DRIFT:
            falls_short.append(f"{name} (energy)")
    if falls_short:
        sys.exit("falls short: " + ", ".join(falls_short))


if __name__ == "__main__":
    main()

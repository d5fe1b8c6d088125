"""Reference poses and Jacobians of the arms in `urdf/` by Pinocchio (PyPI `pin`).

Pinocchio reads each URDF with its own reader (urdfdom), without mimicry: every joint moves by itself. What mimics is
added here: its coordinate is set from its leader's, and its column of the Jacobian, times the multiplier, is added to
its leader's. The base of the chain is the root of each file, and the pose that of the tip in it.

Usage: pip install pin; python3 urdf_pinocchio.py > urdf_poses.csv
Columns: arm, q [rad or m], p [m], rotation matrix row by row, Jacobian column by column (linear, then angular).
"""

import pathlib
import xml.etree.ElementTree as xml

import numpy as np
import pinocchio

ARMS = {
    "ortho_parallel": "tool0",
    "offset_arm": "tool",
    "seven_axes": "flange",
    "scara": "tool",
    "gantry": "tool",
    "palletiser": "tool",
    "three_parallel": "wrist_3",
    "three_parallel_beside": "tool",
    "offset_elbow": "tool",
    "offset_wrist": "flange",
}
POSES = 40


def chain(path, tip):
    """The moving joints from the root to the tip: (name, leader, multiplier, offset, limits)."""
    joints = {joint.find("child").get("link"): joint for joint in xml.parse(path).getroot().findall("joint")}
    found = []
    while tip in joints:
        joint = joints[tip]
        tip = joint.find("parent").get("link")
        if joint.get("type") == "fixed":
            continue
        mimic, limit = joint.find("mimic"), joint.find("limit")
        endless = joint.get("type") == "continuous"
        limits = (-7.0, 7.0) if endless else (float(limit.get("lower")), float(limit.get("upper")))
        if mimic is None:
            found.append((joint.get("name"), joint.get("name"), 1.0, 0.0, limits))
        else:
            factor, offset = float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0))
            found.append((joint.get("name"), mimic.get("joint"), factor, offset, limits))
    return found[::-1]


def main():
    random = np.random.default_rng(1955)
    here = pathlib.Path(__file__).parent / "urdf"
    for arm, tip in ARMS.items():
        path = here / f"{arm}.urdf"
        model = pinocchio.buildModelFromUrdf(str(path))
        data = model.createData()
        frame = model.getFrameId(tip, pinocchio.BODY)
        joints = chain(path, tip)
        own = [joint for joint in joints if joint[0] == joint[1]]
        for _ in range(POSES):
            q = {name: random.uniform(*limits) for name, _, _, _, limits in own}
            full = pinocchio.neutral(model)
            for name, leader, factor, offset, _ in joints:
                value = factor * q[leader] + offset
                joint = model.joints[model.getJointId(name)]
                full[joint.idx_q : joint.idx_q + joint.nq] = (
                    [np.cos(value), np.sin(value)] if joint.nq == 2 else [value]
                )
            pinocchio.computeJointJacobians(model, data, full)
            pinocchio.updateFramePlacements(model, data)
            pose = data.oMf[frame]
            columns = pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL_WORLD_ALIGNED)
            jacobian = {name: np.zeros(6) for name, *_ in own}
            for name, leader, factor, _, _ in joints:
                jacobian[leader] += factor * columns[:, model.joints[model.getJointId(name)].idx_v]
            values = [*q.values(), *pose.translation, *pose.rotation.ravel(), *np.concatenate(list(jacobian.values()))]
            print(arm + "," + ",".join(repr(float(value)) for value in values))


if __name__ == "__main__":
    main()

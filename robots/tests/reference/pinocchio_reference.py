"""Reference poses and Jacobians of the robots, by Pinocchio from URDF models written from the same facts.

Writes one `<robot>.csv` per robot: joint positions, position of the flange [m], rotation matrix row by row, Jacobian
row by row (linear, then angular, in the world's axes, at the flange). No formula is shared with the Rust code: joints
are chained by Pinocchio from their origins and axes; the closed linkages of the RNT are a tree whose loops are
closed numerically by Newton's method, and its Jacobian follows by the implicit function theorem.

Usage: pip install pin; python3 pinocchio_reference.py        (seed 7; Pinocchio 4.1.0 wrote the committed files)
"""

import numpy as np
import pinocchio as pin

ROWS = 25
H = np.pi / 2
WRIST = f"0 {-H!r} {-H!r}"  # P of the IRp-6: x -> z, y -> x, z -> y


def chain(name, joints, flange):
    """URDF of a chain: (kind, axis, xyz, rpy) per joint, the flange's (xyz, rpy) on the last link."""
    text = [f'<robot name="{name}"><link name="l0"/>']
    for i, (kind, axis, xyz, rpy) in enumerate(joints, 1):
        text.append(link(f"j{i}", kind, axis, xyz, rpy, f"l{i - 1}", f"l{i}"))
    text.append(link("flange_joint", "fixed", "0 0 1", *flange, f"l{len(joints)}", "flange"))
    return "\n".join(text) + "\n</robot>\n"


def link(name, kind, axis, xyz, rpy, parent, child):
    """A joint and its child link."""
    limit = '<limit lower="-1e3" upper="1e3" velocity="1" effort="1"/>' if kind != "fixed" else ""
    return (
        f'<link name="{child}"/><joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{limit}</joint>'
    )


def irp6(a2, a3, d5, before=()):
    """Six joints; the second, third and fourth are relative to the link before."""
    joints = [
        *before,
        ("revolute", "0 0 1", "0 0 0", "0 0 0"),
        ("revolute", "0 1 0", "0 0 0", "0 0 0"),
        ("revolute", "0 1 0", f"{a2} 0 0", f"0 {H!r} 0"),
        ("revolute", "0 1 0", f"{a3} 0 0", "0 0 0"),
        ("revolute", "1 0 0", f"{d5} 0 0", "0 0 0"),
        ("revolute", "0 0 1", "0 0 0", WRIST),
    ]
    return chain("irp6", joints, ("0 0 0", "0 0 0"))


def irp6_5dof():
    """Five joints; the tool lies along the last link."""
    joints = [
        ("revolute", "0 0 1", "0 0 0.7", "0 0 0"),
        ("revolute", "0 1 0", "0 0 0", "0 0 0"),
        ("revolute", "0 1 0", "0.455 0 0", f"0 {H!r} 0"),
        ("revolute", "0 1 0", "0.67 0 0", "0 0 0"),
        ("revolute", "0 0 1", "0.095 0 0", f"0 {-H!r} {np.pi!r}"),
    ]
    return chain("irp6-5dof", joints, ("0 0 0", "0 0 0"))


def polycrank():
    """Standard Denavit-Hartenberg rows (d, a, alpha), column 0.925 m high."""
    rows = [
        (0.220, -0.299, 0.0),
        (0.152, 0.180, 0.0),
        (0.335, 0.0, H),
        (0.120, 0.151, 0.0),
        (0.116, 0.151, 0.0),
        (0.060, 0.0, H),
        (0.043, 0.0, 0.0),
    ]
    joints = [("revolute", "0 0 1", "0 0 0.925", "0 0 0")]
    for d, a, alpha in rows[:-1]:
        joints.append(("revolute", "0 0 1", f"{a} 0 {d}", f"{alpha!r} 0 0"))
    d, a, alpha = rows[-1]
    return chain("polycrank", joints, (f"{a} 0 {d}", f"{alpha!r} 0 0"))


RELATIVE = (np.radians([-170, -130, -25, -90, -180, -165]), np.radians([170, -50, 40, 92, 360, 168]))
TRACK = [("prismatic", "0 1 0", "0 0 0", "0 0 0")]
CHAINS = {
    "irp6_nominal": (irp6(0.455, 0.67, 0.19), *RELATIVE),
    "irp6_calibrated": (irp6(0.4596, 0.6729, 0.1903), *RELATIVE),
    "irp6_5dof": (irp6_5dof(), RELATIVE[0][:5], RELATIVE[1][:5]),
    "irp6_track_nominal": (irp6(0.455, 0.67, 0.19, TRACK), np.r_[-0.125, RELATIVE[0]], np.r_[1.21, RELATIVE[1]]),
    "irp6_track_calibrated": (
        irp6(0.4647, 0.6748, 0.1967, TRACK), np.r_[-0.125, RELATIVE[0]], np.r_[1.21, RELATIVE[1]]),
    "polycrank": (polycrank(), np.full(7, -62.0), np.full(7, 62.0)),
}


def write(name, rows, count):
    """One CSV: `count` joints per row."""
    head = [f"q{i}" for i in range(1, count + 1)] + ["px", "py", "pz"] + [f"r{i}{j}" for i in "123" for j in "123"]
    head += [f"j{i}{j}" for i in range(1, 7) for j in range(1, count + 1)]
    with open(f"{name}.csv", "w") as file:
        file.write(",".join(head) + "\n")
        for q, pose, jacobian in rows:
            values = [*q, *pose.translation, *pose.rotation.ravel(), *jacobian.ravel()]
            file.write(",".join(repr(float(v)) for v in values) + "\n")


def main():
    for name, (urdf, lower, upper) in CHAINS.items():
        random = np.random.default_rng(7)
        model = pin.buildModelFromXML(urdf)
        data = model.createData()
        flange = model.getFrameId("flange")
        rows = []
        for _ in range(ROWS):
            q = random.uniform(lower, upper)
            jacobian = pin.computeFrameJacobian(model, data, q, flange, pin.LOCAL_WORLD_ALIGNED)
            pin.framesForwardKinematics(model, data, q)
            rows.append((q, data.oMf[flange].copy(), jacobian.copy()))
        write(name, rows, len(lower))


if __name__ == "__main__":
    main()

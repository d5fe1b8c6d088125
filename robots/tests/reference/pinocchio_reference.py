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


def rnt():
    """The RNT's tree: column, upper arm, forearm and wrist; rocker and rod; two actuators, each a cylinder and a rod."""
    degrees = np.pi / 180
    foot2 = 0.40 * np.array([np.cos(-20 * degrees), np.sin(-20 * degrees)])
    foot3 = 0.55 * np.array([np.cos(250 * degrees), np.sin(250 * degrees)])
    up = "0 -1 0"
    parts = [
        link("q1", "revolute", "0 0 1", "0 0 0", "0 0 0", "base", "column"),
        link("theta2", "revolute", up, "0.12 0 0.75", "0 0 0", "column", "upper"),
        link("elbow", "revolute", up, "0.5 0 0", "0 0 0", "upper", "forearm"),
        link("q4", "revolute", "0 0 1", "0.6 0 0", f"0 {H!r} 0", "forearm", "wrist4"),
        link("q5", "revolute", "0 1 0", "0 0 0", "0 0 0", "wrist4", "wrist5"),
        link("q6", "revolute", "0 0 1", "0 0 0", "0 0 0", "wrist5", "wrist6"),
        link("flange_joint", "fixed", "0 0 1", "0 0 0.12", "0 0 0", "wrist6", "flange"),
        link("rho", "revolute", up, "0.12 0 0.75", "0 0 0", "column", "rocker"),
        link("sigma", "revolute", up, "0.2 0 0", "0 0 0", "rocker", "rod"),
        link("cylinder2", "revolute", up, f"{float(0.12 + foot2[0])!r} 0 {float(0.75 + foot2[1])!r}", "0 0 0", "column", "cyl2"),
        link("q2", "prismatic", "1 0 0", "0 0 0", "0 0 0", "cyl2", "end2"),
        link("cylinder3", "revolute", up, f"{float(0.12 + foot3[0])!r} 0 {float(0.75 + foot3[1])!r}", "0 0 0", "column", "cyl3"),
        link("q3", "prismatic", "1 0 0", "0 0 0", "0 0 0", "cyl3", "end3"),
        link("crank_joint", "fixed", "0 0 1", "0.25 0 0", "0 0 0", "upper", "crank"),
        link("tip_joint", "fixed", "0 0 1", "0.2 0 0", "0 0 0", "rocker", "tip"),
        link("tail_joint", "fixed", "0 0 1", "-0.2 0 0", "0 0 0", "forearm", "tail"),
        link("rod_joint", "fixed", "0 0 1", "0.52 0 0", "0 0 0", "rod", "rod_end"),
    ]
    return '<robot name="rnt"><link name="base"/>' + "\n".join(parts) + "</robot>\n"


LOOPS = [("end2", "crank"), ("end3", "tip"), ("rod_end", "tail")]


def rnt_rows():
    """Rows of the RNT: elevations drawn, the other joints found by Newton's method on the loops."""
    random = np.random.default_rng(7)
    model = pin.buildModelFromXML(rnt())
    data = model.createData()
    column = {name: model.joints[model.getJointId(name)].idx_v for name in model.names[1:]}
    jacobian_of = lambda q, frame: pin.computeFrameJacobian(
        model, data, q, model.getFrameId(frame), pin.LOCAL_WORLD_ALIGNED)
    place = lambda frame: data.oMf[model.getFrameId(frame)].translation

    def loops(q):
        pin.framesForwardKinematics(model, data, q)
        gap = np.concatenate([place(a) - place(b) for a, b in LOOPS])
        slope = np.vstack([(jacobian_of(q, a) - jacobian_of(q, b))[:3] for a, b in LOOPS])
        return gap, slope

    solved = [column[n] for n in ("rho", "sigma", "cylinder2", "q2", "cylinder3", "q3")]
    passive = [column[n] for n in ("theta2", "elbow", "rho", "sigma", "cylinder2", "cylinder3")]
    joints = [column[n] for n in ("q1", "q2", "q3", "q4", "q5", "q6")]
    for _ in range(ROWS):
        theta2, theta3 = np.radians([random.uniform(55, 120), random.uniform(-50, 25)])
        q = np.zeros(model.nq)
        q[joints] = random.uniform(-2, 2, 6)
        q[column["theta2"]], q[column["elbow"]] = theta2, theta3 - theta2
        q[column["rho"]], q[column["sigma"]] = theta3 + np.pi, theta2 - theta3 - np.pi
        q[column["cylinder2"]], q[column["q2"]] = np.radians(150), 0.5
        q[column["cylinder3"]], q[column["q3"]] = np.radians(105), 0.5
        for _ in range(50):
            gap, slope = loops(q)
            q[solved] -= np.linalg.lstsq(slope[:, solved], gap, rcond=1e-9)[0]
        gap, slope = loops(q)
        assert abs(gap).max() < 1e-15 and 0.35 < q[column["q2"]] < 0.64 and 0.39 < q[column["q3"]] < 0.715, q
        follow = -np.linalg.lstsq(slope[:, passive], slope[:, joints], rcond=1e-9)[0]
        full = jacobian_of(q, "flange").copy()
        pin.framesForwardKinematics(model, data, q)
        yield q[joints], data.oMf[model.getFrameId("flange")].copy(), full[:, joints] + full[:, passive] @ follow


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
    write("rnt", list(rnt_rows()), 6)


if __name__ == "__main__":
    main()

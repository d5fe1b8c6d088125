"""Writes MotionBenchMaker's problems, which the source package of VAMP carries, as JSON lines.

Usage: problems.py RESOURCES FOLDER [ROBOT ..], with the folder `resources` of vamp-planner's source package. Robots: panda, ur5, fetch,
baxter; without a name panda and ur5. Writes FOLDER/ROBOT.jsonl.

The first line is the robot: its name, its joints in the order of all joint values, their limits [rad, m], the links base (the root link) and tip, and the
files: urdf, srdf, spheres (the URDF with VAMP's own spheres), meshes (the folder that `package://` and relative names of meshes
are relative to). Every further line is a problem:

- set, index: the name of the set and the number of the problem there, from 1
- start [rad, m], goals: a list of joint values, any of which will do
- boxes: center [m], quaternion (x, y, z, w), half_extents [m]
- cylinders: center [m], quaternion (along z), radius [m], half_length [m]
- spheres: center [m], radius [m]
- capsules: as cylinders, half_length without the caps. MotionBenchMaker has none: the list is empty
- valid: whether VAMP finds start and one of the goals free of collisions; null where VAMP is not installed. VAMP takes a cylinder for
  a capsule of the same half_length, or in the set `box` for a box around it.

All is in the frame of the URDF's root link. The obstacles have names.
"""

import json
import pathlib
import re
import sys
import tarfile
import xml.etree.ElementTree as xml

import numpy as np
import yaml

try:
    import vamp
except ImportError:
    vamp = None

Loader = getattr(yaml, "CLoader", yaml.SafeLoader)

# Links base and tip, and the joints in VAMP's order. The base is the root link, in whose frame the obstacles are.
ROBOTS = {
    "panda": ("panda_link0", "panda_grasptarget", [f"panda_joint{i}" for i in range(1, 8)]),
    "ur5": (
        "offset_link",
        "robotiq_85_base_link",
        [f"{name}_joint" for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")],
    ),
    "fetch": (
        "base_link",
        "gripper_link",
        ["torso_lift_joint"]
        + [f"{n}_joint" for n in ("shoulder_pan", "shoulder_lift", "upperarm_roll", "elbow_flex", "forearm_roll", "wrist_flex", "wrist_roll")],
    ),
    "baxter": (
        "base",
        "right_gripper",
        [f"{side}_{name}" for side in ("left", "right") for name in ("s0", "s1", "e0", "e1", "w0", "w1", "w2")],
    ),
}


def rotation(q):
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def product(a, b):
    x, y, z, w = a
    p, q, r, s = b
    return np.array(
        [w * p + x * s + y * r - z * q, w * q - x * r + y * s + z * p, w * r + x * q - y * p + z * s, w * s - x * p - y * q - z * r]
    )


def pose(given):
    """Position and unit quaternion of a pose of MoveIt."""
    if given is None:
        return np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
    quaternion = np.array(given["orientation"], float)
    return np.array(given["position"], float), quaternion / np.linalg.norm(quaternion)


def obstacles(scene):
    out = {"boxes": [], "cylinders": [], "spheres": [], "capsules": []}
    for body in scene["world"]["collision_objects"]:
        p_WB, q_WB = pose(body.get("pose"))
        for primitive, given in zip(body["primitives"], body["primitive_poses"]):
            p_BS, q_BS = pose(given)
            place = {
                "name": body["id"],
                "center": (p_WB + rotation(q_WB) @ p_BS).tolist(),
                "quaternion": product(q_WB, q_BS).tolist(),
            }
            size = primitive["dimensions"]
            match primitive["type"]:
                case "box":
                    out["boxes"].append(place | {"half_extents": [side / 2 for side in size]})
                case "cylinder":
                    out["cylinders"].append(place | {"radius": size[1], "half_length": size[0] / 2})
                case "sphere":
                    del place["quaternion"]
                    out["spheres"].append(place | {"radius": size[0]})
                case other:
                    raise SystemExit(f"problems: {body['id']}: a {other} is not known here")
    return out


def request(data, joints):
    state = data["start_state"]["joint_state"]
    start = dict(zip(state["name"], state["position"]))
    goals = [{c["joint_name"]: c["position"] for c in goal["joint_constraints"]} for goal in data["goal_constraints"]]
    return {"start": [float(start[j]) for j in joints], "goals": [[float(goal[j]) for j in joints] for goal in goals]}


def environment(problem):
    """A problem as VAMP takes it."""
    world = vamp.Environment()
    for box in problem["boxes"]:
        world.add_cuboid(vamp.Cuboid(box["center"], angles(box["quaternion"]), box["half_extents"]))
    for c in problem["cylinders"]:
        at = c["center"], angles(c["quaternion"])
        if problem["set"] == "box":
            world.add_cuboid(vamp.Cuboid(*at, [c["radius"], c["radius"], c["half_length"]]))
        else:
            world.add_capsule(vamp.Cylinder(*at, c["radius"], 2 * c["half_length"]))
    for sphere in problem["spheres"]:
        world.add_sphere(vamp.Sphere(sphere["center"], sphere["radius"]))
    return world


def angles(quaternion):
    """Roll, pitch and yaw about fixed axes, as VAMP wants them."""
    R = rotation(quaternion)
    across = np.hypot(R[0, 0], R[1, 0])
    if across < 1e-12:
        return [float(np.arctan2(-R[1, 2], R[1, 1])), float(np.arctan2(-R[2, 0], across)), 0.0]
    return [float(np.arctan2(R[2, 1], R[2, 2])), float(np.arctan2(-R[2, 0], across)), float(np.arctan2(R[1, 0], R[0, 0]))]


def robot(folder, name):
    base, tip, joints = ROBOTS[name]
    found = {joint.get("name"): joint.find("limit") for joint in xml.parse(folder / f"{name}.urdf").getroot().findall("joint")}
    return {
        "robot": name,
        "joints": joints,
        "lower": [float(found[j].get("lower")) for j in joints],
        "upper": [float(found[j].get("upper")) for j in joints],
        "base": base,
        "tip": tip,
        "urdf": str(folder / f"{name}.urdf"),
        "srdf": str(folder / f"{name}.srdf"),
        "spheres": str(folder / f"{name}_spherized.urdf"),
        "meshes": str(folder),
    }


def problems(folder, name):
    """All problems of a robot, by set and index."""
    joints = ROBOTS[name][2]
    found = {}
    with tarfile.open(folder / "problems.tar.bz2") as archive:
        for member in archive:
            if not member.isfile():
                continue
            _, of, file = member.name.split("/")
            key = of.removesuffix(f"_{name}"), int(re.search(r"\d+", file)[0])
            data = yaml.load(archive.extractfile(member), Loader)
            part = obstacles(data) if "scene" in file else request(data, joints)
            found.setdefault(key, {"set": key[0], "index": key[1], "start": None, "goals": None}).update(part)
    for _, problem in sorted(found.items()):
        problem["valid"] = None
        if vamp:
            world, of = environment(problem), getattr(vamp, name)
            problem["valid"] = bool(of.validate(problem["start"], world) and any(of.validate(goal, world) for goal in problem["goals"]))
        yield problem


def main():
    resources, out = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[3:] or ["panda", "ur5"]:
        folder, count, valid = resources / name, 0, 0
        with open(out / f"{name}.jsonl", "w") as file:
            file.write(json.dumps(robot(folder, name)) + "\n")
            for problem in problems(folder, name):
                file.write(json.dumps(problem) + "\n")
                count, valid = count + 1, valid + bool(problem["valid"])
        print(f"{name}: {count} problems" + (f", {valid} of them valid" if vamp else ", not validated: VAMP is not installed"))


if __name__ == "__main__":
    main()

"""The arms of a cell in MuJoCo: each by its URDF, at its base, driven by a servo, with a tool and a sensor at its wrist.

    cargo run -p mrroc-external --example plant -- --cell CELL external left > arms_port.py
    python3 ports/external/examples/mujoco_arms.py CELL [--view | --png FILE] [--log FILE]

Needs iceoryx2==0.10.0 and mujoco. Links whose URDF states no inertia are capsules of 1000 kg/m³ from joint to joint.
"""

import argparse
import math
import struct
import sys
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np

STEP = 0.5e-3  # of the simulation [s]
OMEGA = 120.0  # natural frequency of each joint's servo, which is critically damped [rad/s]
TOOL_MASS = 1.0  # [kg]
TOOL_CENTRE = 0.05  # its centre of mass, along the tool's axis from the flange [m]


def numbers(text):
    return [float(x) for x in text.split()]


def quaternion(rpy):
    """Of a rotation about the fixed axes x, y and z: w, x, y, z."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in rpy)
    return [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]


def orientation(pose):
    """Of a pose in cell.toml: w, x, y, z."""
    if "quat_xyzw" in pose:
        x, y, z, w = pose["quat_xyzw"]
        return np.array([w, x, y, z]) / math.hypot(w, x, y, z)
    if "zyz" in pose:
        a, b, c = pose["zyz"]
        return np.array(product(product(quaternion([0, 0, a]), quaternion([0, b, 0])), quaternion([0, 0, c])))
    return quaternion(pose.get("rpy", [0.0] * 3))


def text(values):
    return " ".join(repr(float(x)) for x in values)


def chain(urdf, tip):
    """The joints from the base to this link."""
    by_child = {joint.find("child").get("link"): joint for joint in urdf.findall("joint")}
    joints = []
    while tip in by_child:
        joints.insert(0, by_child[tip])
        tip = by_child[tip].find("parent").get("link")
    return joints


def add_arm(world, sensors, name, entry, folder):
    """The bodies of one arm; the names of its joints."""
    urdf = ElementTree.parse(folder / entry["file"]).getroot()
    links = {link.get("name"): link for link in urdf.findall("link")}
    base = entry.get("base", {})
    body = ElementTree.SubElement(world, "body", name=name, pos=text(base.get("xyz", [0.0] * 3)))
    body.set("quat", text(orientation(base)))
    joints, moving = chain(urdf, entry["tip"]), []
    for i, joint in enumerate(joints):
        origin = joint.find("origin")
        at = lambda key: numbers(origin.get(key, "0 0 0")) if origin is not None else [0.0] * 3
        link = links[joint.find("child").get("link")]
        body = ElementTree.SubElement(
            body, "body", name=f"{name}/{link.get('name')}", pos=text(at("xyz")), quat=text(quaternion(at("rpy")))
        )
        if joint.get("type") != "fixed":
            axis = joint.find("axis")
            kind = "slide" if joint.get("type") == "prismatic" else "hinge"
            moving.append(f"{name}/{joint.get('name')}")
            ElementTree.SubElement(
                body, "joint", name=moving[-1], type=kind, axis=axis.get("xyz") if axis is not None else "1 0 0"
            )
        inertial = link.find("inertial")
        following = joints[i + 1].find("origin") if i + 1 < len(joints) else None
        to = numbers(following.get("xyz", "0 0 0")) if following is not None else [0.0] * 3
        if inertial is not None:
            add_inertial(body, inertial)
        elif math.hypot(*to) > 1e-3:
            ElementTree.SubElement(body, "geom", type="capsule", size="0.05", fromto=text([0, 0, 0, *to]))
        elif joint.get("type") != "fixed":
            ElementTree.SubElement(body, "geom", type="sphere", size="0.05")
    tool = ElementTree.SubElement(body, "body", name=f"{name}/tool")
    ElementTree.SubElement(tool, "site", name=f"{name}/flange", rgba="1 0 0 1", size="0.01")
    ElementTree.SubElement(
        tool, "geom", type="box", size="0.02 0.02 0.05", pos=text([0, 0, TOOL_CENTRE]), mass=repr(TOOL_MASS), rgba="0.9 0.6 0.1 1"
    )
    for kind in ("force", "torque"):
        ElementTree.SubElement(sensors, kind, name=f"{name}/{kind}", site=f"{name}/flange")
    return moving


def add_inertial(body, inertial):
    origin = inertial.find("origin")
    at = lambda key: numbers(origin.get(key, "0 0 0")) if origin is not None else [0.0] * 3
    xx, yy, zz, xy, xz, yz = (inertial.find("inertia").get(f"i{k}") for k in ("xx", "yy", "zz", "xy", "xz", "yz"))
    if any(at("rpy")):
        raise SystemExit("the axes of an inertia are turned: write them in the frame of its link")
    mass = inertial.find("mass").get("value")
    inertia = f"{xx} {yy} {zz} {xy} {xz} {yz}"
    ElementTree.SubElement(body, "inertial", pos=text(at("xyz")), mass=mass, fullinertia=inertia)


def product(p, q):
    """Of two quaternions."""
    (a, *u), (b, *v) = p, q
    u, v = np.array(u), np.array(v)
    return [a * b - u @ v, *(a * v + b * u + np.cross(u, v))]


def mjcf(cell, port, folder):
    """The model of the robots at this port, and the names of their joints."""
    root = ElementTree.Element("mujoco", model="cell")
    ElementTree.SubElement(root, "option", timestep=repr(STEP), integrator="Euler")
    ElementTree.SubElement(root, "default").append(ElementTree.Element("geom", density="1000", contype="0", conaffinity="0"))
    world = ElementTree.SubElement(root, "worldbody")
    ElementTree.SubElement(world, "light", pos="0 0 3")
    ElementTree.SubElement(world, "geom", type="plane", size="2 2 0.1", rgba="0.8 0.8 0.8 1")
    sensors = ElementTree.Element("sensor")
    robots = {name: entry for name, entry in cell["robots"].items() if entry.get("plant", {}).get("port") == port}
    joints = {name: add_arm(world, sensors, name, entry, folder) for name, entry in robots.items()}
    root.append(sensors)
    return ElementTree.tostring(root, encoding="unicode"), joints


class Arm:
    """One arm: where its numbers are in those of the simulation, and its servo."""

    def __init__(self, model, name, joints):
        self.name = name
        self.q = np.array([model.joint(joint).qposadr[0] for joint in joints])
        self.v = np.array([model.joint(joint).dofadr[0] for joint in joints])
        self.sensors = [model.sensor(f"{name}/{kind}").adr[0] for kind in ("force", "torque")]
        self.to = self.at = self.speed = np.zeros(len(joints))

    def place(self, data, joints):
        """Lets it stand there."""
        data.qpos[self.q], data.qvel[self.v] = joints, 0.0
        self.to = self.at = np.array(joints)
        self.speed = np.zeros(len(joints))

    def demand(self, joints, seconds):
        """From where it was to be, evenly, to where it is to be then."""
        self.at, self.to = self.to, np.array(joints)
        self.speed = (self.to - self.at) / seconds

    def acceleration(self, data, t):
        """What the servo asks for, `t` after the beginning of the period: ω² e + 2 ω e'."""
        error = self.at + self.speed * t - data.qpos[self.q]
        return OMEGA**2 * error + 2 * OMEGA * (self.speed - data.qvel[self.v])

    def state(self, model, data, port):
        read = [data.sensordata[adr : adr + 3] for adr in self.sensors]
        # MuJoCo tells what the arm does to the tool; the cell wants what the tool, its surroundings, does to the arm.
        wrench = -np.concatenate(read)
        return port.State(data.qpos[self.q], data.qvel[self.v], wrench)


def simulate(model, data, arms, orders):
    """One period of all arms: torques that give each joint the acceleration that its servo asks for, whatever hangs on it."""
    steps = round(orders.seconds / STEP)
    inertia = np.zeros((model.nv, model.nv))
    for arm in arms:
        if orders.powered.get(arm.name, False):
            arm.demand(orders.demanded[arm.name], orders.seconds)
        else:
            # Brakes, or nobody who demands anything: it stays where it is.
            arm.place(data, data.qpos[arm.q].copy())
    for i in range(steps):
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, inertia)
        wanted = np.zeros(model.nv)
        for arm in arms:
            wanted[arm.v] = arm.acceleration(data, i * STEP)
        data.qfrc_applied[:] = inertia @ wanted + data.qfrc_bias
        mujoco.mj_step(model, data)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cell", type=Path)
    parser.add_argument("--view", action="store_true", help="show MuJoCo's viewer")
    parser.add_argument("--png", type=Path, help="draw the last picture of a run to this file")
    parser.add_argument("--log", type=Path, help="write what was demanded and simulated")
    options = parser.parse_args()
    import arms_port as port

    cell = tomllib.loads(options.cell.read_text())
    text_of_model, joints = mjcf(cell, port.PORT, options.cell.parent)
    model = mujoco.MjModel.from_xml_string(text_of_model)
    data = mujoco.MjData(model)
    arms = [Arm(model, name, of) for name, of in joints.items()]
    for arm in arms:
        arm.place(data, cell["robots"][arm.name]["start"])
    mujoco.mj_forward(model, data)
    viewer = None
    if options.view:
        from mujoco.viewer import launch_passive

        viewer = launch_passive(model, data)
    log = open(options.log, "wb") if options.log else None
    try:
        with port.Plant() as plant:
            print(f"port {port.PORT}: {', '.join(joints)} in MuJoCo {mujoco.__version__}", flush=True)
            for orders in plant:
                for arm in arms:
                    if arm.name in orders.begins:
                        arm.place(data, orders.begins[arm.name])
                if orders.seconds > 0.0:
                    simulate(model, data, arms, orders)
                mujoco.mj_forward(model, data)
                plant.answer({arm.name: arm.state(model, data, port) for arm in arms})
                if log is not None and orders.seconds > 0.0:
                    for arm in arms:
                        wrench = np.concatenate([data.sensordata[adr : adr + 3] for adr in arm.sensors])
                        row = np.concatenate([orders.demanded.get(arm.name, arm.to), data.qpos[arm.q], -wrench])
                        log.write(struct.pack("<QQ", orders.period, orders.late) + row.tobytes())
                    log.flush()
                if viewer is not None and orders.period % 8 == 0:
                    viewer.sync()
    except KeyboardInterrupt:
        pass
    finally:
        if options.png:
            draw(model, data, options.png)


def draw(model, data, file, lookat=(0.2, 0.5, 0.4), distance=3.0, azimuth=140):
    """Off the screen: MUJOCO_GL=egl or osmesa."""
    import zlib

    with mujoco.Renderer(model, 480, 640) as renderer:
        camera = mujoco.MjvCamera()
        camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = lookat, distance, azimuth, -20
        renderer.update_scene(data, camera)
        rows = renderer.render()
    raw = b"".join(b"\0" + row.tobytes() for row in rows)
    part = lambda kind, of: struct.pack(">I", len(of)) + kind + of + struct.pack(">I", zlib.crc32(kind + of))
    height, width, _ = rows.shape
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", head) + part(b"IDAT", zlib.compress(raw)) + part(b"IEND", b""))


if __name__ == "__main__":
    sys.exit(main())

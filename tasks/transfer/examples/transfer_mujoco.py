"""The transfer in MuJoCo: both arms, both hands, the bar and the table, for the example `transfer_mujoco`.

    python3 tasks/transfer/examples/transfer_mujoco.py [--view] [--log FILE] [--png FILE] [--program PROGRAM] [--cell CELL]
    cargo run -p transfer --example transfer_mujoco -- --cell tasks/transfer/examples/mujoco.toml --virtual

The model is made of what PROGRAM says of its robots: their URDFs. **The fingers hold the bar by friction**: their pads and the bar
are bodies that touch, and nothing is welded; the hands give way on their arms as those of the task do. Each motor is a force at its joint, by a servo of a natural frequency OMEGA with the
rotor's inertia, and with what its drive may give for a moment as its limit. Needs iceoryx2==0.10.0 and mujoco.
"""

import argparse
import struct
import subprocess
import sys
import tomllib
import types
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "ports/external/examples"))
from exported import Robot, part  # noqa: E402
from mujoco_arms import draw, text  # noqa: E402

STEP = 0.5e-3  # of the simulation [s]
OMEGA = 150.0  # of the servos, which are critically damped without load [rad/s]
PEAK = 2.0  # what an arm's motor gives for a moment, by what it gives lastingly; a hand gives the latter

# As in src/places.rs.
MASS, EDGES, BAR = 2.0, (0.4, 0.06, 0.06), (0.95, -0.15, 0.9)
TABLE, TABLE_EDGES = (0.95, -0.025, 0.86), (0.6, 0.9, 0.02)
STIFFNESS = {"slide": 5e4, "ball": 500.0}  # of a hand on its arm, as in src/sensed.rs [N/m], [N m/rad]
DAMPED = 2e-3  # by so much of it [s]
PALM, PALM_INERTIA = 0.4, 1e-3  # with the fingers 0.8 kg [kg], [kg m²]
PAD = (0.005, 0.012, 0.012)  # half of its edges: across, along y and z of the tool [m]
# A contact's error decays within two steps. With a longer time the bar would creep through the fingers, by the acceleration that
# MuJoCo leaves out of its constraints, the convective one, times half of that time (0.6 mm at 12 ms).
GRIP = {"friction": "0.8", "condim": "4", "priority": "1", "solref": f"{2 * STEP!r} 1", "solimp": "0.95 0.99 0.0005 0.5 2"}


def asked(program, cell, *words):
    """What the program of the cell prints."""
    return subprocess.run([program, "--cell", cell, *words], capture_output=True, check=True, text=True).stdout


def port_of(program, cell, robot):
    """The module of the simulator's port, made by the program."""
    module = types.ModuleType("port")
    exec(compile(asked(program, cell, "external", robot), "port.py", "exec"), module.__dict__)
    return module


def mjcf(robots):
    """The model."""
    model = ElementTree.Element("mujoco", model="transfer")
    ElementTree.SubElement(model, "compiler", boundinertia="1e-5")
    ElementTree.SubElement(
        model, "option", timestep=repr(STEP), gravity="0 0 -9.80665", integrator="implicitfast", cone="elliptic", impratio="20",
        noslip_iterations="10",
    )
    ElementTree.SubElement(part(model, "visual"), "headlight", ambient="0.4 0.4 0.4", diffuse="0.3 0.3 0.3")
    sky = {"type": "skybox", "builtin": "flat", "rgb1": "1 1 1", "width": "8", "height": "8"}
    ElementTree.SubElement(part(model, "asset"), "texture", sky)
    world = ElementTree.SubElement(model, "worldbody")
    ElementTree.SubElement(world, "light", pos="0 0 4", diffuse="0.4 0.4 0.4")
    ElementTree.SubElement(world, "geom", type="plane", size="3 3 0.1", pos="0 0 -0.45", rgba="0.85 0.85 0.85 1", contype="0", conaffinity="0")
    ElementTree.SubElement(
        world, "geom", name="table", type="box", pos=text(TABLE), size=text(np.array(TABLE_EDGES) / 2), friction="0.3", solref="0.004 1", rgba="0.6 0.45 0.3 1"
    )
    bar = ElementTree.SubElement(world, "body", name="bar", pos=text(BAR))
    ElementTree.SubElement(bar, "freejoint", name="bar")
    ElementTree.SubElement(
        bar, "geom", name="bar", type="box", size=text(np.array(EDGES) / 2), mass=repr(MASS), friction="0.3", solref="0.004 1", rgba="0.8 0.2 0.2 1"
    )
    sensors = part(model, "sensor")
    for robot in robots:
        if not robot.name.endswith("-hand"):
            robot.add(model, world)
            flange = world.find(f".//body[@name='{robot.name}/flange']")
            ElementTree.SubElement(flange, "site", name=f"{robot.name}/flange", size="0.01")
            for kind in ("force", "torque"):
                ElementTree.SubElement(sensors, kind, name=f"{robot.name}/{kind}", site=f"{robot.name}/flange")
    for hand in robots:
        if hand.name.endswith("-hand"):
            arm = hand.name.removesuffix("-hand")
            hand.add(model, yielding(world.find(f".//body[@name='{arm}/tool']"), hand.name))
            # The inner face of a pad is where its finger is.
            for finger, side in (("finger", 1.0), ("other_finger", -1.0)):
                body = world.find(f".//body[@name='{hand.name}/{finger}_link']")
                ElementTree.SubElement(
                    body, "geom", GRIP, type="box", size=text(PAD), pos=text([side * PAD[0], 0, 0]), mass="0", rgba="0.2 0.3 0.8 1"
                )
    return ElementTree.tostring(model, encoding="unicode")


def yielding(tool, name):
    """A palm that gives way to forces, in all six directions."""
    palm = ElementTree.SubElement(tool, "body", name=f"{name}/palm")
    for kind, axis in (("slide", "1 0 0"), ("slide", "0 1 0"), ("slide", "0 0 1"), ("ball", None)):
        spring = {"stiffness": repr(STIFFNESS[kind]), "damping": repr(DAMPED * STIFFNESS[kind])}
        ElementTree.SubElement(palm, "joint", {"axis": axis} if axis else {}, type=kind, **spring)
    ElementTree.SubElement(palm, "inertial", pos="0 0 0", mass=repr(PALM), diaginertia=" ".join([repr(PALM_INERTIA)] * 3))
    return palm


class Arm:
    """A robot with its servos."""

    def __init__(self, model, robot):
        self.robot, self.name = robot, robot.name
        self.index = np.array([model.actuator(name).id for name in robot.actuators()])
        count = len(self.index)
        self.inertia = np.array([float(robot.felt(i)["armature"]) for i in range(count)])
        peak = 1.0 if self.name.endswith("-hand") else PEAK
        self.most = np.array([peak * robot.effort(i) for i in range(count)])
        self.at = self.to = np.zeros(count)
        self.is_powered = False
        self.sensors = []
        if not self.name.endswith("-hand"):
            self.sensors = [model.sensor(f"{self.name}/{kind}").adr[0] for kind in ("force", "torque")]

    def place(self, model, data, joints):
        """Lets it stand there."""
        self.robot.place(model, data, joints)
        self.at = self.to = np.array(joints)

    def demand(self, data, joints, is_powered):
        """Where it is to be at the end of this period; without power it stays where its brakes caught it."""
        self.at = self.to
        if is_powered:
            self.to = np.array(joints)
        elif self.is_powered:
            self.at = self.to = data.actuator_length[self.index].copy()
        self.is_powered = is_powered

    def force(self, data, share, seconds):
        """Of its motors, at this share of the period: J (ω² e + 2 ω e')."""
        speed = (self.to - self.at) / seconds
        error = self.at + (self.to - self.at) * share - data.actuator_length[self.index]
        wanted = self.inertia * (OMEGA**2 * error + 2.0 * OMEGA * (speed - data.actuator_velocity[self.index]))
        return np.clip(wanted, -self.most, self.most)

    def wrench(self, data):
        """Of the surroundings on the flange, in its axes; a hand tells none."""
        if not self.sensors:
            return None
        return -np.concatenate([data.sensordata[adr : adr + 3] for adr in self.sensors])

    def state(self, data, port):
        return port.State(data.actuator_length[self.index], data.actuator_velocity[self.index], self.wrench(data))


class World:
    """The simulation. `starts`: where the robots of the cell's file stand."""

    def __init__(self, robots, starts):
        self.model = mujoco.MjModel.from_xml_string(mjcf(robots))
        self.data = mujoco.MjData(self.model)
        self.arms = [Arm(self.model, robot) for robot in robots]
        self.starts, self.placed = starts, {}
        self.has_moved = False

    def begin(self, orders):
        """Robots stand where they are to begin. With the first one of a cell, the bar is back on the table.

        A cell's robots begin in any order, and the solver goes on from what it found last: until all have begun, each is placed into a
        world as it is in the cell's file, so that neither what it is told nor what follows depends on that order.
        """
        if set(orders.begins) == set(orders.demanded):
            self.placed, self.has_moved = {}, False
        self.placed.update(orders.begins)
        if self.has_moved:
            for arm in self.arms:
                if arm.name in orders.begins:
                    arm.place(self.model, self.data, orders.begins[arm.name])
            mujoco.mj_forward(self.model, self.data)
        else:
            self.stand({**self.starts, **orders.begins})

    def stand(self, joints):
        """Everything as it is at first."""
        mujoco.mj_resetData(self.model, self.data)
        for arm in self.arms:
            arm.place(self.model, self.data, joints[arm.name])
        mujoco.mj_forward(self.model, self.data)

    def step(self, orders):
        """One servo period."""
        if not self.has_moved:
            self.stand({**self.starts, **self.placed})
            self.has_moved = True
        count = round(orders.seconds / STEP)
        for arm in self.arms:
            arm.demand(self.data, orders.demanded.get(arm.name, arm.to), orders.powered.get(arm.name, False))
        for i in range(count):
            for arm in self.arms:
                self.data.ctrl[arm.index] = arm.force(self.data, i / count, orders.seconds)
            mujoco.mj_step(self.model, self.data)
        mujoco.mj_forward(self.model, self.data)

    def row(self):
        """Of each robot what was demanded and where it is; the arms' wrenches; the bar's position and quaternion w, x, y, z; both tools' positions; by
        how much RNT's loop is open."""
        parts = [(arm.to, self.data.actuator_length[arm.index]) for arm in self.arms]
        wrenches = [arm.wrench(self.data) for arm in self.arms if arm.sensors]
        ends = [self.data.site(f"rnt/loop {i}").xpos for i in (0, 1)]
        gap = [np.linalg.norm(ends[0] - ends[1])]
        tools = [self.data.body(f"{arm.name}/tool").xpos for arm in self.arms if arm.sensors]
        return np.concatenate([*(x for pair in parts for x in pair), *wrenches, self.data.joint("bar").qpos, *tools, gap])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=ROOT / "target/debug/examples/transfer_mujoco", type=Path)
    parser.add_argument("--cell", default=Path(__file__).parent / "mujoco.toml", type=Path)
    parser.add_argument("--view", action="store_true", help="show MuJoCo's viewer")
    parser.add_argument("--png", type=Path, help="draw the world to this file, as it is when this program is told to end (MUJOCO_GL=egl)")
    parser.add_argument("--log", type=Path, help="write what was demanded and simulated")
    options = parser.parse_args()
    starts = {name: entry["start"] for name, entry in tomllib.loads(options.cell.read_text())["robots"].items()}
    names = list(starts)
    world = World([Robot(asked(options.program, options.cell, "export-urdf", name), name) for name in names], starts)
    port = port_of(options.program, options.cell, names[0])
    viewer = None
    if options.view:
        from mujoco.viewer import launch_passive

        viewer = launch_passive(world.model, world.data)
    log = open(options.log, "wb") if options.log else None
    try:
        with port.Plant() as plant:
            print(f"port {port.PORT}: {', '.join(names)} in MuJoCo {mujoco.__version__}", flush=True)
            for orders in plant:
                if orders.begins:
                    world.begin(orders)
                else:
                    world.step(orders)
                plant.answer({arm.name: arm.state(world.data, port) for arm in world.arms})
                if log is not None and not orders.begins:
                    log.write(struct.pack("<Q", orders.period) + world.row().tobytes())
                    log.flush()
                if viewer is not None and orders.period % 8 == 0:
                    viewer.sync()
    except KeyboardInterrupt:
        pass
    finally:
        if options.png:
            draw(world.model, world.data, options.png, lookat=(0.9, -0.1, 0.85), distance=2.3, azimuth=105)


if __name__ == "__main__":
    sys.exit(main())

"""Plans as MoveIt makes them, in a bag: a UR5e executes them.

In: the examples `plans` and `plans_bridge`, built. Out: exit status 0 if the arm goes through the points of plans that use the limits which the bridge
exports. MoveIt itself is not here: a plan is the fastest motion on a straight line of the joints, a trapezoid, in points that are 0.1 s apart.
"""

import json
import subprocess
import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from ending import interruptible  # noqa: E402
from tried import EXAMPLES, ended_after, has, listen_in, run  # noqa: E402

listen_in("92")

import numpy as np  # noqa: E402
from mcap.reader import make_reader  # noqa: E402
from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: E402
from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: E402
from ruamel.yaml import YAML  # noqa: E402

CELL = Path("ports/ros2/examples/plans.toml").resolve()
STEP = 0.002
START = np.array([0.0, -1.57, 1.57, -1.57, -1.57, 0.0])
GOAL = np.array([2.6, -1.3, 1.6, -1.87, -1.57, 0.6])
# MoveIt's messages. What a plan has behind its trajectories, the state at its start, is left out, since nobody reads it here.
DEFINITIONS = {
    "moveit_msgs/msg/RobotTrajectory": "trajectory_msgs/JointTrajectory one\ntrajectory_msgs/MultiDOFJointTrajectory several",
    "moveit_msgs/msg/DisplayTrajectory": "string model_id\nmoveit_msgs/RobotTrajectory[] trajectory",
}


def exported(folder):
    """What MoveIt is told: the joints of the controller `arm`, with their largest velocities and accelerations."""
    wrote = subprocess.run([EXAMPLES / "plans_bridge", "--cell", CELL, "--export-moveit", folder], capture_output=True, text=True)
    has(wrote.returncode == 0, wrote.stderr)
    controllers, limits = (YAML(typ="safe").load(folder / name) for name in ("moveit_controllers.yaml", "joint_limits.yaml"))
    names = controllers["moveit_simple_controller_manager"]["arm"]["joints"]
    return names, *(np.array([limits["joint_limits"][name][key] for name in names]) for key in ("max_velocity", "max_acceleration"))


def plan(start, goal, velocity, acceleration):
    """Times, positions, velocities and accelerations of the points."""
    line = goal - start
    most = lambda limits: np.min(limits[line != 0] / np.abs(line[line != 0]))  # noqa: E731
    speed, change = most(velocity), most(acceleration)
    ramp = min(speed / change, change**-0.5)
    end = 1 / (change * ramp) + ramp
    t = np.append(np.arange(0, end - 1e-9, 0.1), end)
    up, down = t < ramp, t > end - ramp
    place = np.select([up, down], [change * t**2 / 2, 1 - change * (end - t) ** 2 / 2], change * ramp * (t - ramp / 2))
    rate = change * np.minimum(ramp, np.minimum(t, end - t))
    return t, start + np.outer(place, line), np.outer(rate, line), np.outer(np.select([up, down], [change, -change], 0.0), line)


def display(bag, names, plans):
    """Writes plans into a bag, as `ros2 bag record /display_planned_path` does; the joints in an order that is not the arm's."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, fields in DEFINITIONS.items():
        store.register(get_types_from_msg(fields, name))
    kind = lambda name: store.types[name.replace("/", "/msg/")]  # noqa: E731
    head = kind("std_msgs/Header")(kind("builtin_interfaces/Time")(0, 0), "world")
    several = kind("trajectory_msgs/MultiDOFJointTrajectory")(head, [], [])
    order = np.argsort(names)
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection("/display_planned_path", kind("moveit_msgs/DisplayTrajectory").__msgtype__, typestore=store)
        for date, (times, *told) in enumerate(plans):
            points = []
            for at, *values in zip(times, *told):
                since = kind("builtin_interfaces/Duration")(int(at), int(round(at % 1 * 1e9)))
                values = [value[order] for value in values]
                points.append(kind("trajectory_msgs/JointTrajectoryPoint")(*values, np.array([]), since))
            one = kind("trajectory_msgs/JointTrajectory")(head, [names[k] for k in order], points)
            plan = kind("moveit_msgs/DisplayTrajectory")("ur5e", [kind("moveit_msgs/RobotTrajectory")(one, several)])
            writer.write(topic, 10**18 + date, store.serialize_cdr(plan, topic.msgtype))


def compared(file, times, positions):
    """How many points of a plan demands are compared with, and how far they are from them \[rad\].

    In the first half second the arm comes to the plan. Where a late machine has missed a demand, it comes back to it within 20 steps.
    """
    time, missed, found = 0.0, -20, {}
    with open(file, "rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages(["/steps", "/robots/arm"]):
            said = json.loads(message.data)
            time += said.get("dt", 0.0)
            missed = said["step"] if said.get("mode") == "bridging" else missed
            if said.get("mode") == "moving" and said["step"] > missed + 20:
                found[round(time / STEP)] = np.array(said["demanded"]["joints"])
    later = [k for k, at in enumerate(times[:-1]) if at > 0.5]
    nearest = (0, np.inf)
    for begin in found:
        there = [(found.get(begin + round(times[k] / STEP)), positions[k]) for k in later]
        apart = [np.abs(demanded - point).max() for demanded, point in there if demanded is not None]
        if 2 * len(apart) > len(later) and max(apart) < nearest[1]:
            nearest = (len(apart), max(apart))
    return nearest


def test(folder):
    names, velocity, acceleration = exported(folder)
    plans = [plan(*ends, velocity, acceleration) for ends in ((START, GOAL), (GOAL, START))]
    display(folder / "plans", names, plans)
    options = ["--processes", "--no-picture", "--quiet", "--record", folder / "run.mcap", "--outcome", folder / "outcome.json"]
    cell = subprocess.Popen([EXAMPLES / "plans", "--cell", CELL, *options], preexec_fn=interruptible)
    bridge = subprocess.Popen(
        [EXAMPLES / "plans_bridge", "--cell", CELL, "--from-bag", folder / "plans"], stderr=subprocess.PIPE, text=True, preexec_fn=interruptible
    )
    limit = threading.Timer(60, bridge.kill)
    limit.start()
    with ended_after(cell, bridge):
        said = [bridge.stderr.readline().strip() for _ in range(3)]
    limit.cancel()
    has(said[1:] == [f"bag: trajectory {k} of 2: done" for k in (1, 2)], f"the bridge says {said}")
    for times, positions, *_ in plans:
        count, far = compared(folder / "run.mcap", times, positions)
        print(f"  a plan that takes {times[-1]:.2f} s: the arm is within {far:.1e} rad of {count} points")
        has(far < 1e-9, "the arm does not go through the points of a plan")


run("a UR5e executes plans as MoveIt makes them", test)

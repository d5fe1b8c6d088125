"""A cell with a bridge, among nodes of rclpy and Cyclone DDS.

In: the examples `arms` and `bridge`, built. Out: exit status 0 if what the nodes heard is what the cell recorded, and what they asked for was
done, or refused as it should be. `--seconds N`: for how long topics are looked at.
"""

import json
import os
import struct
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cell_outcome import Outcome  # noqa: E402
from ending import interruptible  # noqa: E402
from tried import EXAMPLES, ended_after, has, listen_in, run  # noqa: E402

DOMAIN = "87"
listen_in(DOMAIN)
# Cyclone DDS speaks on loopback alone, like the others.
os.environ["CYCLONEDDS_URI"] = (
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='true'/></Interfaces>"
    "</General></Domain></CycloneDDS>"
)

import numpy as np  # noqa: E402
import rclpy  # noqa: E402
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from geometry_msgs.msg import WrenchStamped  # noqa: E402
from mcap.reader import make_reader  # noqa: E402
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue  # noqa: E402
from rcl_interfaces.srv import SetParameters  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import Bool, String  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

HERE = Path(__file__).resolve().parent
CELL = Path("ports/panel/examples/cell.toml").resolve()
STEP = 2_000_000  # [ns]
KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def bits(numbers):
    return struct.pack(f"{len(numbers)}d", *numbers)


def date(message):
    """Its stamp [ns]."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


class Nodes:
    """A node of rclpy that hears everything."""

    def __init__(self):
        self.node = rclpy.create_node("stranger")
        self.states, self.demanded = ({"left": {}, "right": {}} for _ in range(2))
        self.names, self.urdfs, self.said, self.diagnosed, self.signals = {}, {}, [], [], {}
        for robot in self.states:
            for of, topic in (("measured", "joint_states"), ("demanded", "demanded_joint_states")):
                hear = lambda message, robot=robot, of=of: self.hear(robot, of, message)  # noqa: E731
                self.node.create_subscription(JointState, f"/{robot}/{topic}", hear, 2000)
            keep = lambda message, robot=robot: self.urdfs.update({robot: message.data})  # noqa: E731
            self.node.create_subscription(String, f"/{robot}/robot_description", keep, KEPT)
        self.wrenches = []
        self.node.create_subscription(WrenchStamped, "/sensors/wrist", self.wrenches.append, 2000)
        self.node.create_subscription(String, "/cell/state", lambda message: self.said.append(message.data), KEPT)
        self.instructions = []
        self.node.create_subscription(String, "/cell/instruction", lambda message: self.instructions.append(message.data), KEPT)
        for topic in ("inputs/gripped", "outputs/gripper", "outputs/spindle"):
            keep = lambda message, topic=topic: self.signals.update({topic: message.data})  # noqa: E731
            self.node.create_subscription(Bool, f"/left/{topic}", keep, KEPT)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self.diagnosed.append, 10)
        self.buttons = {
            name: self.node.create_client(Trigger, f"/cell/{name}")
            for name in ("suspend", "resume", "abort", "stop", "acknowledge", "reset")
        }
        self.parameters = self.node.create_client(SetParameters, "/cell/set_parameters")

    def hear(self, robot, of, message):
        self.names[robot] = list(message.name)
        states = self.states if of == "measured" else self.demanded
        states[robot][date(message)] = (list(message.position), list(message.velocity))

    def spin(self, seconds):
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0:
            rclpy.spin_once(self.node, timeout_sec=left)

    def spin_until(self, is_so, what, seconds=20):
        until = time.monotonic() + seconds
        while not is_so():
            has(time.monotonic() < until, f"{what} does not come")
            rclpy.spin_once(self.node, timeout_sec=0.05)

    def ask(self, client, request, what):
        has(client.wait_for_service(timeout_sec=20), f"{what} is not there")
        answered = client.call_async(request)
        self.spin_until(answered.done, f"the answer of {what}")
        return answered.result()

    def press(self, button):
        answer = self.ask(self.buttons[button], Trigger.Request(), button)
        print(f"  {button}: {answer.success}, {answer.message}")
        return answer

    def set_speed(self, speed):
        value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=speed)
        request = SetParameters.Request(parameters=[Parameter(name="speed", value=value)])
        return self.ask(self.parameters, request, "set_parameters").results[0]

    def changes(self, robot, seconds=0.3):
        """By how much a robot's joints change meanwhile [rad]."""
        before = dict(self.states[robot])
        self.spin(seconds)
        new = [q for stamp, (q, _) in sorted(self.states[robot].items()) if stamp not in before]
        has(len(new) > 10, f"{robot} is not heard")
        return float(np.abs(np.array(new[-1]) - np.array(new[0])).max())


def recorded(file):
    """What the cell recorded of its robots, by step: joints and velocities, and the pose of the tool, measured and demanded; its readings of the wrist, by the step in
    which they were taken; and what its coordinator did."""
    robots, readings, instructions = {"left": {}, "right": {}}, {}, set()
    with open(file, "rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            name = channel.topic.removeprefix("/robots/")
            if name in robots:
                said = json.loads(message.data)
                robots[name][said["step"]] = said
            elif name == "/sensors/wrist":
                said = json.loads(message.data)
                readings[said["taken"]] = said["reading"]
            elif name == "/instructions" and (said := json.loads(message.data))["process"] == "mp":
                instructions.add(f"{said['doing']} {said['by']}".rstrip() if said["doing"] != "nothing" else "nothing")
    return robots, readings, instructions


def in_world(transforms, frame):
    """The homogeneous matrix of a frame in the world."""
    matrix = np.eye(4)
    while frame != "world":
        parent, numbers = transforms[frame]
        x, y, z, w = numbers[3:]
        one = np.eye(4)
        one[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        one[:3, 3] = numbers[:3]
        matrix, frame = one @ matrix, parent
    return matrix


def compare(nodes, file, links):
    """What was heard with what was recorded."""
    record, readings, instructions = recorded(file)
    heard = set(nodes.instructions)
    print(f"  instructions: {sorted(heard)}, of {len(instructions)} that are recorded")
    has(heard - {"nothing"} and heard <= instructions | {"nothing"}, f"instructions {heard}, recorded {instructions}")
    for robot, heard in nodes.states.items():
        stamps = sorted(heard)
        gaps = {b - a for a, b in zip(stamps, stamps[1:])}
        has(all(gap % STEP == 0 for gap in gaps), f"{robot}: stamps are {sorted(gaps)[:5]} ns apart")
        steps = record[robot]
        # The stamps say how far apart steps are; which one the first is, its joints say.
        first = next(step for step in steps if bits(steps[step]["measured"]["joints"]) == bits(heard[stamps[0]][0]))
        zero = stamps[0] - first * STEP
        check_states(f"{robot}, measured", heard, {step: said["measured"] for step, said in steps.items()}, zero)
        check_states(f"{robot}, demanded", nodes.demanded[robot], {step: said["demanded"] for step, said in steps.items()}, zero)
        check_links(robot, steps, {stamp: (stamp - zero) // STEP for stamp in stamps}, links)
    # All stamps have one zero.
    check_wrenches(nodes.wrenches, readings, zero)


def check_states(what, heard, steps, zero):
    of_stamp = {stamp: (stamp - zero) // STEP for stamp in heard}
    there = {stamp: step for stamp, step in of_stamp.items() if step in steps}
    same = sum(
        bits(steps[step]["joints"]) == bits(heard[stamp][0]) and bits(steps[step]["velocity"]) == bits(heard[stamp][1])
        for stamp, step in there.items()
    )
    has(there and same == len(there), f"{what}: {len(there) - same} of {len(there)} joint states differ from the recording")
    told = set(there.values())
    first, last = min(told), max(told)
    missed = sum(first <= step <= last for step in steps) - len(told)
    print(f"  {what}: {same} joint states are the recorded ones to the bit, {missed} of {last - first + 1} missed")
    has(missed == 0, f"{what}: rclpy missed {missed} joint states")


def check_wrenches(heard, readings, zero):
    has(heard and {message.header.frame_id for message in heard} == {"left/tool"}, f"{len(heard)} wrenches: {heard[:1]}")
    steps = [(date(message) - zero) // STEP for message in heard]
    for step, message in zip(steps, heard):
        for told, of in ((message.wrench.force, "force"), (message.wrench.torque, "torque")):
            has(bits((told.x, told.y, told.z)) == bits(readings[step][of]), f"the {of} of step {step} is {told}, not {readings[step]}")
    missed = sum(steps[0] <= step <= steps[-1] for step in readings) - len(set(steps))
    print(f"  wrist: {len(heard)} wrenches are the recorded readings to the bit, {missed} missed")
    has(missed == 0, f"rclpy missed {missed} wrenches")


def check_links(robot, steps, of_stamp, links):
    static, moving = {}, {}
    for is_static, stamp, parent, child, numbers in links:
        if is_static:
            static[child] = (parent, numbers)
        elif child.startswith(f"{robot}/"):
            moving.setdefault(stamp, {})[child] = (parent, numbers)
    compared, worst = 0, 0.0
    for stamp, transforms in moving.items():
        step = of_stamp.get(stamp)
        if step not in steps:
            continue
        tool = in_world(static | transforms, f"{robot}/tool")
        pose = steps[step]["measured"]["pose"]["position"]
        worst = max(worst, float(np.abs(tool[:3, 3] - [pose[axis] for axis in "xyz"]).max()))
        compared += 1
    print(f"  {robot}: {compared} chains of transforms by Cyclone DDS end at the recorded tool, within {worst:.1e} m")
    has(compared > 50 and worst < 1e-9, f"{robot}: {compared} chains, {worst} m apart")


def check_signals(nodes):
    """The gripper is switched at every turn, and its input follows."""
    off = {"inputs/gripped": False, "outputs/gripper": False, "outputs/spindle": False}
    nodes.spin_until(lambda: nodes.signals == off, "a gripper that is off")
    nodes.spin_until(lambda: nodes.signals == off | {"inputs/gripped": True, "outputs/gripper": True}, "a gripper that is on")
    print("  the gripper's output, and the input that follows it, are heard")


def check_kept(nodes):
    """Who comes later hears the last state alone, though it would take ten."""
    heard = []
    later = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node = rclpy.create_node("later")
    node.create_subscription(String, "/cell/state", lambda message: heard.append(message.data), later)
    until = time.monotonic() + 3
    while time.monotonic() < until:
        rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_node()
    print(f"  a node that comes later hears {heard}, after {len(nodes.said)} states")
    has(heard[-1:] == nodes.said[-1:], f"a node that comes later hears {heard}")


def operate(nodes):
    """The buttons and the speed."""
    answer = nodes.press("suspend")
    has(answer.success, "suspend is refused")
    nodes.spin_until(lambda: nodes.said[-1] == "suspended", "suspended")
    nodes.spin(1.0)
    # An encoder's pulse is 1e-5 rad of a joint.
    moved = nodes.changes("left")
    has(moved < 1e-4, f"left moves by {moved} rad while it is suspended")
    has(nodes.press("resume").success, "resume is refused")
    nodes.spin_until(lambda: nodes.said[-1] == "running", "running")
    refused = nodes.set_speed(1.5)
    has(not refused.successful and "0.0 to 1.0" in refused.reason, f"a speed of 1.5: {refused}")
    has(nodes.set_speed(0.5).successful, "a speed of 0.5 is refused")
    has(not nodes.press("reset").success, "a reset of a cell that runs is not refused")
    has(nodes.press("stop").success, "stop is refused")
    nodes.spin_until(lambda: nodes.said[-1] == "latched", "latched")
    nodes.diagnosed.clear()
    nodes.spin_until(lambda: nodes.diagnosed, "a diagnosis")
    cell = nodes.diagnosed[-1].status[0]
    has(cell.level == b"\x02" and cell.name == "cell" and cell.message, f"a cell that was stopped: {cell}")
    print(f"  diagnostics: {cell.message}")
    has(nodes.press("acknowledge").success and nodes.press("reset").success, "a reset is refused")
    nodes.spin_until(lambda: nodes.said[-1] == "running", "running after a reset")
    has(nodes.changes("right", 1.0) > 0.0, "right does not move after a reset")


def test(folder, seconds):
    bridge = subprocess.Popen([EXAMPLES / "bridge", "--cell", CELL, "--buttons"], stderr=subprocess.PIPE, text=True, preexec_fn=interruptible)
    has(f"node /cell: domain {DOMAIN} at 127.0.0.1, with buttons" in bridge.stderr.readline(), "the bridge does not begin")
    links = subprocess.Popen(
        [sys.executable, HERE / "links.py", folder / "links.jsonl", DOMAIN, str(seconds + 4)], stdout=subprocess.PIPE, text=True
    )
    has(links.stdout.readline() == "ready\n", "Cyclone DDS does not begin")
    nodes = Nodes()
    # Who has found one another misses nothing of what comes then.
    nodes.spin_until(lambda: len(nodes.urdfs) == 2, "robot_description")
    nodes.spin(1.0)
    options = ["--processes", "--no-picture", "--quiet", "--record", folder / "run.mcap", "--outcome", folder / "outcome.json"]
    cell = subprocess.Popen([EXAMPLES / "arms", "--cell", CELL, *options], preexec_fn=interruptible)
    with ended_after(cell, bridge):
        nodes.spin_until(lambda: all(nodes.states.values()), "a joint state")
        nodes.spin(seconds)
        check_signals(nodes)
        operate(nodes)
        check_kept(nodes)
        print("  a killed bridge:")
        bridge.kill()
        bridge.wait()
        time.sleep(0.5)
        has(cell.poll() is None, "the cell ended with its bridge")
    outcome = Outcome(folder / "outcome.json")
    has(outcome.kind == "Aborted", f"the cell ended by {outcome}")
    print("    the cell goes on, until it is interrupted")
    links.wait(timeout=30)
    lines = [json.loads(line) for line in (folder / "links.jsonl").read_text().splitlines()]
    compare(nodes, folder / "run.mcap", lines)
    for robot, names in nodes.names.items():
        has(all(f'<joint name="{name}" type="' in nodes.urdfs[robot] for name in names), f"{robot}: {names}")


def main():
    seconds = float(sys.argv[sys.argv.index("--seconds") + 1]) if "--seconds" in sys.argv else 6.0
    rclpy.init()
    run("a cell among nodes of rclpy and Cyclone DDS", lambda folder: test(folder, seconds))


main()

"""A topic of rclpy as a sensor of a cell: an arm whose tool follows its twists, then its poses.

In: the examples `servo` and `servo_bridge`, built. Out: exit status 0 if the cell read what was published, refused what is none, and stopped the arm on its path when
the topic fell silent.
"""

import json
import math
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cell_outcome import Outcome  # noqa: E402
from ending import interruptible  # noqa: E402
from tried import EXAMPLES, ended_after, has, listen_in, run  # noqa: E402

listen_in("89")

import numpy as np  # noqa: E402
import rclpy  # noqa: E402
from geometry_msgs.msg import PoseStamped, TwistStamped  # noqa: E402
from mcap.reader import make_reader  # noqa: E402
from rclpy.qos import QoSProfile, ReliabilityPolicy  # noqa: E402
from rclpy.serialization import serialize_message  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import Float64MultiArray, String  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

CELL, POSES = (Path(f"ports/ros2/examples/{name}.toml").resolve() for name in ("servo", "poses"))
TOPIC = "/servo/twist"
STEP = 0.002
PERIOD = 0.02
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
MUCH = QoSProfile(depth=2000, reliability=ReliabilityPolicy.BEST_EFFORT)


class Bridge:
    """The bridge, and what it says."""

    def __init__(self, cell, *options):
        command = [EXAMPLES / "servo_bridge", "--cell", cell, *options]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=interruptible)
        self.said = []
        threading.Thread(target=lambda: self.said.extend(iter(self.process.stderr.readline, "")), daemon=True).start()
        self.until("node /cell: domain")

    def has_said(self, words):
        return any(words in line for line in self.said)

    def until(self, words, seconds=20.0, meanwhile=lambda: time.sleep(0.02)):
        end = time.monotonic() + seconds
        while not self.has_said(words):
            has(time.monotonic() < end and self.process.poll() is None, f"the bridge does not say `{words}`, but {self.said}")
            meanwhile()

    def kill(self):
        self.process.kill()
        self.process.wait()


class Stick:
    """A node that publishes twists, and presses the cell's buttons."""

    def __init__(self):
        self.node = rclpy.create_node("stick")
        self.publisher = self.node.create_publisher(TwistStamped, TOPIC, 10)
        self.buttons = {name: self.node.create_client(Trigger, f"/cell/{name}") for name in ("acknowledge", "reset")}
        self.states = []
        self.node.create_subscription(String, "/cell/state", lambda message: self.states.append(message.data), 10)
        # What the cell has read comes back; a best-effort subscriber may miss some of it.
        self.read = []
        self.node.create_subscription(Float64MultiArray, "/sensors/stick/linear", lambda message: self.read.append(list(message.data)), MUCH)
        # A topic that is best effort, and one message of ten.
        self.stamps, self.reliable = [], []
        self.node.create_subscription(JointState, "/arm/joint_states", lambda message: self.stamps.append(message.header.stamp), MUCH)
        self.node.create_subscription(JointState, "/arm/joint_states", self.reliable.append, 10)
        self.published, self.due = [], time.monotonic()

    def twist(self, z):
        message = TwistStamped()
        message.header.stamp = self.node.get_clock().now().to_msg()
        # Each of them is another one.
        message.twist.linear.z = z + 1e-9 * len(self.published)
        message.twist.angular.x = 1e-3 * math.sin(len(self.published))
        return message

    def publish(self, z):
        """Publishes a twist, and spins until the next one is due."""
        message = self.twist(z)
        self.publisher.publish(message)
        self.published.append((message.twist.linear.z, message.twist.angular.x))
        self.due = max(self.due + PERIOD, time.monotonic())
        self.spin(self.due - time.monotonic())

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            rclpy.spin_once(self.node, timeout_sec=left)

    def go(self, seconds):
        """Up and down, once in two seconds."""
        for k in range(int(seconds / PERIOD)):
            self.publish(0.03 * math.sin(math.pi * k * PERIOD))

    def until(self, is_so, what, meanwhile, seconds=60.0):
        end = time.monotonic() + seconds
        while not is_so():
            has(time.monotonic() < end, f"{what} does not come, states {self.states}")
            meanwhile()

    def press(self, button):
        has(self.buttons[button].wait_for_service(timeout_sec=20), f"{button} is not there")
        answered = self.buttons[button].call_async(Trigger.Request())
        self.until(answered.done, button, lambda: self.publish(0.0))
        has(answered.result().success, f"{button}: {answered.result().message}")


class Stranger:
    """Another participant, with a publisher to the same topic."""

    def __init__(self, name, kind, qos=10):
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node(name, context=self.context)
        self.publisher = self.node.create_publisher(kind, TOPIC, qos)

    def end(self):
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


def refusals(bridge, stick):
    """Messages that are none, and publishers that may not publish: the arm goes on following the first one."""
    foreign, second = Stranger("foreign", String), Stranger("second", TwistStamped)

    def meanwhile():
        foreign.publisher.publish(String(data="left"))
        second.publisher.publish(stick.twist(-0.05))
        stick.publish(0.01)

    bridge.until("it publishes std_msgs/msg/String, not geometry_msgs/msg/TwistStamped", meanwhile=meanwhile)
    bridge.until("another publisher sends to the same topic", meanwhile=meanwhile)
    foreign.end()
    second.end()
    good = serialize_message(stick.twist(0.0))
    late = stick.twist(0.0)
    late.header.stamp.sec = 0
    ahead = stick.twist(0.0)
    ahead.header.stamp.sec += 60
    for bad, told in [
        (good[:-5], "it is too short: it ends in `z`"),
        (good + bytes(40), "it is too long: "),
        (good[:12] + b"\xff\xff\xff\x7f" + good[16:], "it is too short: it ends in `frame_id`"),
        (late, "leave `stamp` out"),
        (ahead, "ahead of this machine's clock"),
    ]:
        stick.publisher.publish(bad)
        bridge.until(told, meanwhile=lambda: stick.publish(-0.01))
    has(stick.states[-1:] == ["running"], f"states {stick.states}")
    print(f"  refused by name: {sum('is refused' in line for line in bridge.said)} kinds of messages, and the arm goes on")


def quality_of_service(folder):
    """A bridge that asks for more than publishers offer says whom it does not hear; one with a wrong type says what to write."""
    text = CELL.read_text()
    (folder / "reliable.toml").write_text(text.replace('stamp = "header.stamp"', 'stamp = "header.stamp"\nreliability = "reliable"'))
    bridge, stranger = Bridge(folder / "reliable.toml"), Stranger("unheard", TwistStamped, BEST_EFFORT)
    try:
        bridge.until("a publisher is not heard: it is best effort")
        heard = Stranger("heard", TwistStamped)
        message = serialize_message(TwistStamped())[:-8]
        bridge.until("it is too short", meanwhile=lambda: (heard.publisher.publish(message), time.sleep(0.1)))
        heard.end()
    finally:
        bridge.kill()
        stranger.end()
    (folder / "wrong.toml").write_text(text.replace("TwistStamped", "TwistStampd"))
    wrong = subprocess.run([EXAMPLES / "servo_bridge", "--cell", folder / "wrong.toml"], capture_output=True, text=True, timeout=30)
    has(wrong.returncode == 2 and "did you mean `geometry_msgs/msg/TwistStamped`?" in wrong.stderr, f"a wrong type: {wrong}")
    for name, said in (("/arm/joint_state", "did you mean `/arm/joint_states`?"), ("/tf_static", "leave the table out"), ("/tf", "leave `every_ms` out")):
        (folder / "wrong.toml").write_text(text.replace("/arm/joint_states", name))
        wrong = subprocess.run([EXAMPLES / "servo_bridge", "--cell", folder / "wrong.toml"], capture_output=True, text=True, timeout=30)
        has(wrong.returncode == 2 and said in wrong.stderr, f"topic {name}: {wrong}")
    print("  where the topic is to be reliable, a reliable publisher is heard, and a best-effort one is named; so is a type that is not there")


def test(folder):
    bridge = Bridge(CELL, "--buttons")
    stick = Stick()
    has(bridge.has_said(f"sensor `stick` reads {TOPIC}, geometry_msgs/msg/TwistStamped"), f"{bridge.said}")
    options = ["--processes", "--no-picture", "--quiet", "--record", folder / "run.mcap", "--outcome", folder / "outcome.json"]
    cell = subprocess.Popen([EXAMPLES / "servo", "--cell", CELL, *options], preexec_fn=interruptible)
    with ended_after(cell, bridge):
        stick.until(lambda: stick.states[-1:] == ["running"], "a cell that runs", lambda: stick.publish(0.0))
        stick.go(4.0)
        counted = len(stick.published)
        refusals(bridge, stick)
        for _ in range(30):
            stick.publish(0.05)
        # Silence, in motion.
        stick.until(lambda: stick.states[-1] == "latched", "a stop", lambda: stick.spin(0.05))
        # From here on a best-effort publisher goes on.
        stick.node.destroy_publisher(stick.publisher)
        stick.publisher = stick.node.create_publisher(TwistStamped, TOPIC, BEST_EFFORT)
        for _ in range(50):
            stick.publish(0.0)
        stick.press("acknowledge")
        stick.press("reset")
        stick.until(lambda: stick.states[-1] == "running", "running after a reset", lambda: stick.publish(0.0))
        again = len(stick.published)
        stick.go(2.0)
        print("  a killed bridge:")
        bridge.kill()
        for _ in range(60):
            stick.publish(0.02)
        has(cell.poll() is None, "the cell ended with its bridge")
    outcome = Outcome(folder / "outcome.json")
    print(f"    {outcome}")
    has(outcome.kind == "SensorStale" and "stick" in outcome.text, f"the cell ended by {outcome}")
    check(folder / "run.mcap", stick, counted, again)
    quality_of_service(folder)


def poses(folder):
    """A tool follows poses: it comes to each of them, and to rest where they fall silent on the way to one."""
    # Where it begins, as a short run under the virtual clock says.
    begun = [EXAMPLES / "servo", "--cell", POSES, "--no-picture", "--quiet", "--record", folder / "begun.mcap", "--", "--seconds", "0.1"]
    subprocess.run(begun, check=True, timeout=60)
    _, _, demands, _ = recorded(folder / "begun.mcap")
    start = pose_of(demands[min(demands)])
    bridge, node = Bridge(POSES), rclpy.create_node("poses")
    publisher = node.create_publisher(PoseStamped, "/servo/pose", 10)
    states = []
    node.create_subscription(String, "/cell/state", lambda message: states.append(message.data), 10)
    options = ["--processes", "--no-picture", "--quiet", "--record", folder / "poses.mcap", "--outcome", folder / "outcome.json"]
    cell = subprocess.Popen([EXAMPLES / "servo", "--cell", POSES, *options], preexec_fn=interruptible)

    def publish(seconds, goal):
        for _ in range(int(seconds / PERIOD)):
            message = PoseStamped()
            message.header.stamp = node.get_clock().now().to_msg()
            for part, values in ((message.pose.position, goal[0]), (message.pose.orientation, goal[1])):
                for axis, value in zip("xyzw", values):
                    setattr(part, axis, float(value))
            publisher.publish(message)
            due = time.monotonic() + PERIOD
            while (left := due - time.monotonic()) > 0:
                rclpy.spin_once(node, timeout_sec=left)

    goals = [turned(start, *by) for by in (([0, 0, 0.05], 0.0), ([0.04, -0.04, 0.0], 0.3), ([0.0, 0.0, -0.03], -0.2))]
    with ended_after(cell, bridge):
        end = time.monotonic() + 60
        while states[-1:] != ["running"]:
            has(time.monotonic() < end, f"the cell does not begin, states {states}")
            publish(0.1, start)
        # It waits for its first reading.
        publish(2.0, start)
        for goal in goals:
            publish(3.0, goal)
        publish(0.5, turned(start, [0.0, 0.0, 0.1], 0.0))
        # Until the sensor is stale.
        time.sleep(2.0)
    outcome = Outcome(folder / "outcome.json")
    has(outcome.kind == "SensorStale" and "goal" in outcome.text, f"the cell ended by {outcome}")
    _, _, demands, stale = recorded(folder / "poses.mcap")
    at = [pose_of(demands[k]) for k in sorted(demands) if k <= stale[0]]
    for goal in goals:
        off, angle = min((np.linalg.norm(place - goal[0]), 2 * math.acos(min(1.0, abs(turn @ goal[1])))) for place, turn in at)
        print(f"  a pose: the tool comes within {off:.1e} m and {angle:.1e} rad of it")
        has(off < 1e-5 and angle < 1e-4, "the tool does not come to a pose")
    places = np.array([place for place, _ in at])
    resting = np.linalg.norm(places[-1] - places[-2]) / STEP
    most = acceleration(demands, range(2, stale[0] + 1))
    print(f"  silence: the tool rests ({resting:.1e} m/s) {abs(places[-1][2] - start[0][2]):.3f} m on its way, and accelerates by at most {most:.3f} m/s^2, of 0.5")
    has(resting < 1e-9 and most < 0.51 and 0.0 < places[-1][2] - start[0][2] < 0.09, "the tool does not rest on its way")


def acceleration(demands, steps):
    """The tool's largest acceleration [m/s^2] in steps that did not follow within 20 on one whose demand had not come in time: then the arm comes back to its path."""
    late = {k + n for k in demands if demands[k]["mode"] == "bridging" for n in range(20)}
    at = {k: pose_of(demands[k])[0] for k in demands}
    punctual = [k for k in steps if all(k - n in at for n in range(3)) and k not in late]
    return max(np.linalg.norm(at[k] - 2 * at[k - 1] + at[k - 2]) for k in punctual) / STEP**2


def pose_of(demanded):
    pose = demanded["pose"]
    return np.array([pose["position"][axis] for axis in "xyz"]), np.array([pose["orientation"][axis] for axis in "xyzw"])


def turned(pose, by, angle):
    """A pose that is moved in the world, and turned about the world's z."""
    (x, y, z, w), (s, c) = pose[1], (math.sin(angle / 2), math.cos(angle / 2))
    return pose[0] + np.array(by), np.array([c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z])


def recorded(file):
    """What was read, in the order in which it was, and of each step; demands of the arm by step, and the steps in which the sensor was stale."""
    read, every, demands, stale = [], [], {}, []
    with open(file, "rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            said = json.loads(message.data)
            if channel.topic == "/sensors/stick" and said.get("reading"):
                of = said["reading"]
                every.append(of["linear"])
                twist = (of["linear"][2], of["angular"][0])
                if read[-1:] != [twist]:
                    read.append(twist)
            elif channel.topic == "/robots/arm":
                demands[said["step"]] = said["demanded"] | {"mode": said["mode"]}
            elif channel.topic == "/events" and said["what"] == "fault" and "too old" in said["text"]:
                # In which step it was so: the event itself is when the arm had stopped.
                stale.append(int(re.search(r"at step (\d+)", said["text"])[1]))
    return read, every, demands, stale


def check(file, stick, counted, again):
    read, every, demands, stale = recorded(file)
    place = {twist: k for k, twist in enumerate(stick.published)}
    strange = [twist for twist in read if twist not in place]
    has(not strange, f"{len(strange)} readings were never published: {strange[:3]}")
    places = [place[twist] for twist in read]
    has(places == sorted(set(places)), "readings are not in the order in which they were published")
    for what, begin, end in [("reliable", places[0], counted), ("best effort", again, again + int(2.0 / PERIOD))]:
        got = sum(begin <= k < end for k in places)
        print(f"  {what}: {got} of {end - begin} twists are readings to the bit, and each reading is a twist")
        has(got >= 0.95 * (end - begin), f"{end - begin - got} twists of a {what} publisher are no readings")
    recorded_ones = iter(every)
    in_order = all(any(reading == other for other in recorded_ones) for reading in stick.read)
    print(f"  rclpy hears {len(stick.read)} readings of the cell, of {len(every)}")
    has(len(stick.read) > 100 and in_order, "what rclpy hears of the readings is not what was recorded")
    stamps = [stamp.sec + stamp.nanosec / 1e9 for stamp in stick.stamps]
    rate = (len(stamps) - 1) / (stamps[-1] - stamps[0])
    print(f"  a best-effort subscriber hears {rate:.1f} joint states in a second, a reliable one {len(stick.reliable)}")
    # Fewer where the bridge or this node was late. More by 2 % at most, where the last one was late by 0.2 s in 10 s.
    has(len(stamps) > 20 and rate < 51 and not stick.reliable, f"{rate} joint states in a second, {len(stick.reliable)} heard by a reliable subscriber")
    has(stale, "no fault SensorStale is recorded")
    stop = stale[0]
    known = [k for k in sorted(demands) if stop - 500 <= k <= stop and k - 1 in demands]
    at = {k: np.array([demands[k]["pose"]["position"][axis] for axis in "xyz"]) for k in [known[0] - 1, *known]}
    speed = {k: np.linalg.norm(at[k] - at[k - 1]) / STEP for k in known}
    fastest = max(known, key=lambda k: speed[k])
    rest = next(k for k in known if k > fastest and speed[k] < 1e-9)
    print(f"  silence: the arm rests {(stop - rest) * STEP:.3f} s before its sensor is stale, from {speed[fastest]:.3f} m/s")
    has(speed[fastest] > 0.04, f"the arm moves by {speed[fastest]} m/s before the silence")
    # 0.05 m/s at 0.5 m/s^2 take 0.1 s, after a deadline of 0.1 s; the sensor is stale at 0.6 s.
    has(0.3 < (stop - rest) * STEP < 0.5, "the arm does not rest in time")
    most = acceleration(demands, known[2:])
    print(f"  its tool accelerates by at most {most:.3f} m/s^2, of 0.5")
    has(most < 0.51, f"{most} m/s^2")


rclpy.init()
run("a topic of rclpy is a sensor", test)
run("a tool follows poses of a topic", poses)

"""What others do to a bridge that they should not: a second bridge, floods, packets that are damaged or none of DDS, and other types by its names.

In: the examples `goals`, `servo` and their bridges, built. Out: exit status 0 if the goal at work goes on, nothing moves that should not, and the bridge serves
new nodes afterwards. `--requests`: the part of Cyclone DDS, which sends requests that are none.
"""

import os
import random
import re
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cell_outcome import Outcome  # noqa: E402
from ending import interruptible  # noqa: E402
from tried import EXAMPLES, ended_after, has, listen_in, run  # noqa: E402

DOMAIN = "94"
listen_in(DOMAIN)
# Cyclone DDS speaks on loopback alone, like the others.
os.environ["CYCLONEDDS_URI"] = (
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='true'/></Interfaces>"
    "</General></Domain></CycloneDDS>"
)

import rclpy  # noqa: E402
from action_msgs.msg import GoalStatus  # noqa: E402
from builtin_interfaces.msg import Duration  # noqa: E402
from control_msgs.action import FollowJointTrajectory as Follow  # noqa: E402
from geometry_msgs.msg import TwistStamped  # noqa: E402
from rclpy.action import ActionClient  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import String  # noqa: E402
from std_srvs.srv import SetBool, Trigger  # noqa: E402
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint  # noqa: E402

GOALS = Path("ports/ros2/examples/goals.toml").resolve()
SERVO = Path("ports/ros2/examples/servo.toml").resolve()
HOME = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
NAMES = ["column", "lower_arm", "upper_arm", "wrist_t", "wrist_v", "flange_n"]
SEED = 20_260
# The kinds of submessages that there are (OMG DDS-RTPS 2.5, 9.4.5.1.1).
SUBMESSAGES = [0x01, 0x06, 0x07, 0x08, 0x09, 0x0C, 0x0D, 0x0E, 0x0F, 0x12, 0x13, 0x15, 0x16]


class Node:
    """A node of a participant of its own."""

    def __init__(self, name):
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node(name, context=self.context)
        self.executor = rclpy.executors.SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def until(self, is_so, what, seconds=30.0):
        end = time.monotonic() + seconds
        while not is_so():
            has(time.monotonic() < end, f"{what} does not come")
            self.executor.spin_once(timeout_sec=0.02)

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.02)

    def ask(self, client, request, what):
        self.until(lambda: client.wait_for_service(timeout_sec=0.1), f"service {what}")
        answered = client.call_async(request)
        self.until(answered.done, f"an answer of {what}")
        return answered.result()

    def end(self):
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


def goal(arms, column, seconds):
    """One point: the columns of arms turned to a place."""
    names = [f"{arm}/{name}" for arm in arms for name in NAMES] if len(arms) > 1 else NAMES
    point = JointTrajectoryPoint(positions=len(arms) * [column, *HOME[1:]], time_from_start=Duration(sec=seconds))
    return Follow.Goal(trajectory=JointTrajectory(joint_names=names, points=[point]))


def serves(name, bridge, state="running"):
    """A new participant finds the bridge, hears the arm, and is answered; the cell does what it did."""
    has(bridge.poll() is None, f"the bridge has ended: {bridge.poll()}")
    node, states, said = Node(name), [], []
    node.node.create_subscription(JointState, "/left/joint_states", states.append, 100)
    node.node.create_subscription(String, "/cell/state", lambda message: said.append(message.data), 10)
    node.until(lambda: len(states) > 100, "a hundred joint states")
    # Refused, and answered: the cell runs.
    answer = node.ask(node.node.create_client(Trigger, "/cell/reset"), Trigger.Request(), "reset")
    has(not answer.success, f"a reset of a cell that runs: {answer}")
    node.end()
    has(not said or said[-1] == state, f"the cell is {said}")


def memory(process):
    """Resident memory of a process [MB]; of one that has ended, 0."""
    found = re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{process.pid}/status").read_text())
    return int(found[1]) / 1024 if found else 0.0


def two_bridges(node, both, folder):
    """A second one that would send goals ends; one that only shows the cell is another node."""
    at_work = node.send(both, goal(["left", "right"], 0.2, 4))
    began = time.monotonic()
    second = subprocess.run([EXAMPLES / "goals_bridge", "--cell", GOALS, "--goals", "--node", "second"], capture_output=True, text=True, timeout=30)
    told = "another program of this machine sends what the sensor reads"
    has(second.returncode == 2 and told in second.stderr, f"a second bridge with goals: {second.returncode}, {second.stderr}")
    print(f"  a second bridge with goals ends with status 2 after {time.monotonic() - began:.1f} s")
    other = subprocess.Popen([EXAMPLES / "goals_bridge", "--cell", GOALS, "--node", "second"], stderr=subprocess.PIPE, text=True)
    has("node /second" in other.stderr.readline(), "a second bridge that only shows does not begin")
    states = []
    node.node.create_subscription(String, "/second/state", states.append, 10)
    node.until(lambda: states, "the state of the second bridge")
    node.succeeds(at_work, "a goal at work meanwhile")
    other.send_signal(signal.SIGKILL)
    other.wait()


class Goals(Node):
    """A node that sends goals."""

    def send(self, client, what):
        self.until(lambda: client.wait_for_server(timeout_sec=0.1), "the action")
        sent = client.send_goal_async(what)
        self.until(sent.done, "an answer to a goal")
        has(sent.result().accepted, "a goal is not accepted")
        return sent.result()

    def succeeds(self, handle, what):
        got = handle.get_result_async()
        self.until(got.done, f"the result of {what}")
        result = got.result()
        has(result.status == GoalStatus.STATUS_SUCCEEDED, f"{what}: status {result.status}, {result.result.error_string}")
        print(f"  {what} succeeds")


def flood_of_goals(node, both, left, bridge):
    """Goals for one arm of two that move as one, for as long as these move."""
    at_work = node.send(both, goal(["left", "right"], 0.0, 5))
    sent, asks = [], []
    end = time.monotonic() + 3.0
    while time.monotonic() < end:
        sent += [left.send_goal_async(goal(["left"], 0.1, 2)) for _ in range(10)]
        node.spin(0.01)
        for handle in (one.result() for one in sent if one.done()):
            if handle.accepted and len(asks) < 200:
                asks.append(handle.get_result_async())
    node.succeeds(at_work, "a goal at work meanwhile")
    answered = [one.result() for one in sent if one.done()]
    accepted = [handle for handle in answered if handle.accepted]
    codes = {ask.result().status for ask in asks if ask.done()}
    print(f"  {len(sent)} goals in 3 s: {len(answered)} answered, {len(accepted)} of them looked at, and refused; the bridge has {memory(bridge):.0f} MB")
    has(len(answered) > 100, f"the bridge answers {len(answered)} goals")
    has(codes <= {GoalStatus.STATUS_ABORTED}, f"goals for one arm of two: statuses {codes}")


def sockets_of(process):
    """The ports of UDP that a process hears."""
    links = (os.readlink(fd) for fd in Path(f"/proc/{process.pid}/fd").iterdir())
    inodes = {link[8:-1] for link in links if link.startswith("socket:[")}
    rows = [line.split() for line in Path("/proc/net/udp").read_text().splitlines()[1:]]
    return sorted({int(row[1].split(":")[1], 16) for row in rows if row[9] in inodes})


def overheard(seconds):
    """Packets of DDS on loopback, as far as this user may look at them."""
    try:
        raw = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x0800))
    except PermissionError:
        print("  not tested with changed packets of other participants: this user may not look at them")
        return []
    raw.bind(("lo", 0))
    raw.settimeout(0.1)
    found, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            packet = raw.recv(65_536)
        except TimeoutError:
            continue
        # Ethernet, IP without options, UDP.
        if packet[23] == 17 and packet[42:46] == b"RTPS":
            found.append(packet[42:])
    raw.close()
    return found


def damaged(chance):
    """A packet that is none, or one with a wrong submessage."""
    kind = chance.randrange(3)
    if kind == 0:
        return chance.randbytes(chance.randrange(1400))
    head = b"RTPS\x02\x04\x01\x0f" + chance.randbytes(12)
    if kind == 1:
        return head + chance.randbytes(chance.randrange(400))
    body = chance.randbytes(4 * chance.randrange(100))
    said = len(body) if chance.random() < 0.7 else chance.randrange(65_536)
    flags = chance.randrange(256) | 1
    return head + bytes([chance.choice(SUBMESSAGES), flags]) + said.to_bytes(2, "little") + body


def forged(chance, genuine):
    """A packet of another participant with other bytes."""
    packet = bytearray(chance.choice(genuine))
    for _ in range(chance.randrange(1, 8)):
        packet[chance.randrange(8, len(packet))] = chance.randrange(256)
    return bytes(packet)[: chance.randrange(20, len(packet) + 1)] if chance.random() < 0.2 else bytes(packet)


def packets(bridge, count, make, what):
    """Sends packets to all sockets of the bridge."""
    ports = sockets_of(bridge)
    has(len(ports) >= 4, f"the bridge hears the ports {ports}")
    chance, out = random.Random(SEED), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for k in range(count):
        out.sendto(make(chance), ("127.0.0.1", ports[k % len(ports)]))
        if k % 50 == 0:
            time.sleep(0.002)
    out.close()
    print(f"  {count} packets at {len(ports)} sockets, {what}")


def forgery(bridge, cell):
    """Packets of other participants with other bytes: what the bridge believes of these may silence or end it. It takes no more memory than it may, and the cell goes
    on, or stops its arms as for a killed bridge. How it went."""
    listener = Node("overheard")
    listener.node.create_subscription(JointState, "/left/joint_states", lambda _: None, 10)
    listener.spin(1.0)
    genuine = overheard(1.0)
    listener.end()
    if not genuine:
        return "not tried"
    packets(bridge, 6000, lambda chance: forged(chance, genuine), f"changed from {len(genuine)} genuine ones")
    most, end = 0.0, time.monotonic() + 30
    while bridge.poll() is None and time.monotonic() < end:
        most = max(most, memory(bridge))
        time.sleep(0.05)
    has(most < 2200, f"the bridge has taken {most:.0f} MB")
    # A stale sensor stops the arms.
    time.sleep(2.0)
    has(cell.poll() is None, "the cell ended")
    how = "still there" if bridge.poll() is None else "ended"
    print(f"    after half a minute the bridge is {how}; it has taken {most:.0f} MB at most")
    return how


def other_types(node, bridge):
    """Services by the bridge's names with other types, and requests that are none."""
    client = node.node.create_client(SetBool, "/cell/suspend")
    has(not client.wait_for_service(timeout_sec=2.0), "a service of another type is served")
    wrong = subprocess.run([sys.executable, __file__, "--requests"], capture_output=True, text=True, timeout=60)
    has(wrong.returncode == 0, wrong.stderr[-500:])
    print(f"  a service of another type is not served; {wrong.stdout.strip()}; the bridge has {memory(bridge):.0f} MB")


def requests():
    """Requests for goals with bytes that are none, by Cyclone DDS."""
    from dataclasses import dataclass

    from cyclonedds.core import Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.idl import IdlStruct
    from cyclonedds.idl.types import array, uint8
    from cyclonedds.pub import DataWriter
    from cyclonedds.topic import Topic
    from cyclonedds.util import duration

    @dataclass
    class Request(IdlStruct, typename="control_msgs::action::dds_::FollowJointTrajectory_SendGoal_Request_"):
        content: array[uint8, 256]

    participant = DomainParticipant(int(DOMAIN))
    qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(100))
    topic = Topic(participant, "rq/left/follow_joint_trajectory/_action/send_goalRequest", Request, qos=qos)
    writer = DataWriter(participant, topic, qos=qos)
    end = time.monotonic() + 20
    while not writer.get_matched_subscriptions() and time.monotonic() < end:
        time.sleep(0.05)
    heard = len(writer.get_matched_subscriptions())
    chance = random.Random(SEED)
    for k in range(500):
        content = bytearray(chance.randbytes(256))
        if k % 2 == 0:
            # Small numbers, some of them lengths that are not there.
            content = bytearray(256)
            place = 4 * chance.randrange(63)
            content[place : place + 4] = b"\xff\xff\xff\xff"
        writer.write(Request(list(content)))
        if k % 20 == 0:
            time.sleep(0.02)
    time.sleep(1.0)
    print(f"500 requests that are none are sent to {heard} of its readers", end="")
    sys.exit(0 if heard else "nobody hears the requests")


def test(folder):
    bridge = subprocess.Popen(
        [EXAMPLES / "goals_bridge", "--cell", GOALS, "--goals", "--buttons"], stderr=subprocess.PIPE, text=True, preexec_fn=interruptible
    )
    has("with goals" in bridge.stderr.readline(), "the bridge does not begin")
    options = ["--processes", "--no-picture", "--quiet", "--outcome", folder / "outcome.json"]
    cell = subprocess.Popen([EXAMPLES / "goals", "--cell", GOALS, *options], preexec_fn=interruptible)
    node = Goals("planner")
    both, left = (ActionClient(node.node, Follow, f"/{at}/follow_joint_trajectory") for at in ("cell", "left"))
    with ended_after(cell, bridge):
        node.spin(3.0)
        node.succeeds(node.send(both, goal(["left", "right"], 0.0, 2)), "both arms go home")
        two_bridges(node, both, folder)
        flood_of_goals(node, both, left, bridge)
        serves("after_the_flood", bridge)
        other_types(node, bridge)
        serves("after_other_types", bridge)
        node.end()
        packets(bridge, 6000, damaged, "damaged ones or none of DDS")
        serves("after_packets", bridge)
        node = Goals("again")
        both = ActionClient(node.node, Follow, "/cell/follow_joint_trajectory")
        node.succeeds(node.send(both, goal(["left", "right"], 0.1, 2)), "a goal of a new node after all that")
        node.end()
        how = forgery(bridge, cell)
    outcome = Outcome(folder / "outcome.json")
    # By whom it was stopped, if the bridge has ended.
    expected = "SensorStale" if how == "ended" else "Aborted"
    has(outcome.kind == expected, f"the cell ended by {outcome}")


def flood_of_messages(folder):
    """A topic that is a sensor is flooded by the publisher that counts, and by one of another type."""
    node, other, states = Node("stick"), Node("foreign"), []
    node.node.create_subscription(String, "/cell/state", lambda message: states.append(message.data), 10)
    publisher = node.node.create_publisher(TwistStamped, "/servo/twist", 10)
    foreign = other.node.create_publisher(String, "/servo/twist", 10)
    bridge = subprocess.Popen([EXAMPLES / "servo_bridge", "--cell", SERVO], stderr=subprocess.DEVNULL, preexec_fn=interruptible)
    options = ["--processes", "--no-picture", "--quiet", "--outcome", folder / "outcome.json"]
    cell = subprocess.Popen([EXAMPLES / "servo", "--cell", SERVO, *options], preexec_fn=interruptible)
    message = TwistStamped()

    def publish(seconds, burst):
        """So many messages at a time, as often as a subscriber is served in between; without a number as fast as may be."""
        count, end = 0, time.monotonic() + seconds
        while time.monotonic() < end:
            for _ in range(burst or 100):
                message.header.stamp = node.node.get_clock().now().to_msg()
                publisher.publish(message)
                count += 1
            if burst:
                node.spin(0.01)
            else:
                foreign.publish(String(data=100_000 * "x"))
        return count

    with ended_after(cell, bridge):
        end = time.monotonic() + 60
        while states[-1:] != ["running"]:
            has(time.monotonic() < end, f"the cell does not begin, states {states}")
            publish(0.1, 1)
        publish(1.0, 1)
        count = publish(3.0, 20)
        publish(1.0, 1)
        print(f"  {count} messages in 3 s: the cell is {states[-1]}, the bridge has {memory(bridge):.0f} MB")
        has(states[-1] == "running", f"the cell is {states}")
        count = publish(3.0, None)
        publish(2.0, 1)
        most = memory(bridge)
        print(f"  {count} messages in 3 s, and a hundredth as many of another type of 100 kB: the cell is {states[-1]}, the bridge has {most:.0f} MB")
        has(bridge.poll() is None and most < 2200, f"the bridge: {bridge.poll()}, {most} MB")
        node.end()
        other.end()
    outcome = Outcome(folder / "outcome.json")
    # Where the bridge does not get through them, what it reads is too old.
    is_stale = outcome.kind == "SensorStale" and "stick" in outcome.text
    has(outcome.kind == "Aborted" or is_stale, f"the cell ended by {outcome}")


if __name__ == "__main__":
    if "--requests" in sys.argv:
        requests()
    run("a bridge to which others do what they should not", test)
    run("a topic that is a sensor is flooded", flood_of_messages)

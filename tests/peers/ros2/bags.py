"""Bags: a recording that tools of ROS 2 read, a bag that others made, which two arms follow, and one whose topic is a sensor.

In: the examples `arms`, `goals` and `servo` with their bridges, built. Out: exit status 0 if rosbags and mcap-ros2, two implementations of others, read a
recording whole and to the bit, the arms go through the points of a bag that rosbags has written, and an arm reads its twists in their order at their times.
"""

import json
import struct
import subprocess
import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cell_outcome import Outcome  # noqa: E402
from ending import interruptible  # noqa: E402
from tried import EXAMPLES, ended_after, has, listen_in, run  # noqa: E402

listen_in("90")

import numpy as np  # noqa: E402
from mcap.reader import make_reader  # noqa: E402
from mcap_ros2.decoder import DecoderFactory  # noqa: E402
from rosbags.interfaces import QosDurability  # noqa: E402
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer  # noqa: E402
from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: E402

ARMS = Path("ports/panel/examples/cell.toml").resolve()
GOALS = Path("ports/ros2/examples/goals.toml").resolve()
SERVO = Path("ports/ros2/examples/servo.toml").resolve()
STEP = 2_000_000  # [ns]
JOINTS = ["column", "lower_arm", "upper_arm", "wrist_t", "wrist_v", "flange_n"]
HOME = np.array([0.0, -1.57, 0.16, -0.16, 4.71, 0.0])
TURN = np.array([0.3, 0.1, -0.05, 0.1, -0.3, 0.2])
STORE = get_typestore(Stores.ROS2_JAZZY)


def bits(numbers):
    return struct.pack(f"{len(numbers)}d", *numbers)


def recorded(file):
    """What a cell recorded: the date of its time 0, images and signals of its robots, readings of a wrist, and the dates of these messages."""
    images, signals, readings = {"left": [], "right": []}, [], []
    with open(file, "rb") as stream:
        reader = make_reader(stream)
        for _, channel, message in reader.iter_messages():
            name = channel.topic.removeprefix("/robots/")
            if name in images:
                images[name].append((message.log_time, json.loads(message.data)))
            elif name == "left/signals":
                signals.append((message.log_time, json.loads(message.data)))
            elif name == "/sensors/wrist":
                readings.append((message.log_time, json.loads(message.data)))
        start = next(int(about.metadata["start_ns"]) for about in reader.iter_metadata() if about.name == "mrroc.start")
    return start, images, signals, readings


def by_rosbags(bag):
    """Each message of a bag by its topic, with its date; and the topics."""
    told, topics = {}, {}
    with Reader(bag) as reader:
        for connection in reader.connections:
            topics[connection.topic] = connection
            # Our definitions are those of Jazzy that rosbags itself has.
            for name, (_, fields) in get_types_from_msg(connection.msgdef.data, connection.msgtype).items():
                has(fields == STORE.fielddefs[name][1], f"{name} is defined as {fields}")
        for connection, date, data in reader.messages():
            told.setdefault(connection.topic, []).append((date, STORE.deserialize_cdr(data, connection.msgtype)))
        has(sum(map(len, told.values())) == reader.message_count, "rosbags reads fewer messages than the metadata says")
    for topic, connection in topics.items():
        has(len(told.get(topic, [])) == connection.msgcount, f"{topic} has another number of messages")
    return told, topics


def exports(folder):
    """A recording, whose bag both others read to the bit."""
    file, bag = folder / "run.mcap", folder / "bag"
    subprocess.run([EXAMPLES / "arms", "--cell", ARMS, "--quiet", "--no-picture", "--record", file, "--", "--turns", "2"], check=True)
    export = [EXAMPLES / "bridge", "--cell", ARMS, "--export-bag", bag, file]
    wrote = subprocess.run(export, capture_output=True, text=True)
    has(wrote.returncode == 0 and "wrote" in wrote.stderr, wrote.stderr)
    again = subprocess.run(export, capture_output=True, text=True)
    has(again.returncode == 2 and "is there already" in again.stderr, f"a bag is written over: {again.stderr}")
    start, images, signals, readings = recorded(file)
    told, topics = by_rosbags(bag)
    for robot, steps in images.items():
        for of, topic in (("measured", f"/{robot}/joint_states"), ("demanded", f"/{robot}/demanded_joint_states")):
            found = told[topic]
            has(len(found) == len(steps), f"{topic}: {len(found)} messages of {len(steps)} steps")
            for (date, message), (logged, image) in zip(found, steps):
                stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
                has(date == logged and stamp == start + image["step"] * STEP, f"{topic}: step {image['step']} is at {stamp}, {date}")
                has(list(message.name) == JOINTS, f"{topic}: {message.name}")
                same = bits(message.position) == bits(image[of]["joints"]) and bits(message.velocity) == bits(image[of]["velocity"])
                has(same, f"{topic}: step {image['step']} differs from the recording")
    for (date, message), (logged, said) in zip(told["/sensors/wrist"], readings, strict=True):
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        has(date == logged and stamp == start + said["taken"] * STEP, f"a reading of step {said['taken']} is at {stamp}, {date}")
        has(message.header.frame_id == "left/tool", f"a wrench in frame {message.header.frame_id}")
        for found, of in ((message.wrench.force, "force"), (message.wrench.torque, "torque")):
            has(bits((found.x, found.y, found.z)) == bits(said["reading"][of]), f"the {of} of step {said['taken']} differs")
    switched = []
    for logged, said in signals:
        if not switched or switched[-1][1] != said["outputs"]["gripper"]:
            switched.append((logged, said["outputs"]["gripper"]))
    has([(date, message.data) for date, message in told["/left/outputs/gripper"]] == switched, "the gripper's output differs")
    every = told["/joint_states"]
    has(len(every) > 100 and list(every[0][1].name) == [f"{every[0][1].name[0].split('_')[0]}_{name}" for name in JOINTS], f"/joint_states: {every[0][1].name}")
    has(told["/cell/state"][0][1].data in ("idle", "running"), f"/cell/state: {told['/cell/state'][0]}")
    frames = {one.child_frame_id for topic in ("/tf", "/tf_static") for _, message in told[topic] for one in message.transforms}
    has({"table", "left/world", "left/tool", "right/flange"} <= frames, f"frames: {frames}")
    for topic in ("/left/robot_description", "/tf_static", "/left/outputs/gripper"):
        has(topics[topic].ext.offered_qos_profiles[0].durability == QosDurability.TRANSIENT_LOCAL, f"{topic} is not kept")
    count = 0
    with open(next(bag.glob("*.mcap")), "rb") as stream:
        for _, channel, _, message in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            count += 1
            if channel.topic.endswith("joint_states"):
                _, other = told[channel.topic].pop(0)
                has(bits(message.position) == bits(other.position) and list(message.name) == list(other.name), f"{channel.topic} is read otherwise")
    print(f"  rosbags reads {len(topics)} topics of a recording, mcap-ros2 the same {count} messages; {sum(map(len, images.values()))} steps and {len(readings)} wrenches are the recorded ones to the bit")
    has(len(readings) == 200, f"{len(readings)} readings, not 100 at each of two turns")
    has(not any(left for topic, left in told.items() if topic.endswith("joint_states")), "mcap-ros2 reads fewer messages")


def swing(start, by, seconds):
    """Through points of a motion from rest to rest, of degree 5; the first one a time away."""
    s = np.linspace(0, 1, 9)
    place, speed, change = 10 * s**3 - 15 * s**4 + 6 * s**5, 30 * s**2 - 60 * s**3 + 30 * s**4, 60 * s - 180 * s**2 + 120 * s**3
    return 0.5 + seconds * s, start + np.outer(place, by), np.outer(speed, by) / seconds, np.outer(change, by) / seconds**2


def message(names, times, q, v=None, a=None):
    types = STORE.types
    empty = np.array([])

    def point(k):
        at = types["builtin_interfaces/msg/Duration"](sec=int(times[k]), nanosec=int(round((times[k] % 1) * 1e9)))
        told = [empty if of is None else np.asarray(of[k], dtype=np.float64) for of in (q, v, a)]
        return types["trajectory_msgs/msg/JointTrajectoryPoint"](*told, effort=empty, time_from_start=at)

    # A stamp of long ago: a bag's trajectory begins when it is sent.
    header = types["std_msgs/msg/Header"](stamp=types["builtin_interfaces/msg/Time"](sec=1000, nanosec=0), frame_id="")
    return types["trajectory_msgs/msg/JointTrajectory"](header=header, joint_names=names, points=[point(k) for k in range(len(times))])


def made(bag, messages, plugin=StoragePlugin.MCAP, mode=CompressionMode.NONE):
    writer = Writer(bag, version=9, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    kind = "trajectory_msgs/msg/JointTrajectory"
    with writer:
        connection = writer.add_connection("/plan", kind, typestore=STORE)
        for k, one in enumerate(messages):
            writer.write(connection, 10**18 + k, STORE.serialize_cdr(one, kind))
    return bag


def refusals(folder, messages):
    """Bags that are not read, by what to do; no node begins."""
    cut = folder / "cut.mcap"
    cut.write_bytes(next(made(folder / "whole", messages).glob("*.mcap")).read_bytes()[:-500])
    cases = [
        (made(folder / "sqlite", messages, StoragePlugin.SQLITE3), "sqlite3 storage"),
        (made(folder / "one", messages, mode=CompressionMode.MESSAGE), "compressed by zstd"),
        (made(folder / "file", messages, mode=CompressionMode.FILE), "compressed as a whole file"),
        (cut, "cut.mcap: is"),
        (folder / "nothing", "No such file"),
    ]
    for bag, text in cases:
        refused = subprocess.run([EXAMPLES / "goals_bridge", "--cell", GOALS, "--from-bag", bag], capture_output=True, text=True, timeout=60)
        print(f"  refused: {refused.stderr.splitlines()[0].replace(str(folder), '')}")
        has(refused.returncode == 2 and text in refused.stderr and bag.name in refused.stderr, f"{bag.name}: {refused.stderr}")


def follows(folder):
    """Two arms go through the points of a bag of rosbags, and once more through those of a bag of that run."""
    both = [f"{arm}/{name}" for arm in ("left", "right") for name in JOINTS]
    times, q, v, a = swing(HOME, TURN, 2.0)
    back = swing(np.concatenate([HOME + TURN, HOME]), np.concatenate([-TURN, TURN]), 4.0)
    messages = [message([f"left_{name}" for name in JOINTS], times, q, v, a), message(both, *back[:3])]
    refusals(folder, messages)
    bag = made(folder / "plan", messages, mode=CompressionMode.STORAGE)
    told = session(folder, "first.mcap", 2, "--from-bag", bag)
    through(told, ["left"], times, q)
    through(told, ["left", "right"], *back[:2])

    own = folder / "own"
    wrote = subprocess.run([EXAMPLES / "goals_bridge", "--cell", GOALS, "--export-bag", own, folder / "first.mcap"], capture_output=True, text=True)
    has(wrote.returncode == 0, wrote.stderr)
    states = {}
    for _, state in by_rosbags(own)[0]["/joint_states"]:
        stamp = state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
        states.setdefault(stamp, {}).update(zip(state.name, state.position))
    # Each arm begins and ends by itself.
    stamps = sorted(stamp for stamp, joints in states.items() if len(joints) == 12)
    where = np.array([[states[stamp][f"{arm}_{name}"] for arm in ("left", "right") for name in JOINTS] for stamp in stamps])
    told = session(folder, "second.mcap", 1, "--from-bag", own, "--topic", "/joint_states", "--approach", "2")
    through(told, ["left", "right"], 2.0 + (np.array(stamps) - stamps[0]) * 1e-9, where)


def session(folder, name, count, *options):
    """A run of the cell in which its bridge takes a bag; what the arms were told in it."""
    outcome = folder / "outcome.json"
    recording = ["--processes", "--no-picture", "--quiet", "--record", folder / name, "--outcome", outcome]
    cell = subprocess.Popen([EXAMPLES / "goals", "--cell", GOALS, *recording], preexec_fn=interruptible)
    bridge = subprocess.Popen([EXAMPLES / "goals_bridge", "--cell", GOALS, *options], stderr=subprocess.PIPE, text=True, preexec_fn=interruptible)
    limit = threading.Timer(90, bridge.kill)
    limit.daemon = True
    limit.start()
    said = []
    with ended_after(cell, bridge):
        for line in bridge.stderr:
            said.append(line.strip())
            if line.startswith("bag:") and ("done" not in line or f"{count} of {count}" in line):
                break
    limit.cancel()
    bridge.wait()
    print(f"  {said[-1]}; {Outcome(outcome)}")
    has(said[1:] == [f"bag: trajectory {k} of {count}: done" for k in range(1, count + 1)], f"the bridge says {said}")
    return ordered(folder / name)


def through(told, arms, when, where):
    """The demands go through these points at these times."""
    at, orders = told
    demands = np.array([np.concatenate([order[arm] for arm in arms]) for order in orders])
    passed = lambda begins: np.array([np.interp(begins + when, at, joint) for joint in demands.T]).T  # noqa: E731
    closest = min(np.abs(passed(begins) - where).max() for begins in at if begins + when[-1] <= at[-1])
    print(f"  the demands go through {len(when)} points of the bag at their times, within {closest:.1e} rad")
    # The points are at steps, unless a machine that is late made a step shorter: between two demands that is the chord of a path of at most 7 rad/s^2.
    has(closest < 7.0 * (STEP * 1e-9) ** 2 / 8, f"a point of the bag is {closest} rad off")


def ordered(file):
    """The path time [s] that had passed by each step, and what both arms were told in it."""
    orders, path_time = {}, {}
    with open(file, "rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            said = json.loads(message.data)
            if channel.topic == "/steps":
                path_time[said["step"]] = said["dt"]
            for arm in ("left", "right"):
                if channel.topic == f"/robots/{arm}/orders/Demand":
                    orders.setdefault(said["step"], {})[arm] = np.array(said["order"]["joints"][:6])
    whole = [step for step in sorted(orders) if len(orders[step]) == 2 and step in path_time]
    return np.cumsum([path_time[step] for step in whole]), [orders[step] for step in whole]


def twists(bag, kind="geometry_msgs/msg/TwistStamped"):
    """A bag of rosbags with twists at times that are not even, each of them another one; their dates and stamps after the bag's first message [ns]."""
    types = STORE.types
    vector = types["geometry_msgs/msg/Vector3"]
    dates = [100_000_000 + 20_000_000 * k + 7_000_000 * (k % 3) for k in range(200)]
    # Measured some time before, which differs by several steps.
    stamps = [date - 1_000_000 - 4_000_000 * (k % 4) for k, date in enumerate(dates)]
    told = [(0.03 * np.sin(np.pi * k / 50) + 1e-9 * k, 1e-3 * np.sin(k)) for k in range(len(dates))]
    begin = 10**18
    writer = Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        text = writer.add_connection("/said", "std_msgs/msg/String", typestore=STORE)
        writer.write(text, begin, STORE.serialize_cdr(types["std_msgs/msg/String"](data="first"), "std_msgs/msg/String"))
        connection = writer.add_connection("/servo/twist", kind, typestore=STORE)
        for date, stamp, (z, x) in zip(dates, stamps, told):
            twist = types["geometry_msgs/msg/Twist"](linear=vector(x=0.0, y=0.0, z=z), angular=vector(x=x, y=0.0, z=0.0))
            if kind.endswith("Stamped"):
                at = types["builtin_interfaces/msg/Time"](sec=(begin + stamp) // 10**9, nanosec=(begin + stamp) % 10**9)
                twist = types[kind](header=types["std_msgs/msg/Header"](stamp=at, frame_id="tool"), twist=twist)
            writer.write(connection, begin + date, STORE.serialize_cdr(twist, kind))
    return dates, stamps, told


def checked(*options):
    return subprocess.run([EXAMPLES / "servo_bridge", "--check", *options], capture_output=True, text=True, timeout=60)


def is_heard(folder):
    """The topic of a sensor is that of a bag: each reading is a message of it, at its time, and when the bag is done the sensor is stale."""
    bag, plain = folder / "twists", folder / "plain"
    dates, stamps, told = twists(bag)
    twists(plain, "geometry_msgs/msg/Twist")
    wrong = checked("--cell", SERVO, "--sensors-from-bag", plain, "--node", "a-b")
    unlike = "topic /servo/twist is of type geometry_msgs/msg/Twist, and sensor `stick` reads geometry_msgs/msg/TwistStamped"
    has(wrong.returncode == 2 and unlike in wrong.stderr and "node `a-b`" in wrong.stderr, f"a bag with another type: {wrong}")
    right = checked("--cell", SERVO, "--sensors-from-bag", bag)
    has(right.returncode == 0 and f"{len(told)} messages of the bag" in right.stdout, f"a check: {right}")
    # Ended by its fault, and not kept for a reset.
    cell_file, outcome = folder / "servo.toml", folder / "outcome.json"
    cell_file.write_text(SERVO.read_text().replace('after_fault = "await reset"\n', ""))
    options = ["--processes", "--no-picture", "--quiet", "--record", folder / "heard.mcap", "--outcome", outcome]
    bridge = subprocess.Popen([EXAMPLES / "servo_bridge", "--cell", cell_file, "--sensors-from-bag", bag], preexec_fn=interruptible)
    try:
        subprocess.run([EXAMPLES / "servo", "--cell", cell_file, *options], timeout=90, preexec_fn=interruptible)
        has(bridge.poll() is None, "the bridge has ended with the cell")
    finally:
        bridge.kill()
        bridge.wait()
    ended = Outcome(outcome)
    print(f"  {ended}")
    has(ended.kind == "SensorStale" and "ms, at most 600 ms" in ended.text, f"the cell ended by {ended}")
    steps, readings = [], []
    with open(folder / "heard.mcap", "rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            said = json.loads(message.data)
            if channel.topic == "/steps":
                steps.append(said["step"])
            elif channel.topic == "/sensors/stick" and said.get("reading"):
                of = (said["reading"]["linear"][2], said["reading"]["angular"][0])
                if not readings or readings[-1][0] != of:
                    readings.append((of, said["taken"]))
    place = {bits(twist): k for k, twist in enumerate(told)}
    strange = [of for of, _ in readings if bits(of) not in place]
    has(not strange, f"{len(strange)} readings are no messages of the bag: {strange[:3]}")
    heard = [(place[bits(of)], taken) for of, taken in readings]
    has([k for k, _ in heard] == sorted({k for k, _ in heard}), "readings are not in the order of the bag")
    # One that a late machine passes over is replaced by a newer one. The last one ends by the sensor's age.
    has(len(heard) > len(told) / 2 and heard[-1][0] == len(told) - 1, f"{len(heard)} of {len(told)} messages are readings, the last one is {heard[-1]}")
    # When each was measured, by the step of which it is, also one that was left out: to whole steps, of which processes begin as late as their longest stall.
    late = [(taken - min(steps)) * STEP - stamps[k] for k, taken in heard]
    spread, allowed = max(late) - min(late), 2 * STEP + ended.longest_stall * 1e9
    print(f"  {len(heard)} of {len(told)} messages of a bag are readings to the bit; their times are those of the bag within {spread / 1e6:.1f} ms, from {min(late) / 1e6:.1f} ms on")
    has(spread <= allowed, f"their times differ by {spread / 1e6} ms from those of the bag, {allowed / 1e6} ms are allowed")
    has(min(late) >= -2 * STEP, "a message came before its time")


run("tools of others read a recording as a bag", exports)
run("two arms follow a bag of rosbags", follows)
run("an arm follows twists of a bag in the place of a topic", is_heard)

"""A bag of a recording, read by Rerun, and by rosx_introspection, which is the parser of PlotJuggler.

In: the examples `arms` and `bridge`, built; a Python with rerun-sdk[catalog], mcap-bag-parser and mcap. Out: exit status 0 if both give each joint of each step by its name, with
the recorded position and velocity to the bit [rad, rad/s], and each wrench [N, N m].
"""

import json
import os
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

os.environ["RERUN_ANALYTICS"] = "disabled"

import rerun  # noqa: E402
from mcap.reader import make_reader  # noqa: E402
from mcap_bag import ROSX_AVAILABLE, parse_mcap_file  # noqa: E402

EXAMPLES = Path("target/debug/examples").resolve()
CELL = Path("ports/panel/examples/cell.toml").resolve()
STEP = 2_000_000  # [ns]
JOINTS = ["column", "lower_arm", "upper_arm", "wrist_t", "wrist_v", "flange_n"]


def has(is_so, what):
    if not is_so:
        sys.exit(f"ros2: {what}")


def bits(numbers):
    return struct.pack(f"{len(numbers)}d", *numbers)


def recorded(file):
    """What a cell recorded of the left arm and its wrist: of each stamp [ns] positions and velocities, and forces and torques."""
    states, wrenches = {}, {}
    with open(file, "rb") as stream:
        reader = make_reader(stream)
        start = next(int(about.metadata["start_ns"]) for about in reader.iter_metadata() if about.name == "mrroc.start")
        for _, channel, message in reader.iter_messages(["/robots/left", "/sensors/wrist"]):
            said = json.loads(message.data)
            if channel.topic == "/robots/left":
                states[start + said["step"] * STEP] = [said["measured"][of] for of in ("joints", "velocity")]
            else:
                wrenches[start + said["taken"] * STEP] = [*said["reading"]["force"], *said["reading"]["torque"]]
    return states, wrenches


def by_rerun(folder, bag, states):
    """Rerun shows a line for each joint, by its name."""
    file = folder / "data" / "bag.rrd"
    file.parent.mkdir()
    rerun.init("mrroc", recording_id="bag")
    rerun.save(file)
    rerun.log_file_from_path(bag)
    rerun.disconnect()
    with rerun.server.Server(datasets={"bag": str(file.parent)}) as server:
        view = server.client().get_dataset("bag").filter_contents(["/left/joint_states/**"])
        table = view.reader(index="ros2_timestamp").to_pandas()
    same = 0
    for _, row in table.iterrows():
        # The index has the stamp; a row without positions is what Rerun knows of the channel.
        stamp = row["ros2_timestamp"].value
        for k, of in enumerate(("position", "velocity")):
            has(list(row[f"/left/joint_states/{of}:SeriesLines:names"]) == JOINTS, f"Rerun names the joints otherwise: {row}")
            numbers = row[f"/left/joint_states/{of}:Scalars:scalars"]
            has(bits(numbers) == bits(states[stamp][k]), f"Rerun reads {of} of {stamp} as {numbers}, not {states[stamp][k]}")
        same += 1
    has(same == len(states), f"Rerun reads {same} of {len(states)} joint states")
    print(f"  Rerun {rerun.__version__} reads {same} joint states by the joints' names, to the bit")


def stamp_of(row):
    return row["header.stamp.sec"] * 10**9 + row["header.stamp.nanosec"]


def by_rosx(bag, states, wrenches):
    """Tables with a column for each joint, by its name."""
    has(ROSX_AVAILABLE, "rosx_introspection is not there")
    tables = parse_mcap_file(str(bag), ["/left/joint_states", "/sensors/wrist"])
    told = tables["/left/joint_states"]
    has(len(told) == len(states), f"rosx_introspection reads {len(told)} of {len(states)} joint states")
    for row in told.to_dict("records"):
        stamp = stamp_of(row)
        expected = states[stamp]
        for k, of in enumerate(("position", "velocity")):
            numbers = [row[f"{of}.{joint}"] for joint in JOINTS]
            has(bits(numbers) == bits(expected[k]), f"rosx_introspection reads {of} of {stamp} as {numbers}, not {expected[k]}")
    wrist = tables["/sensors/wrist"]
    has(len(wrist) == len(wrenches), f"rosx_introspection reads {len(wrist)} of {len(wrenches)} wrenches")
    for row in wrist.to_dict("records"):
        stamp = stamp_of(row)
        expected = wrenches[stamp]
        numbers = [row[f"wrench.{of}.{axis}"] for of in ("force", "torque") for axis in "xyz"]
        has(bits(numbers) == bits(expected), f"rosx_introspection reads the wrench of {stamp} as {numbers}, not {expected}")
    print(f"  rosx_introspection, the parser of PlotJuggler, reads {len(told)} joint states by the joints' names and {len(wrist)} wrenches, to the bit")


def main(folder):
    print("ros2: a bag of a recording, read by Rerun and by the parser of PlotJuggler")
    file, bag = folder / "run.mcap", folder / "bag"
    subprocess.run([EXAMPLES / "arms", "--cell", CELL, "--quiet", "--no-picture", "--record", file, "--", "--turns", "2"], check=True)
    subprocess.run([EXAMPLES / "bridge", "--cell", CELL, "--export-bag", bag, file], check=True, capture_output=True)
    states, wrenches = recorded(file)
    bag = next(bag.glob("*.mcap"))
    by_rerun(folder, bag, states)
    by_rosx(bag, states, wrenches)


with tempfile.TemporaryDirectory() as own_folder:
    main(Path(own_folder))

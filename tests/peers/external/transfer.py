"""The two-arm transfer in MuJoCo, beside the same programs in the simulation of this project.

In: the example `transfer_mujoco` and the task `transfer`, built. Out: exit status 0 if the bar, held by friction alone, and both arms end within 1 mm of
where they end in our simulation and of where the bar's path leads; if two runs are equal to the bit; and if the wrists bear what
the bar and the hands weigh. With --long the second run is a whole one, and so is a third, whose program reads the wrists.
"""

import argparse
import json
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parent.parent))
from ending import end, interruptible  # noqa: E402
from cell_outcome import Shortfall, has  # noqa: E402
from sensor import nothing_left  # noqa: E402

ROOT = Path(__file__).resolve().parents[3]
EXAMPLES = ROOT / "tasks/transfer/examples"
PROGRAM = ROOT / "target/debug/examples/transfer_mujoco"
TASK = ROOT / "target/debug/transfer"
CELL = EXAMPLES / "mujoco.toml"
NEAR = 1e-3  # how far ends may be from one another [m], and a side of the bar's turn [rad]
GRASPED = 4300  # a period in which the hands hold the bar
G = 9.80665

# Of a row: demanded and simulated joints of each robot in order, the arms' wrenches, the bar, both tools, the gap of RNT's loop.
JOINTS = {"rnt": 6, "polycrank": 7, "rnt-hand": 1, "polycrank-hand": 1}
WRENCHES = slice(2 * sum(JOINTS.values()), 2 * sum(JOINTS.values()) + 12)
BAR = slice(WRENCHES.stop, WRENCHES.stop + 7)
TOOLS = {"rnt": slice(BAR.stop, BAR.stop + 3), "polycrank": slice(BAR.stop + 3, BAR.stop + 6)}
ROW = 8 + 8 * (BAR.stop + 7)

sys.path.insert(0, str(EXAMPLES))
import transfer_mujoco  # noqa: E402


def run(folder, name, sensors=False, periods=None):
    """The rows of a run in MuJoCo, `periods` of them if it is not to be a whole one."""
    log = folder / name
    env = {**os.environ, "MRROC_PORTS": str(folder / "ports")}
    command = [sys.executable, EXAMPLES / "transfer_mujoco.py", "--log", log]
    with subprocess.Popen(command, env=env, stdout=subprocess.PIPE, text=True, preexec_fn=interruptible) as simulator:
        try:
            has(simulator.stdout.readline().startswith("port"), "the simulator does not begin")
            cell = [PROGRAM, "--cell", CELL, "--virtual", "--no-picture", "--quiet", *(["--", "--sensors"] if sensors else [])]
            running = subprocess.Popen(cell, env=env, cwd=folder, stderr=subprocess.PIPE, text=True)
            while periods and running.poll() is None and not (log.exists() and log.stat().st_size >= periods * ROW):
                time.sleep(0.05)
            if periods and running.poll() is None:
                running.send_signal(signal.SIGTERM)
            _, said = running.communicate(timeout=300)
            has(periods or running.returncode == 0, f"the cell ended with {running.returncode}: {said}")
        finally:
            end(simulator)
    raw = log.read_bytes()
    rows = [raw[i : i + ROW] for i in range(0, len(raw) - ROW + 1, ROW)][:periods]
    numbers = [struct.unpack("<Q", row[:8])[0] for row in rows]
    has(numbers == list(range(len(rows))), "a period is missing")
    return np.array([np.frombuffer(row[8:]) for row in rows])


def own(folder, sensors):
    """Where the tools and the bar end in our own simulation, which is the task itself, with its hands and its bar."""
    from mcap.reader import make_reader

    command = [TASK, "--no-error", *([] if sensors else ["--no-sensor"]), "--quiet", "--out", folder, "--record", folder / "own.mcap"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    has(done.returncode == 0, f"our own simulation ended with {done.returncode}: {done.stderr}")
    ends = {}
    with open(folder / "own.mcap", "rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            kind, _, name = channel.topic.removeprefix("/").partition("/")
            if kind in ("robots", "bodies") and (kind == "bodies" or name in JOINTS):
                said = json.loads(message.data)
                if "measured" in said or kind == "bodies":
                    ends[name] = said.get("measured", said)
    return ends


def place(pose):
    """Position and quaternion w, x, y, z."""
    at, turn = pose["position"], pose["orientation"]
    return np.array([at[axis] for axis in "xyz"]), np.array([turn[axis] for axis in "wxyz"])


def angle(p, q):
    """Between two orientations [rad]."""
    return 2.0 * np.arccos(min(1.0, abs(float(np.dot(p, q)))))


def test(rows, ends):
    bar = rows[-1][BAR]
    at, turn = place(ends["bar"]["pose"])
    leads = np.array([0.95, 0.10, 0.90])  # up, 0.25 m along y, turned by 20 degrees, and down: src/places.rs
    turned = np.array([np.cos(np.radians(10)), 0.0, 0.0, np.sin(np.radians(10))])
    apart, off = np.linalg.norm(bar[:3] - at), np.linalg.norm(bar[:3] - leads)
    has(max(apart, off) < NEAR, f"the bar ends {apart} m from where it ends in our simulation, {off} m from the end of its path")
    has(max(angle(bar[3:], turn), angle(bar[3:], turned)) < NEAR, f"the bar ends turned by {angle(bar[3:], turn)} rad from ours")
    lifted = rows[:, BAR][:, 2].max() - 0.9
    has(abs(lifted - 0.12) < NEAR, f"the bar was lifted by {lifted} m")
    arms = max(np.linalg.norm(rows[-1][of] - place(ends[name]["pose"])[0]) for name, of in TOOLS.items())
    has(arms < NEAR, f"a tool ends {arms} m from where it ends in our simulation")
    held = rows[GRASPED:][rows[GRASPED:, BAR][:, 2] > 0.91][:, WRENCHES]
    # The tools point down by 45 degrees along the bar: its axis and the vertical in their axes, of RNT's, and of Polycrank's mirrored.
    along, up = np.array([0.0, 1.0, 1.0]) / np.sqrt(2), np.array([0.0, 1.0, -1.0]) / np.sqrt(2)
    weight = -(held[:, 0:3] @ up + held[:, 6:9] @ up)
    hands = 2.0 * (transfer_mujoco.PALM + 0.4)  # a finger weighs 0.2 kg
    expected = (transfer_mujoco.MASS + hands) * G
    # Softly up and down, with at most 0.15 m/s².
    has(np.abs(weight / expected - 1.0).max() < 0.15 / G + 0.01, f"the wrists bear {weight.min()} to {weight.max()} N, not {expected} N")
    internal = np.abs(held[:, 0:3] @ along - held[:, 6:9] @ -along).max() / 2.0
    return apart, arms, internal, rows[:, -1].max()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--long", action="store_true")
    is_long = parser.parse_args().long
    with tempfile.TemporaryDirectory(prefix="mrx") as folder:
        folder = Path(folder)
        for sensors in (False, True) if is_long else (False,):
            began = time.monotonic()
            rows = run(folder, f"{sensors}.log", sensors)
            took = time.monotonic() - began
            apart, arms, internal, gap = test(rows, own(folder, sensors))
            again = run(folder, "again.log", sensors, None if is_long else GRASPED + 200)
            has(again.tobytes() == rows[: len(again)].tobytes(), "two runs differ")
            print(
                f"transfer: {'with sensors, ' if sensors else ''}{len(rows)} periods in {took:.1f} s, {len(again)} of them twice equal to the "
                f"bit; the bar ends {apart * 1e3:.3f} mm from where it ends in our own simulation, the tools {arms * 1e3:.3f} mm; at most {internal:.2f} N of stress, RNT's "
                f"loop open by {gap:.1e} m"
            )
        nothing_left(folder)


if __name__ == "__main__":
    try:
        main()
    except Shortfall as why:
        sys.exit(f"transfer: {why}")

"""Arms of a cell in MuJoCo: along straight lines in lock-step and in real time, with a simulator that is killed, hangs, or has a rival.

In: the example `plant`, built. Out: exit status 0 if the arms go in MuJoCo where the equations of their servos say, end where they
end in the simulation of this project, run the same twice to the bit, and stop within their bounds when the simulator is lost, longer by
the steps that the cell left out. Most is in lock-step, where nothing can be late. Of a cell in real time that a late machine ends it is
not tested how it ends.
"""

import json
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parent.parent))
from ending import end, interruptible  # noqa: E402
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402
from device_priority import urgent  # noqa: E402
from sensor import nothing_left  # noqa: E402

ROOT = Path(__file__).resolve().parents[3]
PLANT = ROOT / "target/debug/examples/plant"
EXAMPLES = ROOT / "ports/external/examples"
CELL = EXAMPLES / "plant.toml"
PERIOD = 0.002
JOINTS = 6
# Each joint's braking time from its limit of 3.14 rad/s at 10 rad/s² is 0.314 s; a drive fault is told in the next step.
BRAKING = 158
DELAY = 1
# What a joint may do [rad/s].
FASTEST = 3.14 + 1e-6

sys.path.insert(0, str(EXAMPLES))
import mujoco_arms  # noqa: E402


def env(folder):
    return {**os.environ, "PYTHONPATH": str(folder), "MRROC_PORTS": str(folder / "ports")}


def one_arm(folder):
    """The first arm of the example alone."""
    text = CELL.read_text().split("[robots.right]")[0].replace("../../../", f"{ROOT}/")
    (folder / "cell.toml").write_text(text)
    return folder / "cell.toml", ["left"]


def two_arms(_):
    return CELL, ["left", "right"]


def module(folder, cell):
    made = subprocess.run([PLANT, "--cell", cell, "external", "left"], capture_output=True, check=True)
    (folder / "arms_port.py").write_bytes(made.stdout)


def in_time():
    """For `preexec_fn` of a simulator that keeps real time."""
    interruptible()
    urgent()


class MuJoCo:
    """The simulator, in a process of its own."""

    def __init__(self, folder, cell, log="run.log", urgent=False):
        self.log = folder / log
        command = [sys.executable, EXAMPLES / "mujoco_arms.py", cell, "--log", self.log]
        self.process = subprocess.Popen(
            command, env=env(folder), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=in_time if urgent else interruptible
        )
        # It has the port when it says so.
        self.said = self.process.stdout.readline()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGCONT)
        end(self.process)

    def rows(self, arms):
        """For each arm its periods: the number, late answers, what was demanded, what was simulated, the wrench."""
        size = 16 + 8 * (2 * JOINTS + 6)
        raw = self.log.read_bytes()
        rows = [raw[i : i + size] for i in range(0, len(raw) - size + 1, size)]
        read = lambda row: (*struct.unpack("<QQ", row[:16]), np.frombuffer(row[16:]))
        return {arm: [read(row) for row in rows[i :: len(arms)]] for i, arm in enumerate(arms)}

    def wait_for(self, periods, arms, cell):
        """Until so many have been simulated, if the cell does not end before."""
        size = len(arms) * (16 + 8 * (2 * JOINTS + 6))
        while cell.poll() is None and not (self.log.exists() and self.log.stat().st_size >= periods * size):
            time.sleep(0.002)


def cell_of(folder, cell, *options, record="run.mcap"):
    command = [PLANT, "--cell", cell, "--no-picture", "--quiet", "--record", folder / record, "--outcome", folder / "outcome.json", *options]
    return subprocess.Popen(command, env=env(folder), cwd=folder, stderr=subprocess.PIPE, text=True)


def ended(running, folder):
    """How the cell ended, and its exit status with what it said."""
    _, said = running.communicate(timeout=120)
    return Outcome(folder / "outcome.json", said), (running.returncode, said)


def ended_well(running, folder):
    outcome, (status, said) = ended(running, folder)
    has(status == 0 and outcome.kind is None, f"the cell ended with {status}: {outcome}: {said}")


def recorded(folder, arms, record="run.mcap"):
    """Of each arm its demanded and measured joints, and the measured pose, step by step."""
    from mcap.reader import make_reader

    run = {arm: [] for arm in arms}
    with open(folder / record, "rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            arm = channel.topic.removeprefix("/robots/")
            if arm in run:
                said = json.loads(message.data)
                run[arm].append((said["step"], said["demanded"], said["measured"]))
    return run


def positions(pose):
    return np.array([pose["position"][axis] for axis in "xyz"])


def follow(demands, start):
    """Where the servos' equations say that the joints are at the end of each period: q'' = ω² e + 2 ω e', integrated as MuJoCo does."""
    h, omega = mujoco_arms.STEP, mujoco_arms.OMEGA
    q, v, at = np.array(start), np.zeros(len(start)), np.array(start)
    found = []
    for to in demands:
        speed = (to - at) / PERIOD
        for i in range(round(PERIOD / h)):
            v = v + h * (omega**2 * (at + speed * (i * h) - q) + 2 * omega * (speed - v))
            q = q + h * v
        at = to
        found.append(q)
    return np.array(found)


def error_bound(demands):
    """The largest error of such servos: each change of speed leaves errors that sum up to the response to a ramp."""
    ramp = np.arange(1, 200)[:, None] * PERIOD
    response = np.abs(ramp - follow(ramp, np.zeros(1))).sum()
    speeds = np.diff(demands, axis=0) / PERIOD
    return np.abs(np.diff(speeds, axis=0)).max() * response


def lock_step(folder, make):
    cell, arms = make(folder)
    module(folder, cell)
    starts = {arm: of["start"] for arm, of in tomllib.loads(cell.read_text())["robots"].items()}
    logs, demands = [], []
    for i in range(2):
        began = time.monotonic()
        with MuJoCo(folder, cell, f"{i}.log") as mujoco:
            ended_well(cell_of(folder, cell, "--virtual", record=f"{i}.mcap"), folder)
            took = time.monotonic() - began
        rows = mujoco.rows(arms)
        logs.append({arm: [row[2].tobytes() for row in of] for arm, of in rows.items()})
        demands.append(recorded(folder, arms, f"{i}.mcap"))
    has(logs[0] == logs[1] and demands[0] == demands[1], "two runs differ")
    worst, bounds, periods = 0.0, 0.0, 0
    for arm in arms:
        numbers = [row[0] for row in rows[arm]]
        has(numbers == list(range(len(numbers))), f"{arm}: a period is missing")
        demanded = np.array([row[2][:JOINTS] for row in rows[arm]])
        simulated = np.array([row[2][JOINTS : 2 * JOINTS] for row in rows[arm]])
        # Encoders of the stand-in say where it begins.
        start = demanded[0]
        has(np.abs(start - starts[arm]).max() < 1e-4, f"{arm} begins at {start}")
        off = np.abs(simulated - follow(demanded, start)).max()
        has(off < 1e-9, f"{arm}: MuJoCo is {off} rad from what the servos' equations say")
        error, bound = np.abs(simulated - demanded).max(), error_bound(demanded)
        has(error <= bound, f"{arm}: {error} rad from its demands, at most {bound} are allowed")
        worst, bounds, periods = max(worst, error), max(bounds, bound), len(numbers)
        wrench = rows[arm][-1][2][2 * JOINTS :]
        weight = mujoco_arms.TOOL_MASS * 9.81
        has(abs(np.linalg.norm(wrench[:3]) - weight) < 1e-3, f"{arm}: its tool pulls by {wrench}")
        lever = mujoco_arms.TOOL_CENTRE * np.cross([0, 0, 1], wrench[:3])
        has(np.abs(wrench[3:] - lever).max() < 1e-4, f"{arm}: its tool turns by {wrench}, not by {lever}")
    # Our own simulation, from the same file.
    ended_well(cell_of(folder, cell, "--simulated", record="own.mcap"), folder)
    own = recorded(folder, arms, "own.mcap")
    apart = 0.0
    for arm in arms:
        path = np.array([positions(measured["pose"]) for _, _, measured in demands[0][arm]])
        apart = max(apart, np.linalg.norm(path[-1] - positions(own[arm][-1][2]["pose"])))
        line = path[np.argmax(np.linalg.norm(path - path[0], axis=1))] - path[0]
        has(abs(np.linalg.norm(line) - 0.2) < 1e-3, f"{arm} went {np.linalg.norm(line)} m")
        aside = np.linalg.norm(np.cross(path - path[0], line / np.linalg.norm(line)), axis=1).max()
        has(aside < 1e-3, f"{arm} was {aside} m beside its line")
    has(apart < 1e-3, f"MuJoCo ends {apart} m from our own simulation")
    print(
        f"plant: {len(arms)} arm(s) in lock-step, {periods} periods twice equal to the bit in {took:.1f} s; error {worst:.2e} of {bounds:.2e} "
        f"rad; end {apart * 1e3:.3f} mm from our own simulation"
    )


def stands_after(run, arms, last, skipped):
    """The last demand that moved came within the bound after the last period that was simulated; robots go on as before for as many
    steps as the cell left out."""
    bound, latest = 1 + BRAKING + 2 * DELAY + 2 + skipped, 0
    for arm in arms:
        joints = [(step, demanded["joints"]) for step, demanded, _ in run[arm]]
        moved = max((after[0] for before, after in zip(joints, joints[1:]) if before[1] != after[1]), default=0)
        has(moved - last <= bound, f"{arm} moved for {moved - last} steps, at most {bound} are allowed")
        latest = max(latest, moved - last)
    return latest


def killed(folder, how, *options):
    """The simulator is killed, or stopped, in mid-motion."""
    cell, arms = two_arms(folder)
    module(folder, cell)
    in_real_time = "--virtual" not in options
    with MuJoCo(folder, cell, urgent=in_real_time) as mujoco:
        running = cell_of(folder, cell, *options)
        mujoco.wait_for(300, arms, running)
        mujoco.process.send_signal(how)
        outcome, (_, said) = ended(running, folder)
    # In real time the arms notice at the same time that it is late, and only one of them removes what it left.
    told = ["its simulator has ended: start it again"] if how == signal.SIGKILL else []
    told += ["its simulator answers too late for real time"] if in_real_time else []
    name = f"{how.name} {' '.join(options)}"
    if outcome.ended_by("RobotStopped"):
        has(any(words in said for words in told), f"{name}: the cell ended by {outcome}: {said}")
    else:
        has(in_real_time, f"{name}: the cell ended by {outcome}: {said}")
        not_tested("plant", f"how a cell ends whose simulator ends by {name}", outcome)
    last = max((row[0] for row in mujoco.rows(arms)["left"]), default=0)
    moved = stands_after(recorded(folder, arms), arms, last + (50 if in_real_time else 0), outcome.skipped)
    print(f"plant: {name}: the last demand that moved came {moved} steps after the loss was told")


def driver_killed(folder):
    """The EDP of one arm is killed in real time: the other one brakes in the simulator, which does not wait for the dead."""
    cell, arms = two_arms(folder)
    module(folder, cell)
    with MuJoCo(folder, cell, urgent=True) as mujoco:
        running = cell_of(folder, cell, "--processes")
        mujoco.wait_for(300, arms, running)
        for path in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = path.read_bytes().split(b"\0")
            except OSError:
                continue
            if words[1:3] == [b"edp", b"right"] and str(folder).encode() in b" ".join(words):
                os.kill(int(path.parent.name), signal.SIGKILL)
        outcome, (status, said) = ended(running, folder)
    has(status == 1, f"an EDP was killed: {status}: {said}")
    if not outcome.ended_by("PeerLost", controller=True):
        not_tested("plant", "what is told when an EDP is killed", outcome)
    rows = mujoco.rows(arms)["left"]
    demanded = np.array([row[2][:JOINTS] for row in rows])
    # An arm whose answers are late too often has no drive that could be told to brake.
    if outcome.kind != "RobotStopped":
        still = np.flatnonzero(np.abs(np.diff(demanded, axis=0)).max(axis=1))[-1]
        has(len(rows) - still > 2, "the arm that is left was still told to move")
    print(f"plant: an EDP was killed in real time: the other arm braked in MuJoCo; {outcome}")


def real_time(folder):
    cell, arms = two_arms(folder)
    module(folder, cell)
    with MuJoCo(folder, cell, urgent=True) as mujoco:
        outcome, _ = ended(cell_of(folder, cell, "--processes"), folder)
    is_whole = outcome.ended_well(controller=True)
    # What MuJoCo was told goes on from one period to the next as fast as joints may, over periods that were left out as well.
    for arm, rows in mujoco.rows(arms).items():
        for (before, _, one), (period, _, other) in zip(rows, rows[1:]):
            most = np.abs(other[:JOINTS] - one[:JOINTS]).max()
            has(most <= (period - before) * FASTEST * PERIOD, f"{arm} was told to go by {most} rad from period {before} to {period}")
    if is_whole:
        worst = max(np.abs(rows[-1][2][:JOINTS] - rows[-1][2][JOINTS : 2 * JOINTS]).max() for rows in mujoco.rows(arms).values())
        has(worst < 1e-3, f"an arm is {worst} rad from where it is to be at the end")
    else:
        not_tested("plant", "that arms draw their lines to the end", outcome)
    rows = mujoco.rows(arms)["left"]
    # The module counts what both arms found late.
    print(f"plant: in real time {rows[-1][1] if rows else 0} of {2 * len(rows)} answers were late, {len(rows)} periods")


def rival(folder):
    cell, arms = two_arms(folder)
    module(folder, cell)
    with MuJoCo(folder, cell) as mujoco, MuJoCo(folder, cell, "rival.log") as second:
        _, told = second.process.communicate(timeout=30)
        has("another program simulates `left`" in told, f"a second simulator was let in: {told}")
        ended_well(cell_of(folder, cell, "--virtual"), folder)
    print("plant: a second simulator was refused, and the first one went on")


def main():
    cases = {
        "one arm": lambda folder: lock_step(folder, one_arm),
        "two arms": lambda folder: lock_step(folder, two_arms),
        "killed in lock-step": lambda folder: killed(folder, signal.SIGKILL, "--virtual"),
        "killed in real time": lambda folder: killed(folder, signal.SIGKILL, "--processes"),
        "hangs in real time": lambda folder: killed(folder, signal.SIGSTOP, "--processes"),
        "EDP killed in real time": driver_killed,
        "real time": real_time,
        "rival": rival,
    }
    for name, case in cases.items():
        with tempfile.TemporaryDirectory(prefix="mrx") as folder:
            try:
                case(Path(folder))
                nothing_left(Path(folder))
            except Shortfall as why:
                sys.exit(f"plant: {name}: {why}")


if __name__ == "__main__":
    main()

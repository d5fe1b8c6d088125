"""What a bridge costs the processes that move robots, and whether rclpy misses anything: `cost.py [ROUNDS [SECONDS]]`.

Alternating runs in real time of a cell of four arms that shows its joints at 500 Hz: alone; with a bridge and a node of rclpy that takes the
joint states of all arms. Out: for each process that keeps time the median of the runs' lateness at 50, 99 and 99.9 % [us], what those with a
bridge differ by, beside how far the runs without one lie apart; how many joint states rclpy missed; the system calls of those processes in a
second. The exit status is not 0 where rclpy misses one of a run that left out no step.
"""

import json
import os
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from ending import interruptible  # noqa: E402
from tried import EXAMPLES, listen_in  # noqa: E402

DOMAIN = "93"
listen_in(DOMAIN)
STEP = 2_000_000  # [ns]
ARMS = ["left", "right", "third", "fourth"]
ALONE, WITH = "alone", "with a bridge"
SHARES = ["p50", "p99", "p99.9"]


def write_cell(file, step_ms):
    """The two arms of the panel's cell, and two that hold still."""
    text = re.sub(r"^after_fault = .*$", "", Path("ports/panel/examples/cell.toml").read_text(), flags=re.M)
    text = re.sub(r"^step_ms = .*$", f"step_ms = {step_ms}", text, flags=re.M)
    for i, name in enumerate(ARMS[2:], 2):
        text += f'\n[robots.{name}]\nkind = "irp6"\nstart = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]\nbase = {{ xyz = [{3.0 * i}, 0.0, 0.0] }}\n'
    file.write_text(text)


def listen():
    """A node that takes all joint states until it is ended, and then tells how many there were, and how many stamps between them were missing."""
    import rclpy
    from sensor_msgs.msg import JointState

    rclpy.init()
    node = rclpy.create_node("listener")
    stamps = {name: [] for name in ARMS}
    for name in ARMS:
        take = lambda message, of=stamps[name]: of.append(message.header.stamp.sec * 10**9 + message.header.stamp.nanosec)  # noqa: E731
        node.create_subscription(JointState, f"/{name}/joint_states", take, 2000)
    print("ready", flush=True)
    ended = []
    signal.signal(signal.SIGINT, lambda *_: ended.append(True))
    while not ended:
        rclpy.spin_once(node, timeout_sec=0.1)
    told = {}
    for name, of in stamps.items():
        gaps = [b - a for a, b in zip(of, of[1:])]
        told[name] = {"heard": len(of), "missed": sum(round(gap / STEP) - 1 for gap in gaps), "backwards": sum(gap <= 0 for gap in gaps)}
    print(json.dumps(told), flush=True)


def start(*words, **how):
    return subprocess.Popen([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=interruptible, **how)


def system_calls(cell):
    """Of the thread of each process that moves robots, in a second."""
    if not shutil.which("strace"):
        return {}
    status = subprocess.run([EXAMPLES / "arms", "status", "--cell", cell], capture_output=True, text=True).stdout
    calls = {}
    for pid, name in re.findall(r"^ +(\d+) (mp|plant|edp \S+) ", status, re.M):
        traced = subprocess.run(["timeout", "-s", "INT", "1", "strace", "-c", "-p", pid], capture_output=True, text=True).stderr
        rows = [row for row in map(str.split, traced.splitlines()) if len(row) >= 5 and row[3].isdigit() and row[-1] != "total"]
        calls[name] = {row[-1]: int(row[3]) for row in rows}
    return calls


def run(folder, kind, seconds, is_traced=False):
    """The outcome of the cell, what the node heard, and the system calls."""
    cell, outcome = folder / "cell.toml", folder / "outcome.json"
    outcome.unlink(missing_ok=True)
    others = []
    if kind == WITH:
        others = [start(EXAMPLES / "bridge", "--cell", cell, "--domain", DOMAIN), start(sys.executable, __file__, "--listen")]
        others[0].stderr.readline()
        others[1].stdout.readline()
        # They find one another.
        time.sleep(3)
    with open(folder / "said", "w+") as said:
        words = [EXAMPLES / "arms", "--cell", cell, "--processes", "--no-picture", "--quiet", "--outcome", outcome]
        process = subprocess.Popen([str(word) for word in words], stdout=said, stderr=said, preexec_fn=interruptible)
        time.sleep(seconds)
        calls = system_calls(cell) if is_traced else {}
        process.send_signal(signal.SIGINT)
        process.wait(timeout=60)
        said.seek(0)
        text = said.read()
    time.sleep(1)
    heard = {}
    for one in reversed(others):
        one.send_signal(signal.SIGINT)
        told, _ = one.communicate(timeout=30)
        heard = heard or json.loads(told.splitlines()[-1])
    if not outcome.exists():
        sys.exit(f"the cell has told no outcome: {text[-1000:]}")
    return json.loads(outcome.read_text()), heard, calls


def main(folder):
    numbers = [int(word) for word in sys.argv[1:]]
    rounds, seconds = (numbers + [3, 60][len(numbers) :])[:2]
    model = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    print(f"machine: {model and model[1]}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}; {rounds} rounds of {seconds} s")
    write_cell(folder / "cell.toml", 2)
    runs, missed = {ALONE: [], WITH: []}, 0
    for i in range(rounds):
        for kind, found in runs.items():
            outcome, heard, _ = run(folder, kind, seconds)
            fault = outcome["fault"]
            how = "" if fault is None or fault["kind"] == "Aborted" else f"; ended by {fault['text']}"
            found.append(outcome)
            told = ""
            if heard:
                told = ", rclpy heard " + ", ".join(str(one["heard"]) for one in heard.values()) + " and missed " + ", ".join(str(one["missed"]) for one in heard.values())
                # A period that the cell left out is none that was missed.
                if not how:
                    # Before the first and behind the last one it may have heard a few less.
                    missed += sum(one["heard"] < 0.95 * outcome["steps"] for one in heard.values())
                if outcome["skipped"] == 0 and not how:
                    missed += sum(one["missed"] + one["backwards"] for one in heard.values())
            print(f"run {i + 1}, {kind}: {outcome['steps']} steps, {outcome['skipped']} left out{told}{how}", flush=True)
    late = {kind: [{one["process"]: one["late"] for one in outcome["processes"]} for outcome in found] for kind, found in runs.items()}
    print(f"\n{'process':12} {'':6} {'alone [us]':>12} {'with a bridge':>14} {'differ by':>10} {'alone they differ by':>21}")
    for name in (name for name in late[ALONE][0] if name.split()[0] in ("mp", "edp", "plant")):
        for share in SHARES:
            of = {kind: [1e6 * one[name][share] for one in each] for kind, each in late.items()}
            alone, bridged = (statistics.median(of[kind]) for kind in (ALONE, WITH))
            print(f"{name:12} {share:6} {alone:12.1f} {bridged:14.1f} {bridged - alone:+10.1f} {max(of[ALONE]) - min(of[ALONE]):21.1f}")
    # Steps so long that a process that is traced keeps up.
    write_cell(folder / "cell.toml", 10)
    print("\nsystem calls in a second of a hundred steps:")
    for kind in runs:
        _, _, calls = run(folder, kind, 4, is_traced=True)
        for name, counts in calls.items():
            print(f"  {kind:14} {name:12} {sum(counts.values())}: {', '.join(f'{call} {count}' for call, count in sorted(counts.items()))}")
    if missed:
        sys.exit(f"ros2: rclpy missed {missed} joint states")


if __name__ == "__main__":
    if "--listen" in sys.argv:
        listen()
    else:
        with tempfile.TemporaryDirectory() as own_folder:
            main(Path(own_folder))

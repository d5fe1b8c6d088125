"""The driver of mrroc-kuka against RSIPI's emulator of a controller: what the emulator took, tested beside how the cell says that it ended.

Always: each demand goes on from the one before as fast as the motion is, over all time that passed in between; axes stay within what the
motion and a stop need; a cell that ends well, or stops for anything but the robot itself, leaves the arm at rest; signals switch in
their order; what ends the cell is what was done to it, or lateness by its name. Where the cell ran to its end: where the
arm was, to the hundredth of a degree, and what relative corrections add up to.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
sys.path.append(str(HERE.parent))
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402

PROGRAM = ROOT / "target/debug/examples/kuka"
EXAMPLES = ROOT / "robots/drivers/kuka/examples"
# The fastest axis of the motion [degrees/s], and how far the first one goes, to the hundredth that the emulator tells [degrees].
FASTEST = math.degrees(1.0)
# What its joints may do [degrees/s]: where the controller takes no answer, the next one makes up for it.
LIMIT = math.degrees(6.283)
SWING = (28.63, 28.66)
# How far it may go beyond that: for as long as the driver bridges demands that do not come, and then brakes [degrees].
BEYOND = math.degrees(0.1)


def run(file, times, *options):
    """The example with this cell at an emulator: how the cell ended, what the emulator saw, and each answer that it took."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        emulator = subprocess.Popen(
            [sys.executable, HERE / "kuka.py", "--path", folder / "path.json", *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        cell = subprocess.run(
            [PROGRAM, "--cell", EXAMPLES / file, "--processes", "--no-picture", "--outcome", folder / "outcome.json", "--", "--times", str(times)],
            capture_output=True,
            text=True,
            timeout=60 + 6 * times,
        )
        # The last answer has been taken by then.
        time.sleep(0.1)
        _, said = emulator.communicate(timeout=60)
        seen = json.loads(said.splitlines()[-1])
        path = json.loads((folder / "path.json").read_text())
        return Outcome(folder / "outcome.json", cell.stdout + cell.stderr), seen, path


def tested(outcome, seen, path, period, fastest=FASTEST):
    """What holds for every run."""
    largest = 0.0
    for (asked, _, *before), (_, taken, *after) in zip(path, path[1:]):
        step = max(abs(a - b) for a, b in zip(before, after))
        # A demand may have waited for its process before it was asked for.
        most = fastest * (taken - asked + outcome.longest_stall + 2 * period)
        has(step <= most, f"an axis jumped by {step} degrees in {taken - asked:.4f} s: {outcome}")
        largest = max(largest, step)
    low, high = (reach(path) for reach in (lambda p: min(each[2] for each in p), lambda p: max(each[2] for each in p))) if path else (0.0, 0.0)
    has(-BEYOND <= low and high <= SWING[1] + BEYOND, f"axis 1 went from {low} to {high} degrees")
    if outcome.kind != "RobotStopped" and len(path) > 1:
        last = max(abs(a - b) for a, b in zip(path[-2][2:], path[-1][2:]))
        has(last < 0.02, f"the arm still moved by {last} degrees in the last period")
    if outcome.kind is None:
        has(max(map(abs, path[-1][2:])) < 0.01, f"the arm ends at {path[-1][2:]} degrees")
    return f"{seen['cycles']} cycles, {seen['late']} answers late, steps of up to {largest:.3f} degrees; {outcome}"


def swing(outcome, seen, path, period):
    """Axis 1 goes to 0.5 rad and back."""
    reached = seen["range_deg"][0] if seen["cycles"] else 0.0
    if outcome.kind is None:
        # It is there for no longer than it takes to turn back, by 4 rad/s², and goes on in periods that were left out.
        longest = max(taken - asked for (asked, *_), (_, taken, *_) in zip(path, path[1:]))
        least = SWING[0] - (math.degrees(0.5 * 4.0 * longest**2) if longest > 3 * period else 0.0)
        most = SWING[1] + FASTEST * outcome.skipped * period
        has(least <= reached <= most, f"axis 1 was moved by {reached} degrees, not by 28.65 ({least} to {most})")
    else:
        not_tested("kuka", f"that axis 1 moves by 28.65 degrees (it moved by {reached})", outcome)


def absolute(cycles):
    """A time to and fro takes 1.4 s."""
    outcome, seen, path = run("cell.toml", cycles // 350 + 1)
    is_whole = outcome.ended_well(controller=True)
    figures = tested(outcome, seen, path, 0.004)
    swing(outcome, seen, path, 0.004)
    if is_whole:
        has(not seen["broke_off"], "the controller broke off, and the cell does not say so")
    print(f"kuka: {figures}")


def signals(_cycles):
    """Outputs are switched and inputs are read in the same messages: output 9 goes on and off, and what nobody tells stays as it is."""
    outcome, seen, path = run("signals.toml", 2)
    is_whole = outcome.ended_well(controller=True)
    tested(outcome, seen, path, 0.004)
    wanted, words = [0x8000, 0x8200, 0x8000, 0x8200, 0x8000], seen["outputs"]
    has(words == wanted[: len(words)] and (not is_whole or words == wanted), f"outputs were switched as {words}")
    if not is_whole:
        not_tested("kuka", "that all outputs are switched", outcome)
    print(f"kuka: signals: outputs were switched as {words}")


def relative(cycles):
    """With a period of 12 ms and relative corrections, until the cell ends: what was sent adds up to nothing, to the last digit. When it opens
    the drives, the driver leaves one message without an answer, to find out how the controller counts such."""
    outcome, seen, path = run("relative.toml", cycles // 500 + 1, "--mode", "relative", "--period", "12")
    is_whole = outcome.ended_well(controller=True)
    figures = tested(outcome, seen, path, 0.012)
    has(seen["late"] > 0 or not seen["cycles"], "the driver has not found out how the controller counts what is late")
    swing(outcome, seen, path, 0.012)
    if is_whole:
        has(max(map(abs, seen["end_deg"])) <= 1e-9, f"relative corrections do not add up: {seen['end_deg']}")
    print(f"kuka: relative corrections: {figures}")


def breaks_off(_cycles):
    """Every second answer is not taken: after 100 of them the controller breaks off, which the cell tells as the robot's silence."""
    outcome, seen, path = run("cell.toml", 20, "--lose-after", "200")
    if outcome.ended_by("RobotStopped", "communication lost: the robot has said nothing"):
        if not seen["broke_off"]:
            not_tested("kuka", "what a cell says of a controller that breaks off, which was silent before that", outcome)
    else:
        not_tested("kuka", "what a cell says of a controller that breaks off", outcome)
    print(f"kuka: breaks off: {tested(outcome, seen, path, 0.004, LIMIT)}")


PARTS = {part.__name__: part for part in (absolute, signals, relative, breaks_off)}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--cycles", type=int, default=1000)
    options = parser.parse_args()
    try:
        PARTS[options.part](options.cycles)
    except Shortfall as why:
        sys.exit(f"kuka: {options.part}: {why}")


if __name__ == "__main__":
    main()

"""Drivers across a network that loses, delays and reorders packets: in two network namespaces, joined by a wire of this process.

One namespace has the cell, the other one the controller. Packets from the cell's set-points are told by their
port. What a cell could not show that a late machine ended is told by name; and where the machine permits no namespaces, that.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent))
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402
from device_priority import urgent  # noqa: E402
from wire import Bad, Clear, Namespace, Wire, arguments, begin_in_namespace  # noqa: E402

ROOT = HERE.parent.parent.parent
CELL, ROBOT = "10.77.0.1", "10.77.0.2"
# Where the script of a UR calls: what comes from there are set-points.
SET_POINTS = 50001


class Gaps(Clear):
    """Of every `of` set-points that pass, the last `lost` are lost in a row."""

    def __init__(self, lost, of):
        self.lost, self.of, self.count = lost, of, 0

    def delay(self, _random, packet, of_cell):
        if not (of_cell and is_set_point(packet)):
            return 0.0
        self.count += 1
        return None if self.count % self.of >= self.of - self.lost else 0.0


class NoSetPoints(Clear):
    """None gets through."""

    def delay(self, _random, packet, of_cell):
        return None if of_cell and is_set_point(packet) else 0.0


def is_set_point(packet):
    """A TCP packet with data, from the port at which the script calls."""
    if packet[0] >> 4 != 4 or packet[9] != 6:
        return False
    head = (packet[0] & 15) * 4
    port = int.from_bytes(packet[head : head + 2], "big")
    return port == SET_POINTS and len(packet) > head + (packet[head + 12] >> 4) * 4


class Bench:
    """Both ends, the wire, and a folder for cell files."""

    def __init__(self, seed):
        self.wire = Wire(seed)
        self.cell, self.robot = Namespace("wire0", CELL, ROBOT), Namespace("wire1", ROBOT, CELL)
        self.wire.start()
        self.folder = Path(tempfile.mkdtemp())
        self.outcome_file = self.folder / "outcome.json"

    def cell_file(self, example):
        """The example, with the addresses of this network."""
        example = ROOT / example
        text = example.read_text().replace('address = "127.0.0.1"', f'address = "{ROBOT}"')
        text = text.replace('listen = "127.0.0.1:', f'listen = "{CELL}:')
        for other in example.parent.glob("*.urdf"):
            shutil.copy(other, self.folder)
        file = self.folder / example.name
        file.write_text(text)
        return str(file)

    def program(self, name, file, times, *own):
        self.outcome_file.unlink(missing_ok=True)
        command = [ROOT / "target/debug/examples" / name, "--cell", file, "--processes", "--no-picture", "--outcome", self.outcome_file]
        return subprocess.Popen(
            self.cell.within(*command, "--", "--times", times, *own), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

    def outcome(self, words):
        """How the cell ended that said this."""
        return Outcome(self.outcome_file, words)

    def close(self):
        self.wire.ended = True
        self.wire.join()
        self.cell.close()
        self.robot.close()
        shutil.rmtree(self.folder)


def controller(bench):
    """A UR's, at the other end."""
    process = subprocess.Popen(
        bench.robot.within(str(ROOT / "target/debug/ur-controller"), "ur5e", ROBOT),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=urgent,
    )
    has(process.stdout.readline().startswith("ur5e at"), "the controller does not start")
    return process


def said(process):
    process.stdin.write("say\n")
    process.stdin.flush()
    return process.stdout.readline()


def said_at_rest(process):
    """The same when the script has ended. Where the cell's farewell was lost, that takes as long as its read timeout, and braking."""
    for _ in range(50):
        told = said(process)
        if "STOPPED" in told.upper():
            break
        time.sleep(0.1)
    return told


def ur(bench, way, times, timeout_ms, after=1.0):
    """The UR example behind this wire, which is clear until the arm moves: how it ended, what it and the controller said."""
    bench.wire.way = Clear()
    robot = controller(bench)
    try:
        cell = bench.program("ur", bench.cell_file("robots/drivers/ur/examples/cell.toml"), times, "--read-timeout", timeout_ms)
        time.sleep(after)
        bench.wire.way = way
        words, _ = cell.communicate(timeout=60 + 3 * times)
        bench.wire.way = Clear()
        told = said_at_rest(robot)
        return bench.outcome(words), told
    finally:
        bench.wire.way = Clear()
        robot.stdin.close()
        robot.wait(20)


def gap_ms(told):
    return int(told.split("longest gap: ")[1].split()[0])


def ur_loses_packets(bench, times):
    """Packets of all kinds are lost, late and out of order. TCP sends a lost one again within some milliseconds, and one whose repeat is
    lost, too, after 200 ms: then the robot has said nothing for longer than 100 ms, or the script has heard nothing for longer than its
    read timeout, and the cell stops in order."""
    survived = 0
    for loss in (0.002, 0.01, 0.1):
        lost = bench.wire.lost
        outcome, told = ur(bench, Bad(loss, 0.001), times, 200)
        lost = bench.wire.lost - lost
        if outcome.is_late():
            # The cell's own processes were too late for one another, whatever the network did.
            not_tested("ur", f"what {loss:.1%} of lost packets do", outcome)
        is_whole = outcome.ended_well(controller=True)
        survived += is_whole
        how = "nothing stopped" if is_whole else str(outcome)
        print(f"ur: {loss:.1%} of the packets lost, {lost} in all: {how}, the longest gap was {gap_ms(told)} ms")
        has(lost > 0 and "STOPPED" in told.upper(), f"{lost} lost, and {told}")
        has(gap_ms(told) <= 202, "the script waited for longer than its read timeout, and did not end")
    print(f"ur: with lost packets {survived} of 3 runs went on to their end")


def ur_loses_set_points(bench, times):
    """Five set-points in a row are lost each second: the arm goes on meanwhile, and nothing stops."""
    outcome, told = ur(bench, Gaps(5, 500), times, 200)
    if not outcome.ended_well(controller=True):
        not_tested("ur", "that 5 set-points that are lost in a row stop nothing", outcome)
    print(f"ur: 5 set-points in a row lost: the longest gap was {gap_ms(told)} ms")
    has(gap_ms(told) >= 10, "no set-point was lost")


def ur_is_cut_off(bench, _times):
    """No set-point gets through any more: the script brakes and ends, and the cell is told so."""
    for timeout in (20, 200):
        outcome, told = ur(bench, NoSetPoints(), 4, timeout, after=2.0)
        is_told = outcome.ended_by("RobotStopped", "communication lost") and "set-points did not come in time" in outcome.text
        has("STOPPED" in told.upper(), f"the script goes on: {outcome}: {told}")
        if not is_told:
            # With 20 ms a machine that is late is cut off before the wire is.
            not_tested("ur", f"what is told of a cut with a read timeout of {timeout} ms", outcome)
        print(f"ur: cut off with a read timeout of {timeout} ms: {outcome}, {told.strip()}")


def kuka(bench, way, *options, times, file):
    bench.wire.way = Clear()
    test = subprocess.Popen(
        bench.robot.within(sys.executable, str(HERE / "kuka.py"), "--address", ROBOT, "--cell", CELL, *options),
        # Its end is that of its input.
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    cell = bench.program("kuka", bench.cell_file(file), times)
    time.sleep(1.0)
    bench.wire.way = way
    words, _ = cell.communicate(timeout=60 + 6 * times)
    bench.wire.way = Clear()
    _, seen = test.communicate(timeout=60)
    return bench.outcome(words), json.loads(seen.splitlines()[-1])


def kuka_loses_packets(bench, times):
    """Packets of an RSI are lost each way: the path is kept, and the controller counts."""
    for mode, file in (("absolute", "cell.toml"), ("relative", "relative.toml")):
        period = "4" if mode == "absolute" else "12"
        outcome, seen = kuka(
            bench, Bad(0.01, 0.0005), "--mode", mode, "--period", period, times=times, file=f"robots/drivers/kuka/examples/{file}"
        )
        has(seen["late"] > 0, f"no answer was lost: {seen}")
        if outcome.ended_well(controller=True):
            off = max(map(abs, seen["end_deg"]))
            print(f"kuka: {seen['late']} of {seen['cycles']} answers lost, {mode}: at its end the arm is {off:.1e} degrees off")
            has(off < 1e-6, f"the arm does not end where it should: {seen}")
        else:
            not_tested("kuka", f"where the arm ends with lost packets, {mode}", outcome)


def kuka_loses_all(bench, _times):
    """No packet gets through: the cell is told, and the robot is left to its own controller."""
    outcome, seen = kuka(bench, Bad(1.0, 0.0), times=20, file="robots/drivers/kuka/examples/cell.toml")
    if not outcome.ended_by("RobotStopped", "communication lost: the robot has said nothing"):
        not_tested("kuka", "what is told of a cut", outcome)
    print(f"kuka: cut off after {seen['cycles']} cycles: {outcome}")


PARTS = [ur_loses_packets, ur_loses_set_points, ur_is_cut_off, kuka_loses_packets, kuka_loses_all]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--times", type=int, default=3, help="to and fro")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="one part")
    options = parser.parse_args(arguments())
    if not begin_in_namespace():
        print("network: skipped: this machine permits no network namespaces")
        return
    print(f"network: seed {options.seed}")
    bench = Bench(options.seed)
    try:
        for part in PARTS:
            if options.only in (None, part.__name__):
                part(bench, options.times)
    except Shortfall as shortfall:
        sys.exit(f"network: {shortfall}")
    finally:
        bench.close()


if __name__ == "__main__":
    main()

"""A cell whose sensor is a Python program on PyPI's iceoryx2, which sends, hiccups, is killed, lies, and has a rival.

In: the example `follow`, built. Out: exit status 0 if the readings that the cell recorded are those that were sent, to the bit and in their
order, and if the robot stood within its bound after each end of them, longer by the steps that the cell left out. A cell that was late
may end by that before: then how its readings end is not tested, and all else is.
"""

import ctypes
import json
import math
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent))
from ending import end, until_interrupted  # noqa: E402
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402
from device_priority import urgent  # noqa: E402

ROOT = Path(__file__).resolve().parents[3]
FOLLOW = ROOT / "target/debug/examples/follow"
CELL = ROOT / "ports/external/examples/cell.toml"
STEP = 0.002
STALE = 50  # steps: 100 ms
RATE = 30.0  # of readings [Hz]
AFTER = 0.7  # so long a cell of two seconds reads a program before something happens to that [s]
# The joint that moves, at 0.5 rad/s: its braking time at 7 rad/s² is 0.214 s by `--check`.
BRAKING = 107
DELAY = 1


def program(mode, log):
    """The program of another, in a process of its own."""
    import camera_port as port

    urgent()
    rng = random.Random(7)
    if mode == "other size":
        class Small(ctypes.Structure):
            _fields_ = [("version", ctypes.c_uint32)]
            type_name = staticmethod(lambda: "mrroc_external_1")
        port._Message = Small
    try:
        ends = port.Port()
    except (port.SecondWriter, port.OtherMessages) as error:
        print(error)
        raise SystemExit(3) from None
    with ends, open(log, "w", buffering=1) as sent:
        began, heard, hiccup = time.monotonic(), None, False
        while True:
            now = time.monotonic_ns()
            order = ends.order()
            heard = time.monotonic() if heard is None and order is not None else heard
            # It goes wrong when the cell has read it for a while.
            t, reads = time.monotonic() - began, time.monotonic() - (heard or time.monotonic())
            # Noise in every bit, slower than 2 rad/s.
            direction = 0.2 * math.sin(t) + 1e-3 * rng.random()
            reading = port.Reading(direction, True)
            if reads > AFTER and mode == "hiccup" and not hiccup:
                hiccup = True
                time.sleep(0.2)
            if reads > AFTER and mode == "other layout":
                port.LAYOUT ^= 1
            if reads > AFTER and mode == "jump":
                reading = port.Reading(direction + 0.25, True)
            if reads > AFTER and mode == "future":
                now += 10**12
            version, port.VERSION = port.VERSION, 2 if reads > AFTER and mode == "other version" else port.VERSION
            ends.send(reading, now, order)
            port.VERSION = version
            sent.write(f"{struct.pack('>d', reading.direction).hex()} {now} {heard is not None:d}\n")
            time.sleep(max(0.0, 1 / port.RATE_HZ - (time.monotonic_ns() - now) / 1e9))


class Program:
    """The program of another, for as long as it is needed."""

    def __init__(self, folder, mode, is_first=True):
        log = folder / f"{mode}.sent"
        command = [sys.executable, __file__, "program", mode, str(log)]
        self.process = subprocess.Popen(command, env=env(folder), stdout=subprocess.PIPE, text=True)
        # The first one has the port when it has sent something.
        while is_first and self.process.poll() is None and not (log.exists() and log.stat().st_size):
            time.sleep(0.01)

    def __enter__(self):
        return self.process

    def __exit__(self, *_):
        end(self.process, signal.SIGTERM)


def env(folder):
    return {**os.environ, "PYTHONPATH": str(folder), "MRROC_PORTS": str(folder / "ports")}


def cell(folder, seconds="2"):
    command = [FOLLOW, "--cell", CELL, "--processes", "--no-picture", "--record", folder / "run.mcap"]
    command += ["--outcome", folder / "outcome.json", "--", "--seconds", seconds]
    return subprocess.Popen(command, env=env(folder), cwd=folder, stderr=subprocess.PIPE, text=True)


class Run:
    """What a cell recorded."""

    def __init__(self, folder):
        from mcap.reader import make_reader

        self.readings, self.demands, self.modes, self.faults = [], [], [], []
        with open(folder / "run.mcap", "rb") as file:
            for _, channel, message in make_reader(file).iter_messages():
                said = json.loads(message.data)
                if channel.topic == "/sensors/camera" and "reading" in said:
                    self.readings.append((said["step"], said["taken"], said["reading"]["direction"]))
                elif channel.topic == "/robots/arm":
                    self.demands.append((said["step"], said["demanded"]["joints"][0]))
                elif channel.topic == "/events" and said["what"] == "fault":
                    self.faults.append((said["step"], said["text"]))

    def last_motion(self):
        """The last step in which the demand changed."""
        pairs = zip(self.demands, self.demands[1:])
        return max((after[0] for before, after in pairs if before[1] != after[1]), default=0)


def ended(running, folder):
    """How the cell ended, and what it said."""
    _, said = running.communicate(timeout=60)
    return Outcome(folder / "outcome.json", said), said


def sent(folder, mode):
    return [line.split()[0] for line in (folder / f"{mode}.sent").read_text().splitlines()]


def bits(number):
    return struct.pack(">d", number).hex()


def until_read(folder, mode, running):
    """Until the cell has read a program for a while."""
    while running.poll() is None and not any(line.endswith(" 1") for line in (folder / f"{mode}.sent").read_text().splitlines()):
        time.sleep(0.02)
    time.sleep(AFTER)


def stale(outcome, program):
    """Whether the program, in Python, was late itself: no reading of it was taken for so long though it was there to the end."""
    return outcome.kind == "SensorStale" and program.poll() is None


def equal(folder):
    """Every reading is one that was sent, in the order in which they were, and none is missing between two."""
    with Program(folder, "plain") as first, Program(folder, "rival", is_first=False) as rival:
        running = cell(folder)
        told, _ = rival.communicate(timeout=30)
        outcome, _ = ended(running, folder)
        is_whole = not stale(outcome, first) and outcome.ended_well()
    has(rival.returncode == 3 and "another program sends" in told, f"a second writer was let in: {told}")
    run, wrote = Run(folder), sent(folder, "plain")
    read = []
    for _, _, direction in run.readings:
        if not read or read[-1] != bits(direction):
            read.append(bits(direction))
    has(set(read) <= set(wrote), "a reading was never sent")
    places = [wrote.index(word) for word in read]
    has(all(a < b for a, b in zip(places, places[1:])), "a reading came twice, or after a later one")
    # A reading counts from when it was measured.
    has(all(taken <= step for step, taken, _ in run.readings), "a reading is of the future")
    # The last one may be sent when the cell has just ended, and the log is one line behind.
    missing = places[-1] - places[0] + 1 - len(read) if read else 0
    if is_whole:
        has(len(read) > 20, f"{len(read)} readings")
    else:
        not_tested("external", "that it reads until its end", outcome)
    if outcome.longest_stall < 1 / RATE:
        has(missing <= max(1, len(read) // 10), f"{missing} of {len(wrote)} readings were not read")
    else:
        not_tested("external", f"that none of the readings is missing ({missing} are)", outcome)
    ages = [step - taken for step, taken, _ in run.readings]
    print(f"external: {len(read)} readings equal to the bit, {missing} came between two looks; oldest {max(ages, default=0)} steps")


def stopped(folder, mode, kind, told, kill=False):
    """The readings end in some way, and the robot with them."""
    name = "kill -9" if kill else mode
    # A cell whose sensor says nothing for 100 ms ends, and Python may take longer than that to begin.
    with Program(folder, mode) as python:
        running = cell(folder)
        if kill:
            until_read(folder, mode, running)
            python.kill()
        outcome, _ = ended(running, folder)
    # A program that is late makes a stale sensor of any.
    is_told = (outcome.kind == kind or outcome.kind != "SensorStale") and outcome.ended_by(kind, told)
    run = Run(folder)
    at = outcome.steps if outcome.step is None else outcome.step
    # Of those that the Move had: a program that has got over its hiccup may send again while the robot brakes.
    last = max((taken for step, taken, _ in run.readings if step <= at), default=0)
    moved = run.last_motion()
    # For as many steps as the cell left out robots go on as before.
    bound = STALE + 1 + BRAKING + 2 * DELAY + outcome.skipped
    if not is_told:
        # From what has stopped it instead it brakes at once.
        last, bound = at, bound - STALE
    has(moved - last <= bound, f"{name}: it moved for {moved - last} steps, at most {bound} are allowed")
    if not is_told:
        not_tested("external", f"how a sensor ends that ends by {name}", outcome)
    print(f"external: {name}: the last demand that moved came {moved - last} of {bound} steps after the last reading was taken")


def refused(folder):
    """A program with messages of another size cannot even open the port."""
    with Program(folder, "plain") as first, Program(folder, "other size", is_first=False) as other:
        running = cell(folder)
        told, _ = other.communicate(timeout=30)
        outcome, _ = ended(running, folder)
        is_whole = not stale(outcome, first) and outcome.ended_well()
    has(other.returncode == 3 and "other messages" in told, f"messages of another size: {told}")
    if not is_whole:
        not_tested("external", "that the first program goes on", outcome)
    print("external: a program with messages of another size was refused, and the first one went on")


def nothing_left(folder):
    ports = folder / "ports"
    left = [path for path in ports.rglob("*") if path.is_file()]
    has(not left, f"files are left: {left}")
    value = 0xCBF29CE484222325
    for byte in str(ports).encode():
        value = ((value ^ byte) * 0x100000001B3) % 2**64
    prefix = f"mrroc_ports_{value:016x}_"
    segments = [path for path in Path("/dev/shm").iterdir() if path.name.startswith(prefix)]
    # The one in which nodes count themselves stays, 16 bytes for the user alone.
    has(all(path.name.endswith(".global_mgmt") for path in segments), f"segments are left: {segments}")
    has(all(path.stat().st_mode & 0o077 == 0 for path in segments), "a segment is open to others")
    for path in segments:
        path.unlink()


def main():
    cases = {
        "equal": equal,
        "hiccup": lambda folder: stopped(folder, "hiccup", "SensorStale", "too old"),
        "kill -9": lambda folder: stopped(folder, "plain", "SensorStale", "too old", kill=True),
        "other version": lambda folder: stopped(folder, "other version", "SensorFailed", "another version of the port"),
        "other layout": lambda folder: stopped(folder, "other layout", "SensorFailed", "make its module anew"),
        "jump": lambda folder: stopped(folder, "jump", "SensorFailed", "`direction` jumps"),
        "future": lambda folder: stopped(folder, "future", "SensorFailed", "a reading of the future"),
        "other size": refused,
    }
    for name, case in cases.items():
        with tempfile.TemporaryDirectory(prefix="mrx") as folder:
            folder = Path(folder)
            module = subprocess.run([FOLLOW, "--cell", CELL, "external", "camera"], capture_output=True, check=True)
            (folder / "camera_port.py").write_bytes(module.stdout)
            try:
                case(folder)
                nothing_left(folder)
            except Shortfall as why:
                sys.exit(f"external: {name}: {why}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["program"]:
        until_interrupted(program, *sys.argv[2:])
    else:
        main()

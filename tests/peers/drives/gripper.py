"""A gripper by pymodbus on this machine's loopback, and a cell that closes and opens it.

    gripper.py PROGRAM CELL     runs the program of that file against servers, and says what falls short
    gripper.py --transfer PROGRAM CELL
                                the same with the transfer, of which the gripper is one hand
    gripper.py --serve ..       a server, which prints its port, and when it is ended what it saw as a line of JSON

The fingers go to what they are told as a first-order system with a largest speed, and stop at a part. A cell that a late machine ends has
grasped, opened and activated nothing more than it should; that it does all of it is then not tested, and told by name.
"""

import argparse
import asyncio
import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402
from device_priority import urgent  # noqa: E402

REQUEST, STATUS, UNIT = 0x03E8, 0x07D0, 9
CLOSE, OPEN, PART = 203, 16, 120  # 10 mm, 80 mm and 41 mm, in the gripper's numbers
# The transfer's hand closes to 57 mm on a bar of 60 mm and opens to 75 mm; 91 mm are 3, 53 mm 230.
BAR, CLEAR = 188, 99


class Fingers:
    """A Robotiq 2F by its registers. A number is a 255th of its stroke."""

    LAG, SPEED, ACTIVATION = 0.04, 400.0, 1.0  # [s], [1/s], [s]

    def __init__(self, active, part, clear):
        self.active, self.part, self.clear = active, part, clear
        self.gto, self.told, self.position = active, clear, float(clear)
        self.requested, self.since = active, time.monotonic()
        self.activating = None
        self.held = False
        self.seen = {"writes": 0, "reads": 0, "activations": 0, "grasps": 0, "held_s": 0.0, "opened": 0}

    def write(self, words):
        self.go_on()
        self.seen["writes"] += 1
        rises = words[0] & 0x0100 and not self.requested
        self.requested = bool(words[0] & 0x0100)
        if not self.requested:
            self.active, self.activating, self.gto = False, None, False
        elif rises:
            self.activating = time.monotonic()
            self.seen["activations"] += 1
        if self.active and words[0] & 0x0800:
            self.gto, self.told = True, words[1] & 0xFF

    def go_on(self):
        now = time.monotonic()
        passed, self.since = now - self.since, now
        if self.activating is not None and now - self.activating > self.ACTIVATION:
            self.active, self.activating, self.position = True, None, 3.0
        if not (self.active and self.gto):
            return
        was_held, was_open = self.held, self.position < self.clear + 1
        way = (self.told - self.position) * min(1.0, passed / self.LAG)
        way = max(-self.SPEED * passed, min(self.SPEED * passed, way))
        self.held = self.part is not None and self.told > self.part and self.position + way >= self.part
        self.position = self.part if self.held else self.position + way
        self.seen["grasps"] += self.held and not was_held
        self.seen["held_s"] += passed * self.held
        self.seen["opened"] += self.position < self.clear + 1 and not was_open

    def read(self):
        self.go_on()
        self.seen["reads"] += 1
        there = abs(self.told - self.position) < 0.5
        fingers = 2 if self.held else 3 if there else 0
        state = 3 if self.active else 1 if self.activating is not None else 0
        status = self.requested | self.gto << 3 | state << 4 | fingers << 6
        return [status << 8, self.told, round(self.position) << 8 | (20 if self.held else 2)]


async def serve(options):
    import logging

    from pymodbus.constants import ExcCodes
    from pymodbus.server import ModbusTcpServer
    from pymodbus.simulator import DataType, SimData, SimDevice

    # Connections that end are what is tried here.
    logging.getLogger("pymodbus").setLevel(logging.CRITICAL + 1)
    fingers = Fingers(not options.inactive, options.part, options.clear)

    async def act(function, start, address, count, registers, words):
        if options.fails_after and fingers.seen["reads"] > options.fails_after:
            return ExcCodes.DEVICE_FAILURE
        if words is not None:
            fingers.write(words)
        elif address == STATUS:
            at = address - start
            registers[at : at + 3] = fingers.read()
        return None

    blocks = [SimData(address, values=[0, 0, 0], datatype=DataType.REGISTERS) for address in (REQUEST, STATUS)]
    device = SimDevice(UNIT, blocks, action=act)
    server = ModbusTcpServer(device, address=("127.0.0.1", 0))
    await server.serve_forever(background=True)
    print(server.transport.sockets[0].getsockname()[1], flush=True)
    ended = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, ended.set)
    began = time.monotonic()
    await ended.wait()
    fingers.seen["seconds"] = time.monotonic() - began
    print(json.dumps(fingers.seen), flush=True)


class Server:
    """It, in a process of its own."""

    def __init__(self, options):
        command = [sys.executable, __file__, "--serve", *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, preexec_fn=urgent)
        self.port = int(self.process.stdout.readline())

    def end(self):
        """What it saw; nothing, if it was killed."""
        self.process.terminate()
        return json.loads(self.process.communicate()[0].strip() or "{}")


def run(program, cell, *options, homed=True, own=(), kill_after=None):
    """What the cell says, how it ended (None if it was refused), and what the server saw."""
    server = Server(options)
    text = pathlib.Path(cell).read_text().replace("127.0.0.1:1502", f"127.0.0.1:{server.port}")
    text = text.replace("homed = true", f"homed = {str(homed).lower()}")
    # Tight motions bridge one step of 20 ms, which a busy machine keeps.
    text = text.replace("step_ms = 2\n", "step_ms = 20\n")
    with tempfile.TemporaryDirectory() as folder:
        file, told = pathlib.Path(folder) / "cell.toml", pathlib.Path(folder) / "outcome.json"
        file.write_text(text)
        command = [program, "--cell", str(file), "--processes", "--no-picture", "--outcome", str(told), "--", *own]
        running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            if kill_after is not None:
                time.sleep(kill_after)
                server.process.kill()
            said = running.communicate(timeout=60)[0]
        except subprocess.TimeoutExpired:
            running.terminate()
            raise Shortfall("it did not end: " + running.communicate()[0]) from None
        outcome = None if running.returncode == 2 else Outcome(told, said)
    return said, outcome, server.end()


def times(count):
    return ["--times", str(count)]


def done(name, outcome, said):
    """Whether the cell ran to its end; if it did not, that is told."""
    has(outcome is not None, f"{name}: the cell was refused: {said}")
    if outcome.ended_well(controller=True):
        return True
    not_tested("gripper", name, outcome)
    return False


def lost(name, outcome, said, words, kind="RobotStopped"):
    """Whether the loss of the gripper is what ended the cell."""
    has(outcome is not None, f"{name}: the cell was refused: {said}")
    if outcome.ended_by(kind, words):
        print(f"gripper: {name}: {outcome}")
    else:
        not_tested("gripper", name, outcome)


def test(program, cell):
    # A part is closed on, carried and let go, twice.
    part = ["--part", str(PART)]
    said, outcome, seen = run(program, cell, *part, own=times(2))
    print("gripper:", json.dumps(seen))
    has(seen["activations"] == 0, "an active gripper was activated")
    has(seen["grasps"] <= 2 and seen["opened"] <= 2, f"the part was carried more than twice: {seen}")
    if done("that a part is carried twice", outcome, said):
        # The arm carries it for 2 s and more, after half a second of rest.
        has(seen["grasps"] == 2 and seen["opened"] == 2 and seen["held_s"] > 5.0, f"the part was not carried twice: {seen}: {said}")

    # Without a part nothing is carried.
    said, outcome, seen = run(program, cell)
    has(seen["grasps"] == 0 and seen["opened"] <= 1, f"without a part it carried something: {seen}: {said}")
    if done("that it closes and opens without a part", outcome, said):
        has(seen["opened"] == 1, f"without a part it did not close and open: {seen}: {said}")

    # One that is not active: refused without a word to it, or activated because the file says so.
    said, outcome, seen = run(program, cell, "--inactive")
    has(seen["writes"] == 0, "an inactive gripper was written to")
    if outcome is not None and outcome.is_late():
        not_tested("gripper", "that an inactive gripper is refused", outcome)
    else:
        has((outcome is None or outcome.kind is not None) and "not activated" in said, f"an inactive gripper was not refused: {outcome}: {said}")
    said, outcome, seen = run(program, cell, "--inactive", *part, homed=False)
    has(seen["activations"] <= 1 and seen["grasps"] <= 1, f"it was activated, and used, more than once: {seen}")
    if done("that a gripper is activated, and used", outcome, said):
        has(seen["activations"] == 1 and seen["grasps"] == 1, f"it was not activated once, and used: {seen}: {said}")

    # A server that is killed in motion, and one that refuses.
    said, outcome, _ = run(program, cell, *part, own=times(100), kill_after=4.0)
    lost("a connection that is lost", outcome, said, "hand: stopped at the robot: communication lost")
    said, outcome, _ = run(program, cell, *part, "--fails-after", "100", own=times(100))
    lost("a refusal", outcome, said, "exception 4", "DriveFault")


def test_transfer(program, cell):
    """In the transfer its hand closes on the bar before the arms carry it, and opens after that."""
    bar = ["--part", str(BAR), "--clear", str(CLEAR)]
    said, outcome, seen = run(program, cell, *bar)
    print("gripper: transfer:", json.dumps(seen))
    has(seen["grasps"] <= 1 and seen["opened"] <= 1, f"the bar was carried more than once: {seen}")
    if done("that the transfer carries its bar", outcome, said):
        # The arms carry it for more than 5 s between the two.
        has(seen["grasps"] == 1 and seen["opened"] == 1 and seen["held_s"] > 5.0, f"the bar was not carried: {seen}: {said}")
    # Lost in motion, all robots stop.
    said, outcome, _ = run(program, cell, *bar, kill_after=6.0)
    lost("a hand that is lost in the transfer", outcome, said, "polycrank-hand: stopped at the robot: communication lost")


def main():
    if "--serve" not in sys.argv:
        try:
            if sys.argv[1] == "--transfer":
                test_transfer(*sys.argv[2:4])
            else:
                test(*sys.argv[1:3])
        except Shortfall as why:
            sys.exit(f"gripper: {why}")
        return
    parser = argparse.ArgumentParser()
    parser.add_argument("--serve", action="store_true")
    parser.add_argument("--inactive", action="store_true")
    parser.add_argument("--part", type=int)
    parser.add_argument("--clear", type=int, default=OPEN)
    parser.add_argument("--fails-after", type=int)
    asyncio.run(serve(parser.parse_args()))


if __name__ == "__main__":
    main()

"""A gripper by pymodbus on this machine's loopback, and a cell that closes and opens it.

    gripper.py PROGRAM CELL     runs the program of that file against servers, and says what falls short
    gripper.py --transfer PROGRAM CELL
                                the same with the transfer, of which the gripper is one hand; ends with 75 where this machine is
                                late again and again
    gripper.py --serve ..       a server, which prints its port, and when it is ended what it saw as a line of JSON

The fingers go to what they are told as a first-order system with a largest speed, and stop at a part.
"""

import argparse
import asyncio
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))
from late import late  # noqa: E402

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
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.port = int(self.process.stdout.readline())

    def end(self):
        """What it saw; nothing, if it was killed."""
        self.process.terminate()
        return json.loads(self.process.communicate()[0].strip() or "{}")


# What a server in Python causes that is given too little time.
TOO_SLOW = ["no answer came", "no reading came"]


def run(program, cell, *options, **how):
    """What the cell says, its exit status, and what the server saw. A machine that is too busy is given five tries."""
    for _ in range(5):
        server = Server(options)
        said, status = once(program, cell, server, **how)
        seen = server.end()
        why = late(said, *TOO_SLOW)
        if not why:
            break
        print("gripper: late,", why, file=sys.stderr)
    return said, status, seen


def once(program, cell, server, homed=True, times=1, kill_after=None):
    """What the cell says, and its exit status."""
    text = pathlib.Path(cell).read_text().replace("127.0.0.1:1502", f"127.0.0.1:{server.port}")
    text = text.replace("homed = true", f"homed = {str(homed).lower()}")
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "cell.toml"
        file.write_text(text)
        running = subprocess.Popen(
            [program, "--cell", str(file), "--processes", "--no-picture"],
            env={"MRROC_TIMES": str(times)},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        try:
            if kill_after is not None:
                time.sleep(kill_after)
                server.process.kill()
            said = running.communicate(timeout=60)[0]
        except subprocess.TimeoutExpired:
            running.terminate()
            return "it did not end: " + running.communicate()[0], -1
    return said, running.returncode


def judge(program, cell):
    """What falls short."""
    wrong = []

    def expect(holds, what, said):
        if not holds:
            wrong.append(what)
            print(f"gripper: {what}\n{said}", file=sys.stderr)

    # A part is closed on, carried and let go, twice.
    part = ["--part", str(PART)]
    said, status, seen = run(program, cell, *part, times=2)
    print("gripper:", json.dumps(seen))
    expect(status == 0, f"the cell ended with {status}", said)
    # The arm carries it for 2 s and more, after half a second of rest.
    carried = seen["grasps"] == 2 and seen["opened"] == 2 and seen["held_s"] > 5.0
    expect(carried, "the part was not carried twice", said)
    expect(seen["activations"] == 0, "an active gripper was activated", said)

    # Without a part nothing is carried.
    said, status, seen = run(program, cell)
    done = status == 0 and seen["grasps"] == 0 and seen["opened"] == 1
    expect(done, "without a part it did not close and open", said)

    # One that is not active: refused without a word to it, or activated because the file says so.
    said, status, seen = run(program, cell, "--inactive")
    expect(status > 0 and "not activated" in said, "an inactive gripper was not refused", said)
    expect(seen["writes"] == 0, "an inactive gripper was written to", said)
    said, status, seen = run(program, cell, "--inactive", *part, homed=False)
    done = status == 0 and seen["activations"] == 1 and seen["grasps"] == 1
    expect(done, f"it was not activated once, and used: {seen}", said)

    # A server that is killed in motion, and one that refuses.
    said, status, _ = run(program, cell, *part, times=100, kill_after=4.0)
    lost = "hand: stopped at the robot: communication lost" in said
    expect(status > 0 and lost, "a lost connection did not stop the cell", said)
    print("gripper:", next((line for line in said.splitlines() if line.startswith("error")), "no error"))
    said, status, _ = run(program, cell, *part, "--fails-after", "100", times=100)
    expect(status > 0 and "exception 4" in said, "a refusal did not stop the cell", said)
    return wrong


def judge_transfer(program, cell):
    """What falls short in the transfer: its hand closes on the bar before the arms carry it, and opens after that."""
    wrong = []
    said, status, seen = run(program, cell, "--part", str(BAR), "--clear", str(CLEAR))
    if late(said, *TOO_SLOW):
        sys.exit(75)
    print("gripper: transfer:", json.dumps(seen))
    # The arms carry the bar for more than 5 s between the two.
    done = status == 0 and seen["grasps"] == 1 and seen["opened"] == 1 and seen["held_s"] > 5.0
    if not done:
        wrong.append("the transfer")
        print(f"gripper: the transfer ended with {status}\n{said}", file=sys.stderr)
    # Lost in motion, all robots stop.
    said, status, _ = run(program, cell, "--part", str(BAR), "--clear", str(CLEAR), kill_after=6.0)
    print("gripper: transfer:", next((line for line in said.splitlines() if line.startswith("error")), "no error"))
    if late(said, *TOO_SLOW):
        sys.exit(75)
    if status <= 0 or "polycrank-hand: stopped at the robot: communication lost" not in said:
        wrong.append("a lost hand")
        print(f"gripper: a lost connection did not stop the transfer\n{said}", file=sys.stderr)
    return wrong


def main():
    if "--serve" not in sys.argv:
        try:
            os.nice(-15)  # a busy machine is not what is tried
        except PermissionError:
            pass
        judged = judge_transfer(*sys.argv[2:4]) if sys.argv[1] == "--transfer" else judge(*sys.argv[1:3])
        sys.exit(1 if judged else 0)
    parser = argparse.ArgumentParser()
    parser.add_argument("--serve", action="store_true")
    parser.add_argument("--inactive", action="store_true")
    parser.add_argument("--part", type=int)
    parser.add_argument("--clear", type=int, default=OPEN)
    parser.add_argument("--fails-after", type=int)
    asyncio.run(serve(parser.parse_args()))


if __name__ == "__main__":
    main()

"""The driver of the Franka Hand against hands of others, and the hand of its own tests against Franka's client.

`--serve SIMULATOR` is the hand of franka-sim or of franky-sim on this machine's loopback, for the process that tests: it says where it
is when it is ready, and at each line that it reads what it was asked for and where its fingers are, as one line of JSON.

Of a cell that a late machine ended it is tested what the hand was asked for, and what the program said until then.
"""

import argparse
import json
import os
import re
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent))
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402
from device_priority import urgent  # noqa: E402

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
ADDRESS = "127.0.0.1"
PART = 0.03
REQUESTS = ["connect", "homing", "grasp", "move", "stop"]


def serve(options):
    asked = []
    if options.serve == "franka-sim":
        from franka_sim import FrankaGripperServer, FrankaHandSim
        from franka_sim.gripper.protocol import GRIPPER_HEADER_SIZE

        # Its fingers are where they were told to be at once; the part stops them.
        backend = FrankaHandSim(object_width=options.part)

        class Hand(FrankaGripperServer):
            def _dispatch_command(self, sock, header, payload):
                numbers = struct.unpack(f"<{(header.size - GRIPPER_HEADER_SIZE) // 8}d", payload)
                asked.append([int(header.command), list(numbers)])
                return super()._dispatch_command(sock, header, payload)

        hand = Hand(host=ADDRESS, backend=backend)
        threading.Thread(target=hand.run_server, daemon=True).start()

        def state():
            now = backend.get_state()
            return {"width": now.width, "is_grasped": now.is_grasped}
    else:
        import franky_sim as franky
        from franky_sim.franka_gripper_server import FrankaGripperServer
        from franky_sim.run_server import load_simulator

        def counted(number, method):
            def call(self, *arguments):
                asked.append([number, [word for word in arguments if isinstance(word, float)]])
                return method(self, *arguments)

            return call

        for number, name in ((1, "start_homing"), (2, "start_grasp"), (3, "start_move"), (4, "stop")):
            setattr(FrankaGripperServer, name, counted(number, getattr(FrankaGripperServer, name)))
        simulator, _ = load_simulator("mujoco")
        simulation = simulator(enable_visualization=False).__enter__()
        robot = simulation.add_robot()
        server = franky.SimulationServer(simulation, hostname_candidates=[ADDRESS])
        server.__enter__()
        threading.Thread(target=server.run_forever, daemon=True).start()

        def state():
            return {"width": float(robot.hand_width), "is_grasped": False}

    print("ready", flush=True)
    for _ in sys.stdin:
        said, asked[:] = list(asked), []
        print(json.dumps({"asked": said, **state()}), flush=True)
    os._exit(0)


class Hand:
    """A hand in a process of its own."""

    def __init__(self, command):
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=ROOT, preexec_fn=urgent
        )
        while not self.line().startswith(("ready", "a hand at")):
            pass

    def line(self):
        line = self.process.stdout.readline()
        has(line, "the hand has ended")
        return line

    def seen(self):
        """What it was asked for since the last time, and where its fingers are."""
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        while True:
            line = self.line()
            if line.startswith("{"):
                return json.loads(line)

    def __enter__(self):
        # It binds its port when it has its model.
        time.sleep(1.0)
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        try:
            self.process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            self.process.kill()


def fake(*words):
    return Hand(["target/debug/examples/fake_hand", f"{ADDRESS}:1338", *words])


def simulated(name, *words):
    python = f"target/peers/{name}/bin/python"
    return Hand([python, str(HERE / "franka_hand.py"), "--serve", name, *words])


def own_client():
    """Franka's own client drives the hand of the driver's tests: it is one, as far as that client can tell."""
    import pylibfranka

    with fake("unhomed", f"part={PART}") as hand:
        client = pylibfranka.Gripper(ADDRESS)
        has(client.server_version() == 3, f"version {client.server_version()}")
        has(client.read_once().max_width == 0.0, "it is homed already")
        refused = False
        try:
            client.move(0.05, 0.1)
        except pylibfranka.CommandException:
            refused = True
        has(refused, "it moves before it is homed")
        has(client.homing(), "it was not homed")
        time.sleep(0.1)
        state = client.read_once()
        has(abs(state.max_width - 0.08) < 1e-12 and abs(state.width - 0.08) < 1e-12, f"homed: {state.width}, {state.max_width}")
        has(client.move(0.06, 0.1), "it did not move")
        time.sleep(0.1)
        has(abs(client.read_once().width - 0.06) < 1e-12, f"it moved to {client.read_once().width}")
        # The part is wider than the band allows, then as it says.
        has(not client.grasp(0.02, 0.1, 40.0), "it grasped what is too wide")
        has(client.move(0.06, 0.1), "it did not open")
        has(client.grasp(PART, 0.1, 40.0), "it did not grasp")
        time.sleep(0.1)
        state = client.read_once()
        has(state.is_grasped and abs(state.width - PART) < 1e-12, f"grasped: {state.is_grasped}, {state.width}")
        has(client.stop(), "it did not stop")
        time.sleep(0.1)
        has(not client.read_once().is_grasped, "a stop does not let go")
        for impossible in (lambda: client.move(0.09, 0.1), lambda: client.grasp(0.02, 0.1, 0.0)):
            refused = False
            try:
                impossible()
            except pylibfranka.CommandException:
                refused = True
            has(refused, "it does what it cannot")
        # Its calls keep the interpreter for themselves: a move that is held back cannot be stopped from another thread, and is not tried.
        del client
        asked = [REQUESTS[number] for number, _ in hand.seen()["asked"]]
    return ", ".join(asked)


def cell(times=1, homed=True):
    """What the cell says, and how it ended; None if it was refused."""
    file = ROOT / "robots/drivers/franka/examples/hand.toml"
    if not homed:
        text = file.read_text().replace("homed = true", "homed = false")
        file = ROOT / "target/peers/unhomed.toml"
        file.write_text(text)
    told = ROOT / "target/peers/hand.json"
    told.unlink(missing_ok=True)
    command = [ROOT / "target/debug/examples/hand", "--cell", file, "--processes", "--no-picture", "--outcome", told]
    done = subprocess.run([*command, "--", "--times", str(times)], capture_output=True, text=True, cwd=ROOT, timeout=120)
    said = done.stdout + done.stderr
    return said, None if done.returncode == 2 else Outcome(told, said)


def openings(said, what):
    """Where the fingers were by the program, and whether they held something."""
    found = re.findall(rf"{what}: (-?[0-9.]+) m, (true|false)", said)
    return [(float(width), held == "true") for width, held in found]


def whole(what, said, outcome):
    """Whether the cell ran to its end; if it did not, that is told."""
    has(outcome is not None, f"the cell was refused: {said}")
    if outcome.ended_well(controller=True):
        return True
    not_tested("hand", what, outcome)
    return False


def carried(hand, part, name, times=2):
    """Closed on a part and opened, by the driver in a cell."""
    said, outcome = cell(times)
    is_whole = whole(f"that {name} carries a part", said, outcome)
    time.sleep(0.3)
    seen = hand.seen()
    asked = [(REQUESTS[number], numbers) for number, numbers in seen["asked"]]
    # A machine that is late lets demands stand on their way: then there are more, and stops between them.
    moves = [numbers for request, numbers in asked if request == "move"]
    around, closed, opened = (openings(said, what) for what in ("around", "closed", "opened"))
    for width, held in around:
        has(abs(width - 0.05) < 1e-3 and not held, f"around the part: {width} m, {held}")
    for width, held in closed:
        has(held == (part is not None) and (part is None or abs(width - part) < 1e-3), f"closed: {width} m, {held}")
    for width, held in opened:
        has(abs(width - 0.07) < 1e-3 and not held, f"opened: {width} m, {held}")
    grasps = [numbers for request, numbers in asked if request == "grasp"]
    # Where a cell stops on its way, its fingers close to where they are demanded then.
    told = grasps if is_whole else grasps[:-1]
    has(all(numbers[1:] == [0.0, 0.08, 0.1, 40.0] for numbers in grasps), f"it grasps by {grasps}")
    has(all(numbers[0] == 0.01 for numbers in told[-1:]), f"it grasps by {grasps}")
    has("homing" not in [request for request, _ in asked], f"a hand that is homed was homed: {asked}")
    if is_whole:
        has(moves[-1] == [0.07, 0.1] and [0.05, 0.1] in moves, f"it was asked for {asked}")
        has(len(around) == len(closed) == len(opened) == times, f"the program says {said}")
        has(len(grasps) >= times, f"it was asked for {asked}")
        has(abs(seen["width"] - 0.07) < 1e-3 and not seen["is_grasped"], f"{name} ends at {seen}")
    return f"{[request for request, _ in asked]}, closed at {[width for width, _ in closed]} m"


def own_hand():
    """That hand with the driver in a cell: with a part, without one, and one that is not homed."""
    with fake(f"part={PART}") as hand:
        told = carried(hand, PART, "the hand")
    with fake() as hand:
        carried(hand, None, "the hand", 1)
    with fake("unhomed") as hand:
        said, outcome = cell()
        has(hand.seen()["asked"] == [], "a hand that is not homed was asked for something")
        if outcome is not None and outcome.is_late():
            not_tested("hand", "that a hand that is not homed is refused", outcome)
        else:
            has((outcome is None or outcome.kind) and "not homed" in said, f"a hand that is not homed was not refused: {outcome}: {said}")
        said, outcome = cell(homed=False)
        is_whole = whole("that a hand is homed, and used", said, outcome)
        asked = [number for number, _ in hand.seen()["asked"]]
        # What somebody else has begun is stopped first.
        has(asked[:2] == [4, 1][: len(asked)] and asked.count(1) <= 1, f"it was asked for {asked}")
        has(not is_whole or 3 in asked, f"it was asked for {asked}")
    return told


def of_franka_sim():
    with simulated("franka-sim", "--part", str(PART)) as hand:
        told = carried(hand, PART, "franka-sim")
    with simulated("franka-sim") as hand:
        carried(hand, None, "franka-sim", 1)
    return told


def of_franky_sim():
    """Its fingers have dynamics. A grasp that finds nothing it calls a failure, which is told as such."""
    with simulated("franky-sim") as hand:
        said, outcome = cell()
        time.sleep(0.3)
        seen = hand.seen()
        has(outcome is not None, f"the cell was refused: {said}")
        failed = outcome.kind == "RobotStopped" and "protective stop: grasp failed" in outcome.text
        if failed or whole("that the hand of franky-sim closes", said, outcome):
            moves = [numbers for number, numbers in seen["asked"] if number == 3]
            has([0.07, 0.1] in moves and [0.05, 0.1] in moves, f"it was asked for {seen['asked']}: {said}")
            has(len(openings(said, "around")) == 1, f"the program says {said}")
        for width, held in openings(said, "around"):
            has(abs(width - 0.05) < 1e-3 and not held, f"around: {width} m, {held}")
    return f"{seen['asked']}; {'its failed grasp was told' if failed else 'all done'}"


PARTS = {
    "Franka's own client with the hand of the tests": own_client,
    "the hand of the tests": own_hand,
    "the hand of franka-sim": of_franka_sim,
    "the hand of franky-sim": of_franky_sim,
}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--serve", choices=["franka-sim", "franky-sim"])
    parser.add_argument("--part", type=float)
    options = parser.parse_args()
    if options.serve:
        serve(options)
    well = True
    for name, part in PARTS.items():
        try:
            print(f"hand: {name}: {part()}", flush=True)
        except Shortfall as why:
            well = False
            print(f"hand: {name}: {why}", flush=True)
    sys.exit(0 if well else "hand: fell short")


if __name__ == "__main__":
    main()

"""The driver of Franka arms against franka-sim, which enforces the robot's limits, and against franky-sim.

Every part starts the example of the crate `mrroc-franka` as processes, in real time, and tests it by what the simulated robot saw. It
ends non-zero where anything falls short. Always: what the robot was told was within its limits, which franka-sim enforces, and the
arm comes to a standstill, unless this machine stood still for most of the time in which an arm may be told nothing. What a cell could
not show that a late machine ended is told by name.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent))
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
PYTHONS = {name: f"target/peers/{name}/bin/python" for name in ("franka-sim", "franky-sim")}
EXAMPLES = "robots/drivers/franka/examples"


# For how long a machine stands still that swallows most of an arm's 20 answers [s]: the simulator then tells a reflex by whatever it
# finds first, to Franka's own client as well.
STALL = 0.015


class Robot:
    """A simulated robot in a process of its own."""

    def __init__(self, simulator):
        self.process = subprocess.Popen(
            # They need different versions of the same packages.
            [str(ROOT / PYTHONS[simulator]), str(HERE / "franka_robot.py"), simulator],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=open(ROOT / "target/peers" / f"{simulator}.log", "w"),
            text=True,
        )
        # It answers when it has its model, a second or two later.
        self.seen()

    def seen(self, order=""):
        """What it saw since the last time."""
        self.process.stdin.write(order + "\n")
        self.process.stdin.flush()
        while True:
            line = self.process.stdout.readline()
            if not line:
                raise Shortfall("the simulator has ended")
            if line.startswith("{"):
                return json.loads(line)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait(timeout=20)


def other_cores():
    """Those that the simulator leaves alone, where there are more than one."""
    cores = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, cores[1:] or cores)


class Cell:
    """The example as processes."""

    def __init__(self, program, times, cell="cell", own=()):
        self.program = str(ROOT / "target" / program)
        self.file = ["--cell", str(ROOT / EXAMPLES / f"{cell}.toml")]
        self.outcome = ROOT / "target/peers/franka.json"
        self.outcome.unlink(missing_ok=True)
        options = ["--processes", "--no-picture", "--outcome", str(self.outcome), "--", "--times", str(times), *own]
        self.process = subprocess.Popen(
            [self.program, *self.file, *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=ROOT,
            start_new_session=True,
            preexec_fn=other_cores,
        )

    def console(self, *words):
        done = subprocess.run([self.program, *self.file, *words], capture_output=True, text=True, cwd=ROOT, timeout=30)
        return done.stdout + done.stderr

    def child(self, role):
        """The process of this role."""
        for entry in Path("/proc").iterdir():
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
                if b"\0".join(words).startswith(self.program.encode()) and all(word.encode() in words for word in role.split()):
                    return int(entry.name)
            except (OSError, IndexError):
                continue
        raise Shortfall(f"there is no process {role}")

    def end(self, timeout):
        """How it ended, its exit status, and what it said."""
        try:
            said, _ = self.process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            self.process.send_signal(signal.SIGINT)
            said, _ = self.process.communicate(timeout=30)
            raise Shortfall(f"it did not end within {timeout} s: {said}")
        status = self.process.returncode
        # One that was refused has not run.
        return None if status == 2 else Outcome(self.outcome, said), status, said


def stalled(outcome):
    """Whether the process that answers the robot stood still: what others of the cell wait for costs no answer."""
    return outcome.of("edp arm")["late"]["max"] > STALL


def stood_still(outcome, seen):
    """Whether the robot has stopped by itself when this machine stood still."""
    return outcome.kind == "RobotStopped" and bool(seen["reflexes"]) and stalled(outcome)


def ended_well(what, outcome, said, seen):
    """Whether the cell ran to its end; if it did not, that is told."""
    has(outcome is not None, f"the cell was refused: {said}")
    if not stood_still(outcome, seen) and outcome.ended_well(controller=True):
        return True
    not_tested("franka", f"{what}; reflexes {seen['reflexes']}", outcome)
    return False


def farthest(seen):
    return max(seen["range"], default=0.0)


def no_reflex(seen, outcome=None):
    """The arm came to a standstill by what it was told. A robot that has lost this machine stops by itself."""
    if outcome is not None and (stood_still(outcome, seen) or outcome.is_late(controller=True) and outcome.kind == "RobotStopped"):
        return
    if outcome is not None and stalled(outcome) and seen["reflexes"]:
        not_tested("franka", f"that the arm stops by what it is told; reflexes {seen['reflexes']}", outcome)
        return
    has(not seen["reflexes"], f"reflexes: {seen['reflexes']}: {outcome}")
    has(seen["end_speed"] < 1e-6, f"it ended at {seen['end_speed']} rad/s: {outcome}")


def own_client(robot):
    """Franka's own client moves the robot and reads where it was told to be: the simulated robot is one."""
    import pylibfranka

    robot.seen()
    try:
        own_motion(pylibfranka)
    except (pylibfranka.FrankaException, pylibfranka.ControlException) as why:
        # Its motion is a cosine of 1 Hz: where that is a reflex, the simulator has taken its answers late. Nothing of ours is tested here.
        reflexes = robot.seen()["reflexes"]
        has(reflexes, f"Franka's own client and the simulator do not understand each other: {why}")
        print(f"franka: not tested, for this machine was late: Franka's own client: {why}; reflexes {reflexes}")
        return "a reflex of its own client"
    time.sleep(0.5)
    seen = robot.seen()
    has(0.19 < seen["range"][3] < 0.21, f"it moved joint 4 by {seen['range'][3]} rad")
    no_reflex(seen)
    return f"{seen['told']} answers"


def own_motion(pylibfranka):
    import math

    client = pylibfranka.Robot("127.0.0.1", pylibfranka.RealtimeConfig.kIgnore)
    control = client.start_joint_position_control(pylibfranka.ControllerMode.JointImpedance)
    start, passed = None, 0.0
    while True:
        state, period = control.readOnce()
        passed += period.to_sec()
        start = start or list(state.q_d)
        positions = list(start)
        positions[3] += 0.1 * (1 - math.cos(2 * math.pi * min(passed, 1.0)))
        answer = pylibfranka.JointPositions(positions)
        answer.motion_finished = passed > 1.2
        control.writeOnce(answer)
        if passed > 1.2:
            return


def feeling(robot, simulator):
    """Franka's own client and the sensor of a cell read the same wrench. The simulators estimate none: all is zero, at any posture. So
    franka-sim, which packs its states by itself, is given numbers and frames to tell."""
    import math

    import pylibfranka

    def told():
        client = pylibfranka.Robot("127.0.0.1", pylibfranka.RealtimeConfig.kIgnore)
        state = client.read_once()
        del client
        time.sleep(0.5)
        return [list(value) for value in (state.F_T_EE, state.EE_T_K, state.K_F_ext_hat_K, state.O_F_ext_hat_K)]

    def felt():
        outcome, _, said = Cell("debug/examples/wrench", 2, cell="wrench").end(60)
        time.sleep(0.5)
        lines = [line for line in said.splitlines() if "on the tool:" in line]
        if not ended_well("what a cell feels", outcome, said, robot.seen()) and not lines:
            return None
        has(lines and (outcome.kind or len(lines) == 2), f"it felt nothing: {said}")
        return [float(word) for word in lines[-1].replace("N,", "").split() if word[-1].isdigit()]

    def columns(turn, axis, origin):
        """A pose by columns: a turn about an axis, and an origin."""
        c, s, (x, y, z) = math.cos(turn), math.sin(turn), axis
        v = 1 - c
        return [
            *(c + x * x * v, y * x * v + z * s, z * x * v - y * s, 0.0),
            *(x * y * v - z * s, c + y * y * v, z * y * v + x * s, 0.0),
            *(x * z * v + y * s, y * z * v - x * s, c + z * z * v, 0.0),
            *(*origin, 1.0),
        ]

    def placed(pose, point):
        return [sum(pose[4 * j + i] * point[j] for j in range(3)) + pose[12 + i] for i in range(3)]

    def turned(pose, vector):
        return [sum(pose[4 * j + i] * vector[j] for j in range(3)) for i in range(3)]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    robot.seen()
    *_, at_k, in_base = told()
    here = felt()
    has(not any(at_k + in_base + (here or [])), f"{simulator} tells a wrench now: {at_k}, {in_base}; the cell felt {here}")
    if simulator != "franka-sim":
        return "zero, as it tells"
    hand = columns(-0.785, (0.0, 0.0, 1.0), (0.0, 0.0, 0.1034))
    own = columns(0.7, (0.6, 0.0, 0.8), (0.02, -0.03, 0.05))
    told_k = [3.5, -7.25, 11.0, 0.25, 0.5, -0.875]
    robot.seen("feel " + json.dumps({"NE_T_EE": hand, "EE_T_K": own, "K_F_ext_hat_K": told_k}))
    try:
        flange_ee, ee_k, at_k, _ = told()
        here = felt()
    finally:
        robot.seen("feel {}")
    has(max(abs(a - b) for a, b in zip(flange_ee + ee_k + at_k, hand + own + told_k)) < 1e-6, f"its own client reads {at_k} at {flange_ee}, {ee_k}")
    # What the robot does to its surroundings at K, they do to it; from K's origin to that of the tool, 0.15 m before the flange.
    force, torque = ([-number for number in turned(flange_ee, turned(ee_k, at_k[i : i + 3]))] for i in (0, 3))
    x, y, z = placed(flange_ee, placed(ee_k, (0.0, 0.0, 0.0)))
    expected = force + [a + b for a, b in zip(torque, cross((x, y, z - 0.15), force))]
    if here is None:
        return "its own client reads what was told"
    off = max(abs(a - b) for a, b in zip(here, expected))
    has(off < 1e-4, f"the cell felt {here}, by its own client it is {expected}")
    return f"the same within {off:.0e} N, N m; of itself it tells zeros"


def example(robot, times):
    """To and fro, so many times."""
    robot.seen()
    outcome, _, said = Cell("debug/examples/franka", times).end(30 + 9 * times)
    time.sleep(0.5)
    seen = robot.seen()
    is_whole = ended_well("to and fro", outcome, said, seen)
    if seen["told"]:
        no_reflex(seen, outcome)
        # As the example has it, in libfranka's order: torques and forces, while the arm accelerates and while it does not.
        torques, forces = [20, 20, 18, 18, 16, 14, 12], [20, 20, 20, 25, 25, 25]
        has(seen["collision"] == 4 * torques + 4 * forces, f"collisions: it was told {seen['collision']}")
        has(seen["stiffness"] == [3000, 3000, 3000, 2500, 2500, 2000, 2000], f"it was told {seen['stiffness']}")
        # The hand and the pen of the example's cell, for this simulator tells no end effector: kg, m, kg m².
        has(seen["load"] == [1.03, -0.007, 0.0, 0.056] + 9 * [0.0], f"it was told to carry {seen['load']}")
        expected = [0.4, 0.2, 0.3, 0.4, 0.3, 0.3, 0.5]
        # Joints end where they began; the arm goes there first, from where it is.
        off = max(abs(a - b) for a, b in zip(seen["range"], expected))
        has(not is_whole or off < 0.01, f"joints moved by {seen['range']} rad")
    # Franka's own client reads where the robot was told to be last.
    import pylibfranka

    client = pylibfranka.Robot("127.0.0.1", pylibfranka.RealtimeConfig.kIgnore)
    q_d = list(client.read_once().q_d)
    del client
    time.sleep(0.5)
    robot.seen()
    if seen["told"] and is_whole:
        off = max(abs(a - b) for a, b in zip(q_d, seen["end"]))
        # The hold begins where the arm is, which is a little below where it was told to be.
        has(off < 5e-3, f"its own client reads {q_d}, it was told {seen['end']}")
    return f"{seen['told']} answers, up to {seen['fastest']:.3f} rad/s, {seen['largest_jerk']:.0f} rad/s³" if seen["told"] else "ended well"


# An end effector of Desk, and all that the flange carries by the cell: kg, m, kg m² by columns.
HAND = {"m_ee": 0.73, "F_x_Cee": [-0.01, 0.0, 0.03], "I_ee": [1e-3, 0.0, 0.0, 0.0, 2.5e-3, 0.0, 0.0, 0.0, 1.7e-3]}
WHOLE = (1.1, [0.005, 0.0, 0.05], [3e-3, 0.0, -7e-4, 0.0, 5e-3, 0.0, -7e-4, 0.0, 3e-3])
PEN = (0.3, [0.0, 0.0, 0.12], [4e-4, 0.0, 0.0, 0.0, 4e-4, 0.0, 0.0, 0.0, 5e-5])


def cell_that_carries(mass, centre, inertia):
    """The example's cell with a tool of this mass, centre and inertia; its path without the suffix."""
    xx, xy, xz, _, yy, yz, _, _, zz = inertia
    text = (ROOT / EXAMPLES / "cell.toml").read_text().split("[tools.pen]")[0]
    text += f"[tools.pen]\nxyz = [0.0, 0.0, 0.15]\nmass = {mass}\ncentre = {centre}\ninertia = {[xx, xy, xz, yy, yz, zz]}\n"
    file = ROOT / "target/peers/carrying.toml"
    file.write_text(text)
    return str(file.with_suffix(""))


def carrying(robot):
    """franka-sim tells an end effector. What the cell's driver tells besides, Franka's own client adds to it: all that the cell says."""
    import pylibfranka

    mass, centre, inertia = WHOLE
    robot.seen("feel " + json.dumps(HAND))
    try:
        # A pen alone is less than this hand.
        _, status, said = Cell("debug/examples/franka", 1, cell=cell_that_carries(*PEN)).end(60)
        time.sleep(0.5)
        seen = robot.seen()
        has(status == 1 and "less by the cell than the end effector" in said, f"it ended with {status}: {said}")
        has(seen["load"] is None and seen["motions"] == 0, f"it was told to carry {seen['load']}, and moved {seen['motions']} times")
        outcome, _, said = Cell("debug/examples/franka", 1, cell=cell_that_carries(*WHOLE)).end(60)
        time.sleep(0.5)
        seen = robot.seen()
        load = seen["load"]
        # What a late machine does to its motion is another matter.
        if load is None:
            has(not ended_well("the load", outcome, said, seen), "it was told nothing of its load")
            return "the cell ended before it told its load"
        robot.seen("feel " + json.dumps({**HAND, "m_load": load[0], "F_x_Cload": load[1:4], "I_load": load[4:]}))
        client = pylibfranka.Robot("127.0.0.1", pylibfranka.RealtimeConfig.kIgnore)
        state = client.read_once()
        total = [state.m_total, *state.F_x_Ctotal, *state.I_total]
        del client
        time.sleep(0.5)
    finally:
        robot.seen("feel {}")
    off = max(abs(a - b) for a, b in zip(total, [mass, *centre, *inertia]))
    has(off < 1e-6, f"told {load}; by its own client that is {total} with the hand")
    return f"{load[0]:.2f} kg besides the hand; with it the same within {off:.0e} kg, m, kg m²"


def lost(robot, answers):
    """So many answers in a row do not come, again and again: 20 are a reflex, and told as what they are."""
    robot.seen(f"drop {answers}")
    outcome, _, said = Cell("debug/examples/franka", 1).end(60)
    time.sleep(0.5)
    seen = robot.seen("drop 0")
    if answers < 20:
        # Answers of this machine that are late beside those that are dropped make a reflex of 19, and of less.
        is_whole = ended_well(f"{answers} lost answers", outcome, said, seen)
        no_reflex(seen, outcome)
        has(not is_whole or seen["gaps"] >= 3, f"only {seen['gaps']} gaps")
        return f"{seen['gaps']} gaps, {seen['dropped']} lost"
    has(outcome is not None, f"the cell was refused: {said}")
    if not outcome.ended_by("RobotStopped", "communication_constraints_violation", controller=True):
        not_tested("franka", "what is told of 20 lost answers", outcome)
        return f"{seen['gaps']} gaps"
    has(seen["gaps"] > 0 or stalled(outcome), f"a reflex without a gap: {outcome}")
    has(len(seen["reflexes"]) == 1, f"reflexes: {seen['reflexes']}")
    return "told as communication_constraints_violation"


def engraving(robot, strokes, cycles):
    """The nameplate, so many strokes of it. For at least so many cycles it is engraved again and again, whether a run came to its end or a late
    machine ended it: what a robot was told until then, it was told in time. Runs are counted by how they ended."""
    told = fastest = jerk = runs = ended = 0
    while told < max(cycles, 1):
        robot.seen()
        outcome, _, said = Cell("debug/examples/engrave", 1, own=["--strokes", str(strokes)]).end(120 + cycles / 100)
        time.sleep(0.5)
        seen = robot.seen()
        ended += not ended_well("an engraving to its end", outcome, said, seen)
        if not seen["told"]:
            return "ended well" if outcome.kind is None else str(outcome)
        no_reflex(seen, outcome)
        runs, told = runs + 1, told + seen["told"]
        fastest, jerk = max(fastest, seen["fastest"]), max(jerk, seen["largest_jerk"])
    return f"{told} answers in {runs} runs, {ended} ended by a late machine, up to {fastest:.3f} rad/s, {jerk:.0f} rad/s³"


# How a cell is stopped, and what then ends it.
ENDS = {
    "suspend": [None, "Aborted"],
    "abort": [None, "Aborted"],
    "protective stop": ["ProtectiveStop"],
    "fault stop": ["PeerLost"],
    "mp killed": ["PeerLost"],
}


def stopped(robot, how, draw):
    """The robot comes to a standstill, and to no reflex."""
    robot.seen()
    cell = Cell("debug/examples/franka", 40)
    # Longer than the processes take to begin; then anywhere on the way to or fro.
    time.sleep(2.0 + draw.uniform(0.0, 3.0))
    said = ""
    if cell.process.poll() is not None:
        return before_stop(robot, how, cell)
    if how == "suspend":
        said = cell.console("suspend")
        time.sleep(1.5)
        seen = robot.seen()
        has(farthest(seen) > 1e-3, f"it did not move: {said}")
        time.sleep(0.3)
        held = robot.seen()
        if cell.process.poll() is not None:
            return before_stop(robot, how, cell)
        no_reflex(seen)
        has(farthest(held) < 1e-4 and held["told"] > 100, f"it is not held: {said} {held}")
        said += cell.console("resume")
        time.sleep(draw.uniform(0.5, 1.5))
        if cell.process.poll() is not None:
            return before_stop(robot, how, cell)
        has(farthest(robot.seen()) > 1e-3, f"it does not go on: {said}")
        cell.console("abort")
    elif how == "abort":
        said = cell.console("abort")
    elif how == "protective stop":
        said = cell.console("stop")
    elif how == "fault stop":
        os.kill(cell.child("ecp arm"), signal.SIGKILL)
    elif how == "mp killed":
        os.kill(cell.child("mp"), signal.SIGKILL)
    outcome, status, ended = cell.end(30)
    time.sleep(0.5)
    seen = robot.seen()
    has(outcome is not None, f"the cell was refused: {ended}")
    no_reflex(seen, outcome)
    has(seen["told"] > 100 or outcome.is_late(controller=True), f"it did not run: {said} {ended}")
    has(status != 0 or how in ("abort", "suspend"), f"it ended well: {said} {ended}")
    # What was done to it, or lateness.
    if outcome.kind not in ENDS[how]:
        has(stood_still(outcome, seen) or outcome.is_late(controller=True), f"it ended by {outcome}: {said}")
    return f"standstill, {outcome.kind}"


def before_stop(robot, how, cell):
    """The cell has ended before it was stopped."""
    outcome, _, said = cell.end(10)
    time.sleep(0.5)
    seen = robot.seen()
    has(not ended_well(f"a stop by {how}", outcome, said, seen), f"it ended well before it was stopped: {said}")
    no_reflex(seen, outcome)
    return "ended before it was stopped"


def reported(name, part, *arguments):
    """Whether nothing falls short."""
    began = time.monotonic()
    try:
        print(f"franka: {name}: {part(*arguments)} ({time.monotonic() - began:.0f} s)", flush=True)
        return True
    except Shortfall as why:
        print(f"franka: {name}: {why}", flush=True)
        return False


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--times", type=int, default=1, help="to and fro, 5000 cycles each")
    parser.add_argument("--lost", default="1,19,20", help="answers that are lost in a row")
    parser.add_argument("--stops", type=int, default=1, help="stops of each kind")
    parser.add_argument("--strokes", type=int, default=1, help="strokes of the nameplate")
    parser.add_argument("--cycles", type=int, default=1, help="at least so many cycles of engraving")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    options = parser.parse_args()
    print(f"franka: seed {options.seed}")
    draw = random.Random(options.seed)
    well = True
    with Robot("franka-sim") as robot:
        well &= reported("Franka's own client", own_client, robot)
        well &= reported("wrench", feeling, robot, "franka-sim")
        well &= reported("to and fro", example, robot, options.times)
        well &= reported("load", carrying, robot)
        well &= reported("engraving", engraving, robot, options.strokes, options.cycles)
        for answers in map(int, filter(None, options.lost.split(","))):
            well &= reported(f"{answers} lost", lost, robot, answers)
        for number in range(options.stops):
            for how in ENDS:
                well &= reported(f"{how} {number + 1}", stopped, robot, how, draw)
    with Robot("franky-sim") as robot:
        well &= reported("wrench of franky-sim", feeling, robot, "franky-sim")
        well &= reported("to and fro on franky-sim", example, robot, options.times)
        well &= reported("engraving on franky-sim", engraving, robot, options.strokes, options.cycles)
    sys.exit(0 if well else "franka: fell short")


if __name__ == "__main__":
    main()

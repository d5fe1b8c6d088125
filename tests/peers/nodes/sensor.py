"""A cell whose sensor is a Python program on another machine: in a network namespace of its own, where this machine permits that with a
clock of its own (a day ahead), behind a wire that delays packets by up to 2 ms; on loopback else. The program is PyPI's zenoh.

In: the example `camera`, built. Out: exit status 0 if the readings that the cell read are those that were sent, to the bit, none of
them younger than it is, and if the robot stood within its bound after each end of them, longer by the steps that the cell left out. What a
cell could not show that a late machine ended is told by name. `--long` has all cases.
"""

import math
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
sys.path.append(str(HERE.parent))
from ending import until_interrupted  # noqa: E402
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402
from device_priority import urgent  # noqa: E402
from wire import Bad, Cut, Namespace, Wire, arguments, begin_in_namespace, is_in_namespace  # noqa: E402

PROGRAM = ROOT / "target/debug/examples/camera"
STEP = 0.004
STALE = 25  # steps: 100 ms
# The joint that moves, at 0.5 rad/s: its braking time at 7 rad/s² is 0.214 s by `--check`.
BRAKING = 54
# Of the EDP, in steps.
DELAY = 1
# So long a cell of two seconds reads a program before something happens to that [s].
AFTER = 0.7
# How much further the clock of the other machine is [s].
AHEAD = 86400
# The longest way of a packet on the wire, each way [s].
WAY = 0.002


def program(mode, log):
    """The program of another, in a process of its own on the other machine."""
    import camera_port as port

    urgent()
    rng = random.Random(7)
    try:
        with port.Port() as ends, open(log, "w", buffering=1) as sent:
            if mode == "rival":
                sent.write("\n")
                while not any(line.endswith(" 1") for line in Path(log).with_name("plain.sent").read_text().splitlines()):
                    time.sleep(0.02)
            began, heard, hiccup = time.monotonic(), None, False
            while True:
                heard = time.monotonic() if heard is None and ends._came is not None else heard
                # It goes wrong when the cell has read it for a while.
                reads = time.monotonic() - (heard or time.monotonic())
                now, wall, t = time.monotonic_ns(), time.time_ns(), time.monotonic() - began
                # Noise in every bit, slower than 2 rad/s.
                reading = port.Reading(0.2 * math.sin(t) + 1e-3 * rng.random(), True)
                if reads > AFTER and mode == "hiccup" and not hiccup:
                    hiccup = True
                    time.sleep(0.2)
                order = ends.order()
                if reads > AFTER and mode == "other size":
                    ends._readings.put(struct.pack("<QQQ", ends._program, *ends._newest()) + bytes(100))
                else:
                    bad = reads > AFTER and mode == "other version"
                    port.VERSION += bad
                    ends.send(reading, now, order)
                    port.VERSION -= bad
                sent.write(f"{bits(reading.direction)} {wall} {ends._came is not None:d}\n")
                time.sleep(max(0.0, 1 / port.RATE_HZ - (time.monotonic_ns() - now) / 1e9))
    except (port.SecondWriter, port.OtherMessages, OSError) as error:
        print(error)
        raise SystemExit(3) from None


class Bench:
    """A machine with the cell, and one with the program: a folder each."""

    def __init__(self):
        self.folder = Path(tempfile.mkdtemp(prefix="mrn"))
        self.wire, self.namespaces, self.clock, address = None, [None, None], 0, "127.0.0.1"
        if is_in_namespace():
            address = "10.79.0.1"
            self.wire = Wire(1)
            self.wire.way = Bad(0.0, WAY)
            self.namespaces = [Namespace("wire0", address, "10.79.0.2"), Namespace("wire1", "10.79.0.2", address)]
            self.wire.start()
            own_clock = subprocess.run(["unshare", "-T", "--monotonic", str(AHEAD), "--fork", "true"], capture_output=True)
            self.clock = AHEAD if own_clock.returncode == 0 else 0
        for name in ("cell", "there", "stranger"):
            (self.folder / name).mkdir()
        text = (ROOT / "ports/external/examples/cell.toml").read_text().replace("step_ms = 2", f"step_ms = {STEP * 1e3:.0f}")
        self.cell_file = self.folder / "cell/cell.toml"
        self.cell_file.write_text(text.replace("rate_hz", f'address = "{address}:7449"\nrate_hz'))
        self.certify("keys")
        shutil.copytree(self.folder / "keys/cell", self.folder / "cell/certificates")
        module = self.ask("external", "camera")
        for name, keys in (("there", "keys"), ("stranger", "others")):
            if name == "stranger":
                self.certify(keys)
            (self.folder / name / "camera_port.py").write_bytes(module)
            shutil.copytree(self.folder / keys / "sensor.camera", self.folder / name / "certificates")

    def ask(self, *words):
        done = subprocess.run([PROGRAM, "--cell", self.cell_file, *words], capture_output=True)
        has(done.returncode == 0, f"{words}: {done.stderr.decode()}")
        return done.stdout

    def certify(self, folder):
        self.ask("certificates", self.folder / folder)

    def within(self, place, *command):
        return self.namespaces[place].within(*command) if self.namespaces[place] else list(command)

    def program(self, mode, home="there"):
        """The program; when it returns it has begun to send."""
        log = self.folder / f"{mode}.sent"
        log.unlink(missing_ok=True)
        clock = ["unshare", "-T", "--monotonic", str(self.clock), "--fork", "--kill-child=KILL"] if self.clock else []
        command = self.within(1, *clock, sys.executable, __file__, "program", mode, str(log))
        environment = {**os.environ, "PYTHONPATH": str(self.folder / home)}
        process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
        while process.poll() is None and not (log.exists() and log.stat().st_size):
            time.sleep(0.01)
        return process

    def cell(self):
        command = [PROGRAM, "--cell", self.cell_file, "--processes", "--no-picture", "--outcome", self.folder / "outcome.json"]
        command = self.within(0, *command, "--", "--seconds", "2", "--trace", self.folder / "trace")
        environment = {**os.environ, "MRROC_PORTS": str(self.folder / "ports")}
        shutil.rmtree(self.folder / "trace", ignore_errors=True)
        (self.folder / "trace").mkdir()
        return subprocess.Popen([str(word) for word in command], env=environment, cwd=self.folder, stderr=subprocess.PIPE, text=True)

    def close(self):
        if self.wire:
            self.wire.ended = True
            self.wire.join()
            for namespace in self.namespaces:
                namespace.close()
        shutil.rmtree(self.folder)


def end(process):
    """Ends a program at once: it is on a machine that nobody tidies."""
    if process.poll() is None:
        process.kill()
    process.wait(timeout=30)


def ended(running, bench):
    _, said = running.communicate(timeout=60)
    return Outcome(bench.folder / "outcome.json", said)


def bits(number):
    return struct.pack(">d", number).hex()


class Run:
    """What the cell wrote down."""

    def __init__(self, bench):
        def rows(name, form):
            file = bench.folder / "trace" / name
            bytes = file.read_bytes() if file.exists() else b""
            return [row for row in struct.iter_unpack(form, bytes[: len(bytes) // struct.calcsize(form) * struct.calcsize(form)])]

        # Of each step of the Move: when it was by the wall clock [ns], how old the reading was [steps], and its bits.
        self.readings = [(now, age, f"{word:016x}") for now, age, word in rows("readings", "<QQQ")]
        self.demands = rows("demands", "<dd")

    def last_motion(self):
        """The last step in which the demand changed."""
        pairs = zip(self.demands, self.demands[1:])
        return max((round(after[0] / STEP) for before, after in pairs if before[1] != after[1]), default=0)


def sent(bench, mode):
    """What was sent once the cell was there: the bits, and when it was measured by the wall clock, which both machines share [ns]."""
    lines = [line.split() for line in (bench.folder / f"{mode}.sent").read_text().splitlines()]
    return {word: int(at) for word, at, heard in lines if heard == "1"}


def nothing_left(bench):
    left = [path for path in (bench.folder / "ports").rglob("*") if path.is_file()]
    has(not left, f"files are left: {left}")
    for entry in Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes()
        except OSError:
            continue
        has(not (b"\0gateway\0" in words and str(bench.cell_file).encode() in words), f"a gateway is left: {words}")


def equal(bench):
    """Readings are those that were sent; a second program, and one with a certificate of another authority, disturb nothing."""
    first, stranger, second = bench.program("plain"), bench.program("stranger", home="stranger"), bench.program("rival")
    try:
        running = bench.cell()
        outcome = ended(running, bench)
        # A program in Python that is late makes a stale sensor.
        is_whole = outcome.kind != "SensorStale" and outcome.ended_well()
        has(stranger.poll() is None, "the stranger has ended")
        try:
            told, _ = second.communicate(timeout=3)
        except subprocess.TimeoutExpired:
            told = "nothing"
    finally:
        for process in (first, stranger, second):
            end(process)
    is_refused = told != "nothing" or bool(sent(bench, "rival"))
    if not is_refused:
        not_tested("sensor elsewhere", "that a second program is refused, which did not reach the cell", outcome)
    has(not is_refused or second.returncode == 3 and "another program sends" in told, f"a second program was let in: {told}")
    has(not sent(bench, "stranger"), "who has a certificate of another authority has got an order")
    run, wrote = Run(bench), sent(bench, "plain")
    read = {word for _, _, word in run.readings}
    has(read <= set(wrote), "a reading was never sent")
    if not is_whole:
        not_tested("sensor elsewhere", "that it reads until its end", outcome)
    has(not is_whole or len(read) > 20, f"{len(read)} readings")
    places = [list(wrote).index(word) for word in dict.fromkeys(word for _, _, word in run.readings)]
    has(places == sorted(places), "a reading came after a later one")
    if not read:
        return
    # How much older each counted in each step than it was when that step had it. It was taken up to a step before that.
    older = sorted(age * STEP - (now - wrote[word]) / 1e9 for now, age, word in run.readings)
    least, middle = older[len(older) // 20], older[len(older) // 2]
    what = f"readings count as {least * 1e3:.1f} to {middle * 1e3:.1f} ms older than they are"
    if is_whole:
        # What it is older by is known to a step, and to what kept the cell from looking.
        has(least >= -0.01 - outcome.longest_stall and middle <= 0.05 + outcome.longest_stall, what)
    else:
        not_tested("sensor elsewhere", what, outcome)
    clock = f"{bench.clock} s apart" if bench.clock else "one for both"
    print(
        f"sensor elsewhere: {len(read)} readings equal to the bit, clocks {clock}; they count as {middle * 1e3:.1f} ms older than they are (half), "
        f"{least * 1e3:.1f} ms (5 %); oldest {max(age for _, age, _ in run.readings)} steps; a second program and a stranger were refused"
    )


def stopped(bench, mode, kind, told, kill=False, cut=False):
    """The readings end in some way, and the robot with them."""
    name = "kill -9" if kill else "cable pulled" if cut else mode
    python = bench.program("plain" if kill or cut else mode)
    try:
        running = bench.cell()
        if kill or cut:
            while running.poll() is None and not sent(bench, "plain"):
                time.sleep(0.02)
            time.sleep(AFTER)
        if kill:
            python.kill()
        if cut:
            bench.wire.way = Cut()
        outcome = ended(running, bench)
    finally:
        end(python)
        if bench.wire:
            bench.wire.way = Bad(0.0, WAY)
    # A program that is late makes a stale sensor of any.
    is_told = (outcome.kind == kind or outcome.kind != "SensorStale") and outcome.ended_by(kind, told)
    if not is_told:
        not_tested("sensor elsewhere", f"how a sensor ends that ends by {name}", outcome)
    run = Run(bench)
    oldest = max((age for _, age, _ in run.readings), default=0)
    has(oldest <= STALE, f"{name}: it moved by a reading of {oldest} steps, at most {STALE} are allowed")
    at = outcome.steps if outcome.step is None else outcome.step
    # For as many steps as the cell left out robots go on as before.
    moved, bound = run.last_motion() - at, 1 + BRAKING + 2 * DELAY + outcome.skipped
    has(moved <= bound, f"{name}: it moved for {moved} steps after its fault, at most {bound} are allowed")
    print(
        f"sensor elsewhere: {name}: the last demand that moved came {moved} of {bound} steps after the fault, which came with a reading "
        f"of at most {STALE} + 1 steps"
    )


def main():
    is_long = "--long" in arguments()
    begin_in_namespace()
    cases = {
        "equal": equal,
        "kill -9": lambda bench: stopped(bench, "plain", "SensorStale", "too old", kill=True),
        "other size": lambda bench: stopped(bench, "other size", "SensorFailed", "another version of the port"),
        "cable pulled": lambda bench: stopped(bench, "plain", "SensorStale", "too old", cut=True),
        "hiccup": lambda bench: stopped(bench, "hiccup", "SensorStale", "too old"),
        "other version": lambda bench: stopped(bench, "other version", "SensorFailed", "another version of the port"),
    }
    short = ["equal", "kill -9", "other size"]
    bench = Bench()
    try:
        for name in cases if is_long else short:
            if name == "cable pulled" and not bench.wire:
                print("sensor elsewhere: cable pulled: skipped: no namespaces")
                continue
            cases[name](bench)
            nothing_left(bench)
    except Shortfall as shortfall:
        sys.exit(f"nodes: {shortfall}")
    finally:
        bench.close()


if __name__ == "__main__":
    if sys.argv[1:2] == ["program"]:
        until_interrupted(program, *sys.argv[2:])
    else:
        main()

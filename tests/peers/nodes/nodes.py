"""The two-arm transfer with one arm on another machine: in two network namespaces, joined by a wire of this process, or on loopback
where this machine permits no namespaces.

It ends with anything else but 0 where a cell on two machines does not do what it should. Both keep real time: what a cell could not show
that a late machine ended is told by name. What robots were demanded, each robot's process writes down; that of a run under the virtual
clock on one machine says where the arms must come to.
"""

import argparse
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
sys.path.append(str(HERE.parent))
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402
from wire import Bad, Clear, Cut, Namespace, Wire, arguments, begin_in_namespace, is_in_namespace  # noqa: E402

PROGRAM = ROOT / "target/debug/examples/transfer"
JOINTS = {"rnt": 6, "polycrank": 7}
# Loose motions, and the whole transfer with its tight ones, which bridge one step of 20 ms: in steps that a busy machine keeps [s].
STEP, LONG_STEP = 0.004, 0.02
# The longest stop that the cell allows any joint [s].
STOP = 0.6


class Bench:
    """Two machines: a folder each, with a cell file, certificates and a copy of the program."""

    def __init__(self, seed, is_long):
        self.is_long = is_long  # all cuts and wires
        self.folder = Path(tempfile.mkdtemp())
        self.wire = None
        self.addresses = ["127.0.0.1", "127.0.0.1"]
        self.namespaces = [None, None]
        self.traced = 0
        if is_in_namespace():
            self.addresses = ["10.78.0.1", "10.78.0.2"]
            self.wire = Wire(seed)
            self.namespaces = [
                Namespace("wire0", self.addresses[0], self.addresses[1]),
                Namespace("wire1", self.addresses[1], self.addresses[0]),
            ]
            self.wire.start()
        for name in "ab":
            (self.folder / name).mkdir()
            shutil.copy(PROGRAM, self.folder / name / "program")
        self.set_step(STEP)
        self.certify("keys")
        for name in "ab":
            shutil.copytree(self.folder / "keys" / name, self.folder / name / "certificates")

    def cell(self):
        """The transfer's own, in steps that a busy machine keeps, with Polycrank and its hand on node b."""
        text = (ROOT / "tasks/transfer/cell.toml").read_text()
        text = text.replace("step_ms = 2", f"step_ms = {self.step * 1e3:.0f}")
        for robot in ("polycrank", "polycrank-hand"):
            text = text.replace(f"[robots.{robot}]\n", f'[robots.{robot}]\nnode = "b"\n')
        # On two machines in one no process waits for the core of another one.
        text = text.replace('permission = "best effort"', 'permission = "best effort"\ncores = []')
        return text + (
            f'\n[nodes.a]\naddress = "{self.addresses[0]}:7447"\nmp = true\n\n[nodes.b]\naddress = "{self.addresses[1]}:7448"\n'
        )

    def set_step(self, step):
        self.step = step
        for name in "ab":
            (self.folder / name / "cell.toml").write_text(self.cell())

    def certify(self, folder):
        done = subprocess.run(
            [self.folder / "a/program", "--cell", self.folder / "a/cell.toml", "certificates", self.folder / folder],
            capture_output=True,
            text=True,
        )
        has(done.returncode == 0, f"no certificates: {done.stderr}")

    def way(self, way):
        if self.wire:
            self.wire.way = way

    def start(self, name, *words, home=None, loose=None, trace="trace"):
        """The program on a machine, in a session of its own for Ctrl-C, with its words in a file."""
        home = home or name
        place = "ab".index(name)
        command = [str(self.folder / home / "program"), "--cell", str(self.folder / home / "cell.toml"), "--no-picture", *words]
        trace = self.folder / trace
        trace.mkdir(exist_ok=True)
        command += ["--", "--trace", str(trace), *(["--loose", str(loose)] if loose else [])]
        if self.namespaces[place]:
            command = self.namespaces[place].within(*command)
        self.traced += 1
        log = self.folder / f"{self.traced}.log"
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=log.open("w"),
            stderr=subprocess.STDOUT,
        )
        process.log = log
        return process

    def node(self, **how):
        process = self.start("b", "node", "b", **how)
        for _ in range(1200):
            if "waits at" in process.log.read_text() or process.poll() is not None:
                return process
            time.sleep(0.05)
        raise Shortfall("node b does not begin to wait")

    def run(self, **how):
        shutil.rmtree(self.folder / "trace", ignore_errors=True)
        self.outcome_file.unlink(missing_ok=True)
        return self.start("a", "--processes", "--outcome", str(self.outcome_file), **how)

    @property
    def outcome_file(self):
        return self.folder / "outcome.json"

    def trace(self, robot):
        """Of every servo period: the time [s], and what was demanded."""
        file = self.folder / "trace" / f"{robot}.trace"
        if not file.exists():
            return []
        bytes, width = file.read_bytes(), 8 * (1 + JOINTS[robot])
        rows = [struct.unpack_from(f"<{width // 8}d", bytes, at) for at in range(0, len(bytes) - width + 1, width)]
        return [(row[0], row[1:]) for row in rows]

    def close(self):
        if self.wire:
            self.wire.ended = True
            self.wire.join()
            for namespace in self.namespaces:
                namespace.close()
        shutil.rmtree(self.folder)


def ended(process, seconds=90):
    """How it ended, and what it said."""
    try:
        status = process.wait(seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        raise Shortfall(f"it goes on after {seconds} s: {process.log.read_text()}") from None
    return status, process.log.read_text()


def outcome_of(bench, cell, seconds=90):
    """How a cell ended that was not refused, and what it said."""
    status, words = ended(cell, seconds)
    has(status in (0, 1), f"it ended with {status}: {words}")
    return Outcome(bench.outcome_file, words), words


def end(process):
    """Ends an agent; its processes end with it."""
    if process.poll() is None:
        process.send_signal(signal.SIGTERM)
        process.wait(20)


def moved(trace):
    """When it moved last [s]; None if it never did."""
    times = [b[0] for a, b in zip(trace, trace[1:]) if any(abs(p - q) > 1e-9 for p, q in zip(a[1], b[1]))]
    return times[-1] if times else None


def where(trace):
    return trace[-1][1]


def members(bench):
    """The words with which each process of a session of this bench was started."""
    for entry in Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
        except (OSError, ValueError):
            continue
        if str(bench.folder).encode() in b" ".join(words) and b"--session" in words:
            yield words


def left(bench):
    """Processes of this bench, besides those that it started itself."""
    return [b" ".join(words[1:4]).decode() for words in members(bench)]


def segments_of(folders):
    """The shared memory of these sessions."""
    prefixes = tuple(f"mrroc_{Path(folder).name.partition('-')[2]}_" for folder in folders)
    return sorted(path.name for path in Path("/dev/shm").iterdir() if path.name.startswith(prefixes))


def sessions(bench):
    """The folders of the sessions that processes of this bench are in."""
    return {words[words.index(b"--session") + 1].decode() for words in members(bench)}


def nothing_left(bench):
    for _ in range(200):
        if not left(bench):
            return
        time.sleep(0.1)
    raise Shortfall(f"processes are left: {left(bench)}")


def as_on_one_machine(bench, **how):
    """Where the arms come to on one machine under the virtual clock."""
    shutil.rmtree(bench.folder / "trace", ignore_errors=True)
    status, words = ended(bench.start("a", **how))
    has(status == 0, f"the task does not end well on one machine: {words}")
    return {robot: where(bench.trace(robot)) for robot in JOINTS}


def compared(bench, expected):
    off = max(abs(p - q) for robot in JOINTS for p, q in zip(where(bench.trace(robot)), expected[robot]))
    has(off < 1e-9, f"the arms end {off:.1e} rad from where they should")
    return off


def reaches_its_end(bench):
    """Tight and loose motions over a wire that does nothing, and a second run with the same agent."""
    bench.set_step(LONG_STEP)
    expected = as_on_one_machine(bench)
    node = bench.node()
    try:
        outcome, _ = outcome_of(bench, bench.run())
        is_whole = outcome.ended_well()
        nothing_left(bench)
        if not is_whole:
            not_tested("nodes", "that the transfer on two machines comes to its end", outcome)
            return
        off = compared(bench, expected)
        told = said(node)
        has(len(told) == 1, f"the node tells nothing of its link: {node.log.read_text()}")
        print(f"transfer on two machines: at its end, {off:.1e} rad off; {told[0].removeprefix('note: ')}")
    finally:
        end(node)


def said(node):
    """What the node says of its link at the end of a run."""
    for _ in range(100):
        told = [line for line in node.log.read_text().splitlines() if "round trip" in line]
        if told:
            break
        time.sleep(0.1)
    return told


def cable_pulled(bench):
    """While both arms move: both come to a standstill, each side says who is lost, and nothing moves when the cable is back."""
    if not bench.wire:
        print("cable pulled: skipped: no namespaces")
        return
    tight = [(after, None) for after in ((8.5, 9.2, 10.0, 12.0, 14.0, 16.0) if bench.is_long else (9.2,))]
    loose = [(after, 6) for after in ((0.7, 2.0, 2.7, 3.3, 5.1) if bench.is_long else (2.0,))]
    for after, turns in tight + loose:
        bench.set_step(STEP if turns else LONG_STEP)
        node = bench.node(loose=turns)
        try:
            pull(bench, node, after, turns)
        finally:
            bench.way(Clear())
            end(node)


def pull(bench, node, after, turns):
    """Pulls the cable so long [s] after the cell's time began."""
    cell = bench.run(loose=turns)
    begun = begins(bench, cell)
    time.sleep(max(0.0, begun + after - time.monotonic()))
    bench.way(Cut())
    outcome, words = outcome_of(bench, cell)
    took = time.monotonic() - begun - after
    # A link that is down is a process that is gone.
    has(not outcome.ended_well(), f"a cell without its cable ended well: {words}")
    nothing_left(bench)
    here = node.log.read_text()
    rest = {robot: moved(bench.trace(robot)) or 0.0 for robot in JOINTS}
    # L = ceil(20 ms / Ts) steps, one more, and the stop; what this process needed to pull the cable; and steps that were left out.
    bound = 0.02 + 2 * bench.step + STOP + 0.25 + outcome.longest_stall + outcome.skipped * bench.step
    has(max(rest.values()) - after <= bound, f"an arm moves for {max(rest.values()) - after:.3f} s, {bound:.3f} s allowed")
    if min(rest.values()) < after - 0.3:
        not_tested("nodes", f"what is told of a cable that is pulled after {after} s, before which it stopped ({rest})", outcome)
    else:
        has("polycrank" in words or "node b" in words, f"nobody says what is lost: {words}")
        has("node a is lost" in here, f"node b does not say that node a is lost: {here}")
    bench.way(Clear())
    time.sleep(1.0)
    again = {robot: moved(bench.trace(robot)) or 0.0 for robot in JOINTS}
    has(again == rest and not left(bench), "something moves when the cable is back")
    has(node.poll() is None, "the agent has ended with the cable")
    print(
        f"cable pulled after {after} s: rnt stands {rest['rnt'] - after:.3f} s later, polycrank {rest['polycrank'] - after:.3f} s; the "
        f"cell has ended {took:.1f} s later"
    )
    if took > 5.0:
        print(words)


def begins(bench, cell):
    """When the cell's time began, by the first servo periods that were written down; or when it had ended."""
    for _ in range(3000):
        trace = bench.trace("rnt")
        if trace or cell.poll() is not None:
            # The file is written in blocks; its last period has just been.
            return time.monotonic() - (trace[-1][0] if trace else 0.0)
        time.sleep(0.02)
    raise Shortfall(f"the cell does not begin: {cell.log.read_text()}")


def bad_wire(bench):
    """Packets are lost and late: a loose motion ends where it does without, or stops in order where TCP repeats take too long."""
    if not bench.wire:
        print("bad wire: skipped: no namespaces")
        return
    bench.set_step(STEP)
    expected = as_on_one_machine(bench, loose=1)
    node = bench.node(loose=1)
    survived = 0
    try:
        # Each way, each packet by itself: 0.0075 s are 15 ms to and fro.
        wires = [(0.0, 0.0025), (0.0, 0.0075), (0.01, 0.0), (0.02, 0.0), (0.05, 0.0)]
        for loss, delay in 4 * wires if bench.is_long else [(0.005, 0.005)]:
            bench.way(Bad(loss, delay))
            outcome, _ = outcome_of(bench, bench.run(loose=1))
            bench.way(Clear())
            how = f"{loss:.1%} lost, up to {delay * 1e3:.0f} ms late"
            if outcome.ended_well():
                survived += 1
                print(f"bad wire: {how}: at its end, {compared(bench, expected):.1e} rad off")
            else:
                nothing_left(bench)
                print(f"bad wire: {how}: stopped in order, and told: {outcome}")
            time.sleep(1.0)
        print(f"bad wire: {survived} loose motions came to their end")
    finally:
        bench.way(Clear())
        end(node)


def refused(bench, what, told, node=None, **how):
    """Starts the cell while node b is this: it is refused, and nothing has moved."""
    try:
        status, words = ended(bench.run(**how))
        has(status == 2, f"{what}: it ended with {status}: {words}")
        has(all(text in words for text in told), f"{what}: it says: {words}")
        has(all(moved(bench.trace(robot)) is None for robot in JOINTS), f"{what}: something has moved")
        print(f"{what}: refused: {words.splitlines()[0].removeprefix('error: ')[:150]}")
    finally:
        if node:
            end(node)


def strangers(bench):
    """A node that is missing, of another program, with another cell, with a certificate of another authority; one that joins twice."""
    refused(bench, "no node", ["node b is not there", "node b\n"])

    program = bench.folder / "b/program"
    with program.open("ab") as file:
        file.write(b"another build")
    refused(bench, "another program", ["node b", "another one than that of node a"], bench.node())
    shutil.copy(PROGRAM, program)

    cell = bench.folder / "b/cell.toml"
    cell.write_text(bench.cell() + "# other words\n")
    refused(bench, "another cell", ["node b", "its cell.toml is another one"], bench.node())
    cell.write_text(bench.cell())

    bench.certify("others")
    own = bench.folder / "b/certificates"
    own.rename(bench.folder / "b/own")
    shutil.copytree(bench.folder / "others/b", own)
    refused(bench, "another authority", ["is not node b of this cell", "certificates"], bench.node())
    shutil.rmtree(own)
    (bench.folder / "b/own").rename(own)


def joins_twice(bench):
    """A second node b, and a second launcher of node a, while the cell runs: both are refused, and the cell goes on."""
    for name in "ab":
        shutil.copytree(bench.folder / name, bench.folder / f"{name}2")
    node = bench.node(loose=4)
    try:
        cell = bench.run(loose=4)
        begins(bench, cell)
        status, words = ended(bench.start("b", "node", "b", home="b2", loose=4))
        has(status == 2 and "node b cannot wait at" in words, f"a second node b ended with {status}: {words}")
        print(f"second node b: refused: {words.splitlines()[0].removeprefix('error: ')[:120]}")
        status, words = ended(bench.start("a", "--processes", home="a2", loose=4, trace="second"))
        had_ended = cell.poll() is not None
        outcome, _ = outcome_of(bench, cell)
        if had_ended and status != 2:
            not_tested("nodes", "that a second launcher is refused, since the first cell had ended", outcome)
        else:
            has(status == 2 and "it has processes of another run" in words, f"a second launcher ended with {status}: {words}")
            has(not list((bench.folder / "second").iterdir()), "the second cell has robots that run")
            print(f"second launcher: refused: {words.splitlines()[0].removeprefix('error: ')}")
        if not outcome.ended_well():
            not_tested("nodes", "that the first cell goes on", outcome)
        nothing_left(bench)
    finally:
        end(node)


def node_killed(bench):
    """The agent is killed in mid-motion: its robots brake, the cell stops and says so, and what it leaves goes with the next agent."""
    node = bench.node(loose=6)
    try:
        cell = bench.run(loose=6)
        begins(bench, cell)
        time.sleep(1.0)
        had = sessions(bench)
        # Where it is in a namespace, the program is a child of what entered it; the same process, since both are one `exec`.
        node.kill()
        node.wait()
        outcome, words = outcome_of(bench, cell)
        has(not outcome.ended_well(), f"a cell without its node ended well: {words}")
        if not ("node b is lost" in words or "polycrank" in words):
            has(outcome.skipped > 0, f"nobody says what is lost: {words}")
            not_tested("nodes", "what is told of an agent that is killed", outcome)
        nothing_left(bench)
        rest = {robot: moved(bench.trace(robot)) or 0.0 for robot in JOINTS}
        bound = 0.02 + STEP + STOP + 0.25 + outcome.longest_stall + outcome.skipped * STEP
        has(abs(rest["rnt"] - rest["polycrank"]) < bound, f"an arm goes on: {rest}")
        remains = segments_of(had)
        node = bench.node(loose=6)
        has(had and not segments_of(had), f"an agent that begins leaves what a killed one has left: {segments_of(had)}")
        print(f"agent killed: it leaves {len(remains)} segments, which the next agent removes; the arms stand {abs(rest['rnt'] - rest['polycrank']) * 1e3:.0f} ms apart")
    finally:
        end(node)


PARTS = [strangers, joins_twice, node_killed, cable_pulled, bad_wire, reaches_its_end]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=[part.__name__ for part in PARTS])
    parser.add_argument("--long", action="store_true", help="all cuts and wires")
    options = parser.parse_args(arguments())
    begin_in_namespace()
    bench = Bench(options.seed, options.long)
    print(f"nodes: {'two namespaces' if bench.wire else 'loopback'}, seed {options.seed}")
    try:
        for part in PARTS:
            if options.only in (None, part.__name__):
                part(bench)
    except Shortfall as shortfall:
        sys.exit(f"nodes: {shortfall}")
    finally:
        bench.close()


if __name__ == "__main__":
    main()

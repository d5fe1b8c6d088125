"""What a bridge costs a step of a cell in instructions: `instructions.py`.

The cell of two arms under the virtual clock, where one thread runs the steps of all its processes, and another one shows them: alone, and with a bridge and a node of rclpy that takes
the joint states. Valgrind counts the instructions of each thread, in a run of one turn and in one of two, so that what it takes to begin falls out. Out: instructions of a step. The exit
status is not 0 where a step takes a thousandth more with a bridge. System calls are counted by `cost.py`, in real time: here the first thread waits for the second one, which it never does
there. For x86-64; needs valgrind.
"""

import ctypes
import json
import os
import re
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cost import ALONE, DOMAIN, EXAMPLES, WITH, start  # noqa: E402

CELL = Path("ports/panel/examples/cell.toml").resolve()


def without_auxv():
    """Refuses the call PR_GET_AUXV from here on: it tells of the vDSO, which Valgrind hides, and a program that then calls it ends."""
    PRCTL, GET_AUXV, EINVAL = 157, 0x41555856, 22
    NO_NEW_PRIVILEGES, SET_SECCOMP, FILTER = 38, 22, 2
    LOAD, IF_EQUAL, RETURN, ERROR, ALLOW = 0x20, 0x15, 0x06, 0x50000, 0x7FFF0000
    # The number of the call is at 0, its first argument at 16.
    lines = [(LOAD, 0, 0, 0), (IF_EQUAL, 0, 3, PRCTL), (LOAD, 0, 0, 16), (IF_EQUAL, 0, 1, GET_AUXV), (RETURN, 0, 0, ERROR | EINVAL), (RETURN, 0, 0, ALLOW)]
    code = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *line) for line in lines))
    program = ctypes.create_string_buffer(struct.pack("HxxxxxxP", len(lines), ctypes.addressof(code)))
    prctl = ctypes.CDLL(None).prctl
    if prctl(NO_NEW_PRIVILEGES, 1, 0, 0, 0) or prctl(SET_SECCOMP, FILTER, program, 0, 0):
        raise OSError("the call cannot be refused")


def run(folder, turns, tool):
    """The steps of a run that a tool looks at."""
    outcome = folder / "outcome.json"
    outcome.unlink(missing_ok=True)
    cell = [EXAMPLES / "arms", "--cell", CELL, "--no-picture", "--quiet", "--outcome", outcome, "--", "--turns", str(turns)]
    ran = subprocess.run([*tool, *cell], capture_output=True, text=True, preexec_fn=without_auxv)
    if ran.returncode != 0 or not outcome.exists():
        sys.exit(f"ros2: {tool[0]}: {ran.stderr[-1000:]}")
    return json.loads(outcome.read_text())["steps"]


def counts(folder, turns):
    """Steps, and instructions of the thread of the steps and of the one that shows them."""
    for old in folder.glob("counted*"):
        old.unlink()
    steps = run(folder, turns, ["valgrind", "--tool=callgrind", "--separate-threads=yes", f"--callgrind-out-file={folder}/counted"])
    threads = [re.search(r"^summary: (\d+)", file.read_text(), re.M) for file in sorted(folder.glob("counted-*"))]
    return steps, int(threads[0][1]), int(threads[1][1])


def of_a_step(folder):
    one, two = counts(folder, 1), counts(folder, 2)
    return [(b - a) / (two[0] - one[0]) for a, b in zip(one[1:], two[1:])]


def main(folder):
    found = {ALONE: of_a_step(folder), ALONE + " again": of_a_step(folder)}
    others = [start(EXAMPLES / "bridge", "--cell", CELL, "--domain", DOMAIN), start(sys.executable, Path(__file__).with_name("cost.py"), "--listen")]
    try:
        others[0].stderr.readline()
        others[1].stdout.readline()
        time.sleep(3)
        found[WITH] = of_a_step(folder)
    finally:
        for one in reversed(others):
            one.send_signal(signal.SIGINT)
            one.communicate(timeout=30)
    print("instructions of a step, and of the thread that shows it:")
    for kind, (steps, shows) in found.items():
        print(f"  {kind:15} {steps:9.0f} {shows:9.0f}")
    more = found[WITH][0] - found[ALONE][0]
    if more > 1e-3 * found[ALONE][0]:
        sys.exit(f"ros2: a bridge costs a step {more:.0f} instructions")


with tempfile.TemporaryDirectory() as own_folder:
    main(Path(own_folder))

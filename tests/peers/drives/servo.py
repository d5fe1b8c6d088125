"""The book's driver over TCP with the book's servo: it moves, its stops are told, others are refused, and a reset calls it again.

Where a late machine stops the cell in between, what comes after that is not tested, and told by name.
"""

import argparse
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent))
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402
from device_priority import urgent  # noqa: E402

PAGE = Path(__file__).resolve().parents[2] / "tutorial/tcp_servo"


class Servo:
    def __init__(self, port=0):
        self.process = subprocess.Popen(
            [sys.executable, PAGE / "servo.py", str(port)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, preexec_fn=urgent
        )
        self.port = int(self.process.stdout.readline().rsplit(":", 1)[1])

    def press(self):
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return self.process.stdout.readline()

    def die(self):
        self.process.kill()
        self.process.wait()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=Path)
    program = parser.parse_args().program.resolve()
    servo = Servo()
    folder = Path(tempfile.mkdtemp())
    shutil.copy(PAGE / "table.urdf", folder)
    cell = (PAGE / "cell.toml").read_text().replace(":2000", f":{servo.port}")
    (folder / "cell.toml").write_text('after_fault = "await reset"\n' + cell)

    program = [program, "--", "--program", "servo"]
    tested = []

    def console(*words):
        # Until the cell runs, nobody listens.
        for _ in range(50):
            command = [program[0], *words, *program[1:]]
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=30)
            if done.returncode == 0 or cell.poll() is not None:
                break
            time.sleep(0.1)
        return done.stdout + done.stderr

    def until(what, timeout=20):
        end = time.monotonic() + timeout
        while True:
            said = console("status")
            if what in said:
                return said
            has("last fault: none" in said or "latched" not in said or time.monotonic() < end, said)
            has(time.monotonic() < end and cell.poll() is None, said)
            time.sleep(0.1)

    def at():
        found = console("status").split("measured")
        has(len(found) == 2, found[0])
        return float(found[1].split()[0])

    def end_of_cell():
        if cell.poll() is None:
            console("abort")
        try:
            return cell.communicate(timeout=20)[0]
        except subprocess.TimeoutExpired:
            cell.kill()
            return cell.communicate()[0]

    cell = subprocess.Popen(
        [program[0], "--processes", "--no-picture", "--outcome", "outcome.json", *program[1:]],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        until("running")
        begin = at()
        time.sleep(0.5)
        has(abs(at() - begin) > 0.01, "it does not move: " + console("status"))
        tested.append("moved")
        # Another client is closed at once, and the servo goes on.
        other = socket.create_connection(("127.0.0.1", servo.port))
        has(other.recv(1) == b"", "the servo takes a second client")
        has("running" in console("status"), "a second client stopped it: " + console("status"))
        tested.append("was left alone by a second client")
        servo.press()
        until("stopped at the robot: emergency stop")
        # A reset does not clear what needs a person: it stays latched.
        console("acknowledge")
        console("reset")
        time.sleep(0.5)
        until("latched")
        stood = at()
        servo.press()
        console("acknowledge")
        console("reset")
        until("running")
        time.sleep(0.5)
        has(abs(at() - stood) > 0.01, "it does not go on: " + console("status"))
        tested.append("was stopped by its emergency stop")
        servo.die()
        tested.append("was lost")
        until("communication lost")
        console("acknowledge")
        console("reset")
        time.sleep(0.5)
        until("latched")
        servo = Servo(servo.port)
        console("acknowledge")
        console("reset")
        until("running")
        end = time.monotonic() + 60
        while cell.poll() is None:
            said = console("status")
            # With a new fault it awaits a reset.
            has("latched" not in said and time.monotonic() < end, said)
            time.sleep(0.5)
        outcome = Outcome(folder / "outcome.json", end_of_cell())
        has(outcome.ended_well(), f"it ended by {outcome}")
        tested.append("was called again by a reset")
        print(f"servo: {', '.join(tested)}")
    except Shortfall as why:
        outcome = Outcome(folder / "outcome.json", end_of_cell())
        # Who was lost by our doing is no sign of lateness.
        if not outcome.is_late(controller="was lost" not in tested):
            sys.exit(f"servo: after it {', '.join(tested)}: {why}: {outcome}")
        not_tested("servo", f"what comes after it {', '.join(tested) or 'began'}", outcome)
    finally:
        servo.die()
        end_of_cell()


main()

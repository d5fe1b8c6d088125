"""The book's driver over TCP with the book's servo: it moves, its stops are told, others are refused, and a reset calls it again."""

import argparse
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent))
from late import Late, late  # noqa: E402

PAGE = Path(__file__).resolve().parents[2] / "tutorial/tcp_servo"
# What a servo in Python causes that is given too little time.
TOO_SLOW = ["has said nothing for", "following error"]


def has(condition, said):
    if not condition:
        raise Late(said) if late(said, *TOO_SLOW) else SystemExit(f"servo: {said}")


class Servo:
    def __init__(self, port=0):
        self.process = subprocess.Popen(
            [sys.executable, PAGE / "servo.py", str(port)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
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

    def console(*words):
        # Until the cell runs, nobody listens.
        for _ in range(50):
            done = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True, timeout=30)
            if done.returncode == 0 or cell.poll() is not None:
                break
            time.sleep(0.1)
        return done.stdout + done.stderr

    def until(what, patience=20):
        end = time.monotonic() + patience
        while True:
            said = console("status")
            if what in said:
                return said
            has("last fault: none" in said or "latched" not in said or time.monotonic() < end, said)
            has(time.monotonic() < end, said)
            time.sleep(0.1)

    def at():
        return float(console("status").split("measured")[1].split()[0])

    cell = subprocess.Popen(
        [program, "--processes", "--no-picture"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        until("running")
        begin = at()
        time.sleep(0.5)
        has(abs(at() - begin) > 0.01, "it does not move: " + console("status"))
        # Another client is closed at once, and the servo goes on.
        other = socket.create_connection(("127.0.0.1", servo.port))
        has(other.recv(1) == b"", "the servo takes a second client")
        has("running" in console("status"), "a second client stopped it: " + console("status"))
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
        servo.die()
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
        has(cell.returncode == 0, cell.stdout.read())
    except Late as why:
        print("servo:", why)
        sys.exit(75)
    finally:
        servo.die()
        if cell.poll() is None:
            console("abort")
            try:
                cell.wait(timeout=20)
            except subprocess.TimeoutExpired:
                cell.kill()
    print("servo: moved, stopped by its emergency stop, lost, and called again by a reset")


main()

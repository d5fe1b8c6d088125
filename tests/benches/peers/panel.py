"""What an attached panel costs the processes that move robots: `panel.py PROGRAM CELL [ROUNDS]`, in a folder that can be written.

Alternating runs of the same cell in real time: without a panel; with one at which three pages look on, of which one has control; with one that
is attacked besides, by floods of messages, crowds of connections and a page that does not read. Out: for each process that keeps
time the median and the 99th percentile of its lateness in each run [us], and what the runs with a panel differ by, beside what those without
one differ by among themselves; then the system calls of the MP's and the EDPs' threads that move robots, in a second.
"""

import base64
import json
import os
import re
import shutil
import signal
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import threading
import time

WITHOUT, WITH, ATTACKED = "without", "with pages", "attacked"
# Of a run [s]: the motions take 12.
TOO_LONG = 60
KINDS = [WITHOUT, WITH, ATTACKED]


class Page:
    """A connection as the panel's own page has it."""

    def __init__(self, address, token):
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)), timeout=5)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            f"GET /connect HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n".encode()
        )
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            byte = self.socket.recv(1)
            if not byte:
                raise OSError("closed")
            head += byte
        self.say({"token": token})

    def say(self, message):
        text = json.dumps(message).encode()
        size = bytes([0x80 | len(text)]) if len(text) < 126 else bytes([0x80 | 126]) + struct.pack(">H", len(text))
        self.socket.sendall(b"\x81" + size + bytes(4) + text)

    def read(self):
        """Reads what comes, and drops it."""
        return len(self.socket.recv(1 << 16))


def look_on(address, token, ends, operates):
    page = Page(address, token)
    page.socket.settimeout(0.05)
    if operates:
        page.say({"n": 1, "do": "take"})
    said = 0
    while not ends.is_set():
        try:
            if page.read() == 0:
                return
        except TimeoutError:
            pass
        except ConnectionError:
            # The cell has ended.
            return
        if operates and time.monotonic() - said > 0.1:
            said = time.monotonic()
            page.say({"do": "beat"})


def attack(address, token, ends):
    """Floods, crowds, and a page that does not read, again and again."""
    deaf = []
    while not ends.is_set():
        try:
            deaf = deaf[-4:] + [Page(address, token)]
            flood = Page(address, token)
            for _ in range(5000):
                flood.say({"do": "beat"})
        except OSError:
            pass
        host, port = address.rsplit(":", 1)
        crowd = []
        try:
            for _ in range(100):
                crowd.append(socket.create_connection((host, int(port)), timeout=1))
        except OSError:
            pass
        for one in crowd:
            one.close()
        time.sleep(0.05)


def run(program, cell, kind, traced):
    words = [program, "--cell", cell, "--processes", "--no-picture"] + ([] if kind == WITHOUT else ["--panel"]) + ["--", "--turns", "2"]
    started = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    ends, threads, said, calls = threading.Event(), [], "", {}
    # A cell that has stopped waits for nobody here.
    bound = threading.Timer(TOO_LONG, started.send_signal, [signal.SIGINT])
    bound.start()
    tracer = threading.Thread(target=lambda: calls.update(trace(program, cell)))
    if traced and kind == WITHOUT:
        tracer.start()
    for line in started.stdout:
        said += line
        found = re.search(r"panel: http://(\S+?)/#token=([0-9a-f]{32})", line)
        if found:
            address, token = found.groups()
            threads = [threading.Thread(target=look_on, args=(address, token, ends, i == 0), daemon=True) for i in range(3)]
            if kind == ATTACKED:
                threads.append(threading.Thread(target=attack, args=(address, token, ends), daemon=True))
            for thread in threads:
                thread.start()
            if traced:
                tracer.start()
    ends.set()
    started.wait()
    bound.cancel()
    if traced and tracer.ident:
        tracer.join()
    rows = re.findall(r"^(mp|plant|edp \S+) +(\d+) +(\d+) +(\d+) +([\d.]+) +([\d.]+) +([\d.]+)", said, re.M)
    if started.returncode != 0 or not rows:
        print(f"  {kind}: this run has failed and does not count:\n{said[-600:]}", file=sys.stderr)
        return None
    late = {name: (float(p50), float(p99)) for name, _, _, _, p50, p99, _ in rows}
    return late, sum(int(skipped) for _, _, skipped, *_ in rows), calls


def trace(program, cell):
    """System calls of the thread of each process that moves robots, in a second: a hundred steps."""
    time.sleep(3)
    status = subprocess.run([program, "status", "--cell", cell], capture_output=True, text=True).stdout
    calls = {}
    for pid, name in re.findall(r"^ +(\d+) (mp|edp \S+) ", status, re.M):
        traced = subprocess.run(["timeout", "-s", "INT", "1", "strace", "-c", "-p", pid], capture_output=True, text=True).stderr
        counts = {row[-1]: int(row[3]) for row in map(str.split, traced.splitlines()) if len(row) >= 5 and row[3].isdigit() and row[-1] != "total"}
        calls[name] = counts
    return calls


def main(folder):
    program = sys.argv[1]
    # The cell that is given, but that it ends when it has stopped, and has steps so long that it bears how late a shared machine is.
    cell = os.path.join(folder, "cell.toml")
    with open(sys.argv[2]) as given, open(cell, "w") as own:
        text = re.sub(r"^after_fault = .*$", "", given.read(), flags=re.M)
        own.write(re.sub(r"^step_ms = .*$", "step_ms = 10", text, flags=re.M))
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    model = re.search(r"model name\s*: (.*)", open("/proc/cpuinfo").read())
    print(f"machine: {model and model[1]}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    found = {kind: [] for kind in KINDS}
    for i in range(rounds):
        for kind in KINDS:
            # A run in which this machine was later than a cell bears is made again.
            one = next(filter(None, (run(program, cell, kind, False) for _ in range(4))), None)
            if one:
                found[kind].append(one)
                print(f"run {i + 1}, {kind}: {one[1]} steps and periods left out; p50, p99 [us]: " + ", ".join(f"{name} {a:.0f} {b:.0f}" for name, (a, b) in one[0].items()), flush=True)
    print(f"\n{'process':10} {'':4} {'without [us]':>28} {'with pages':>12} {'attacked':>12} {'differ by':>18} {'without differ by':>18}")
    if not all(found.values()):
        sys.exit("no run of each kind has ended: this machine is later than a cell bears")
    names = list(found[WITHOUT][0][0])
    for name in names:
        for place, what in enumerate(["p50", "p99"]):
            of = {kind: [late[name][place] for late, _, _ in runs] for kind, runs in found.items() if runs}
            middle = {kind: statistics.median(values) for kind, values in of.items()}
            spread = max(of[WITHOUT]) - min(of[WITHOUT])
            differ = [middle[kind] - middle[WITHOUT] for kind in KINDS[1:] if kind in middle]
            print(f"{name:10} {what:4} {' '.join(f'{value:.0f}' for value in of[WITHOUT]):>28} {middle.get(WITH, 0):12.0f} {middle.get(ATTACKED, 0):12.0f} "
                  f"{' '.join(f'{value:+.0f}' for value in differ):>18} {spread:18.0f}  {'within' if all(value <= spread for value in differ) else 'LATER'}")
    if not shutil.which("strace"):
        print("skipped: system calls: there is no strace")
        return
    print("\nsystem calls of the threads that move robots, in a second:")
    for kind in KINDS:
        one = run(program, cell, kind, True)
        for name, counts in (one[2] if one else {}).items():
            print(f"  {kind:10} {name:10} {sum(counts.values())} calls in a second: {', '.join(f'{call} {count}' for call, count in sorted(counts.items()))}")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="mrroc-panel-") as own_folder:
        main(own_folder)

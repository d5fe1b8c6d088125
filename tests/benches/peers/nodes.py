"""Two machines, in namespaces joined by veth: what a round trip costs beside bare zenoh, and the steps that are missed at 1 kHz beside
cyclictest. In: the example `round_trip`, built, and cyclictest if it is there. Out: figures; nothing fails by them.
"""

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = ROOT / "target/release/examples/round_trip"
sys.path.append(str(ROOT / "tests/peers"))
from wire import Namespace, begin_in_namespace, run  # noqa: E402

URGENT = subprocess.run(["chrt", "-f", "50", "true"], capture_output=True).returncode == 0

ADDRESSES = ["10.77.0.1", "10.77.0.2"]
CELL = """step_ms = {step}

[robots.near]
kind = "irp6"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]

[robots.far]
kind = "irp6"
node = "b"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]

[nodes.a]
address = "10.77.0.1:7447"
mp = true

[nodes.b]
address = "10.77.0.2:7448"

[realtime]
priority = 50
permission = "best effort"
"""


def measure(machines, folder, step, bare, cyclictest):
    for name in "ab":
        home = folder / name
        home.mkdir(exist_ok=True)
        (home / "cell.toml").write_text(CELL.format(step=step))
    if not (folder / "keys").exists():
        run(PROGRAM, "--cell", folder / "a/cell.toml", "certificates", folder / "keys")
        for name in "ab":
            shutil.copytree(folder / "keys" / name, folder / name / "certificates")

    def begin(place, *words, **how):
        home = folder / "ab"[place]
        words = [PROGRAM, *words] if words[0] == "echo" else [PROGRAM, "--cell", home / "cell.toml", "--no-picture", *words]
        if bare:
            words += ["--", "--echo-at", "10.77.0.2:7450", "--keys", home / "certificates"]
        if words[1] == "echo" and URGENT:
            # As urgent as the cell's processes, and the MP's own end of it.
            words = ["chrt", "-f", "50", *words]
        return subprocess.Popen(machines[place].within(*words), stdin=subprocess.DEVNULL, text=True, **how)

    node = begin(1, "node", "b")
    echo = begin(1, "echo", stdout=subprocess.PIPE) if bare else None
    if echo:
        echo.stdout.readline()
    time.sleep(1.0)
    beside = None
    if cyclictest:
        # An awake thread for each step, at the priority of the cell.
        words = [cyclictest, "-q", "-m", "-p50", "-i", f"{step * 1000:.0f}", "-D", "20", "-h", "20000"]
        beside = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    what = "bare zenoh with the same settings" if bare else "a Wait of 20 s for both robots"
    print(f"\nstep_ms = {step}, {what}", flush=True)
    cell = begin(0, "--processes")
    status = cell.wait(300)
    for process in filter(None, (node, echo)):
        process.terminate()
        process.wait(30)
    if beside:
        beside.terminate()
        out, _ = beside.communicate(timeout=30)
        late = 0
        for line in out.splitlines():
            words = line.split()
            if len(words) == 2 and words[0].isdigit() and int(words[0]) >= step * 1000:
                late += int(words[1])
            if "Latencies" in line or "Overflows" in line or "Total" in line:
                print(f"cyclictest  {line.lstrip('# ')}")
        print(f"cyclictest  woke later than a step {late} times")
    return status


def main():
    if not begin_in_namespace():
        sys.exit("nodes: this machine permits no namespaces")
    cyclictest = shutil.which("cyclictest")
    model = next(line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name"))
    load = " ".join(f"{share:.1f}" for share in os.getloadavg())
    print(f"{model}, {os.cpu_count()} cores, Linux {platform.release()}, load {load}")
    run("ip", "link", "add", "bench0", "type", "veth", "peer", "name", "bench1")
    machines = [Namespace("bench0", *ADDRESSES), Namespace("bench1", *reversed(ADDRESSES))]
    folder = Path(tempfile.mkdtemp())
    try:
        for step, bare in ((10, True), (1, False)):
            if measure(machines, folder, step, bare, cyclictest):
                print("the cell did not end well: this machine was too late for this step")
    finally:
        for machine in machines:
            machine.close()
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()

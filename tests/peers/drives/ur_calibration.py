"""A controller whose arm has dimensions of its own tells them; a cell with others does not open its drives."""

import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
sys.path.append(str(HERE.parent))
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402
from device_priority import urgent  # noqa: E402

CELL = ROOT / "robots/drivers/ur/examples/cell.toml"
UR = ROOT / "target/debug/examples/ur"


def numbers(text):
    """The lines of a calibration without its comments."""
    return [line.split(" #")[0].rstrip() for line in text.splitlines() if line and not line.startswith("#")]


def run(folder):
    """The cell with the calibration of this folder: its exit status, and what it said."""
    (folder / "outcome.json").unlink(missing_ok=True)
    command = [UR, "--cell", folder / "cell.toml", "--processes", "--no-picture", "--outcome", folder / "outcome.json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout + done.stderr


def tested(folder):
    own = (HERE / "ur5e.toml").read_text()
    told = subprocess.run([UR, "--cell", CELL, "calibration", "arm"], capture_output=True, text=True, timeout=60)
    has(numbers(told.stdout) == numbers(own), f"the controller has {own}, and the cell is told {told.stdout}{told.stderr}")
    file = folder / "arm.toml"
    file.write_text(told.stdout)
    # A key of the arm's table, which is the last one of that file but for what the machine is asked for.
    head, realtime, tail = CELL.read_text().partition("# As processes")
    (folder / "cell.toml").write_text(f'{head}calibration = "arm.toml"\n\n{realtime}{tail}')
    _, said = run(folder)
    outcome = Outcome(folder / "outcome.json", said)
    if not outcome.ended_well(controller=True):
        not_tested("ur_calibration", "that a cell with its arm's own dimensions runs to its end", outcome)
    has("0.0999" in told.stdout, f"no length of it is 0.0999: {told.stdout}")
    file.write_text(told.stdout.replace("0.0999", "0.0998"))
    status, said = run(folder)
    has(status != 0 and "is not that of this arm" in said, f"with other dimensions it ended with {status}: {said}")
    print("ur_calibration: an arm's own dimensions are told, and others are refused")


def main():
    with tempfile.TemporaryDirectory() as folder:
        command = [ROOT / "target/debug/ur-controller", "ur5e", "127.0.0.1", HERE / "ur5e.toml"]
        controller = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, preexec_fn=urgent)
        controller.stdout.readline()
        try:
            tested(Path(folder))
        except Shortfall as why:
            sys.exit(f"ur_calibration: {why}")
        finally:
            controller.communicate("end\n", timeout=20)


if __name__ == "__main__":
    main()

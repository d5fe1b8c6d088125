"""What the peers of ROS 2 share: where they listen, what they build on, and how a run of theirs ends."""

import os
import signal
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cell_outcome import Outcome, Shortfall  # noqa: E402

EXAMPLES = Path("target/debug/examples").resolve()


def listen_in(domain):
    """On loopback alone, in a domain of DDS. Call it before rclpy is imported."""
    os.environ["ROS_DOMAIN_ID"] = domain
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"


def has(is_so, what):
    if not is_so:
        raise Shortfall(what)


@contextmanager
def ended_after(cell, *others):
    """Interrupts a cell in the end, and then kills what is beside it."""
    try:
        yield
    finally:
        cell.send_signal(signal.SIGINT)
        cell.wait(timeout=30)
        for other in others:
            other.kill()


def run(title, test):
    """Runs a test in a folder of its own, into which its cell writes `outcome.json`."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        print(f"ros2: {title}")
        try:
            test(folder)
        except Shortfall as shortfall:
            outcome = folder / "outcome.json"
            if outcome.exists() and Outcome(outcome).is_late():
                print(f"not tested, the machine was late: {shortfall}; {Outcome(outcome)}")
                return
            sys.exit(f"ros2: {shortfall}")

"""How a cell ended, by the file that it writes with `--outcome`, and which of its faults a machine causes that is late.

A cell whose machine gives it too little time stops, in order, and names that cause: it does what it must. Whoever tests such a run tests
what holds for late runs as well, and says by name what could not be tested. Every other fault is a shortfall. Nothing is started again.
"""

import json
from pathlib import Path

# A process of the cell was late for another one, or for too many of its own steps.
LATENESS = frozenset({"PeerLost", "Overrun"})


class Shortfall(Exception):
    """What is not as it should be."""


class Outcome:
    """How one run ended."""

    def __init__(self, file, said=""):
        file = Path(file)
        if not file.exists():
            raise Shortfall(f"the cell has told no outcome: {said}")
        told = json.loads(file.read_text())
        fault = told["fault"] or {"kind": None, "process": None, "step": None, "text": "no fault"}
        self.kind, self.process, self.step, self.text = (fault[key] for key in ("kind", "process", "step", "text"))
        self.steps, self.time, self.processes = told["steps"], told["time"], told["processes"]
        # Periods that processes left out, and how late one of them began at most [s].
        self.skipped, self.longest_stall = told["skipped"], told["longest_stall"]

    def of(self, process):
        """The figures of this process."""
        return next(each for each in self.processes if each["process"] == process)

    def is_late(self, controller=False):
        """Whether the machine's lateness ended the run; with a controller that stands on the same machine and keeps real time in
        Python, also by a robot that has said nothing or has stopped by itself."""
        lost = self.kind == "RobotStopped" and "communication lost" in self.text
        return self.kind in LATENESS or controller and (lost or self.kind == "DriveFault")

    def ended_well(self, **how):
        """Whether it did: False where lateness ended it, and a shortfall where anything else did."""
        if self.kind is not None and not self.is_late(**how):
            raise Shortfall(f"the cell ended by {self}")
        return self.kind is None

    def ended_by(self, kind, words="", **how):
        """Whether this kind of fault ended it, in whose text these words are: False where lateness came before it, and a shortfall else."""
        if self.kind == kind and words in self.text:
            return True
        if not self.is_late(**how):
            raise Shortfall(f"the cell ended by {self}, not by {kind} with `{words}`")
        return False

    def __str__(self):
        return (
            f"{self.kind}: {self.text} ({self.steps} steps, {self.skipped} periods left out, the longest stall was "
            f"{self.longest_stall * 1e3:.1f} ms)"
        )


def has(condition, what):
    if not condition:
        raise Shortfall(what)


def not_tested(who, what, outcome):
    """Says what a run that was late could not show."""
    print(f"{who}: not tested, for this machine was late: {what}: {outcome}", flush=True)

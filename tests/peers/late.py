"""What a cell says when this machine gave its processes too little time: no fault of what is judged.

As a command: exit status 0 if standard input says so.
"""

import re
import sys

WORDS = [
    "too many steps were missed",
    "the process at the other end is gone",
    "the launcher stands still",
    "after late demands",
    # The one before was too slow to end.
    "is run by process",
]


class Late(Exception):
    """This machine was late by more than a cell bears."""


def late(said, *more):
    """The words that say so, or `None`; `more` are those of what is judged, which keeps real time as well."""
    found = re.search("|".join([*WORDS, *more]), said)
    return found and found[0]


def skipped(said):
    """Steps and periods that the processes of a cell have left out, by the table at its end: for so much longer robots go on as before."""
    return sum(map(int, re.findall(r"^(?:mp|plant|(?:ecp|edp|vsp) \S+) +\d+ +(\d+) ", said, re.M)))


if __name__ == "__main__":
    sys.exit(not late(sys.stdin.read()))

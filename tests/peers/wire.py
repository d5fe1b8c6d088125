"""A wire between two network namespaces, for tests of what crosses a network.

Each namespace has a TUN device; what one sends, this process hands to the other, or does not, as its seed says. So TCP's own
repeats are those of the kernel.
"""

import fcntl
import heapq
import os
import random
import select
import struct
import subprocess
import sys
import threading
import time

from device_priority import urgent

TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000


class Wire(threading.Thread):
    """Two TUN devices. `way` says of each packet what happens to it; it may be replaced at any time."""

    def __init__(self, seed):
        super().__init__(daemon=True)
        self.random = random.Random(seed)
        self.ends = [self.device("wire0"), self.device("wire1")]
        self.way = Clear()
        self.waiting = []
        self.passed = self.lost = 0
        self.ended = False
        # Of the thread that starts it, too: Python lets one thread run at a time.
        urgent(inherited=False)

    @staticmethod
    def device(name):
        end = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
        fcntl.ioctl(end, TUNSETIFF, struct.pack("16sH22x", name.encode(), IFF_TUN | IFF_NO_PI))
        return end

    def run(self):
        urgent(inherited=False)
        while not self.ended:
            now = time.monotonic()
            until = max(0.0, self.waiting[0][0] - now) if self.waiting else 0.1
            for end in select.select(self.ends, [], [], until)[0]:
                while True:
                    try:
                        packet = os.read(end, 65536)
                    except BlockingIOError:
                        break
                    delay = self.way.delay(self.random, packet, self.ends.index(end) == 0)
                    if delay is None:
                        self.lost += 1
                        continue
                    self.passed += 1
                    other = self.ends[1 - self.ends.index(end)]
                    heapq.heappush(self.waiting, (time.monotonic() + delay, self.passed, other, packet))
            while self.waiting and self.waiting[0][0] <= time.monotonic():
                _, _, end, packet = heapq.heappop(self.waiting)
                try:
                    os.write(end, packet)
                except OSError:
                    pass  # its namespace is gone


class Clear:
    """Nothing happens to a packet."""

    def delay(self, _random, _packet, _of_cell):
        return 0.0


class Bad(Clear):
    """Packets are lost with this probability, and come up to so much later, each by itself [s]: later ones overtake them."""

    def __init__(self, loss, delay):
        self.loss, self.most = loss, delay

    def delay(self, random, _packet, _of_cell):
        return None if random.random() < self.loss else random.uniform(0.0, self.most)


class Namespace:
    """One end: a network namespace of its own, with an address."""

    def __init__(self, device, address, other):
        self.holder = subprocess.Popen(["unshare", "-n", "sh", "-c", "echo; exec sleep infinity"], stdout=subprocess.PIPE)
        self.holder.stdout.readline()
        run("ip", "link", "set", device, "netns", str(self.holder.pid))
        for line in (f"addr add {address} peer {other} dev {device}", f"link set {device} up", "link set lo up"):
            run(*self.within("ip", *line.split()))

    def within(self, *command):
        return ["nsenter", "-t", str(self.holder.pid), "-n", *map(str, command)]

    def close(self):
        self.holder.kill()
        self.holder.wait()


def run(*command):
    subprocess.run(command, check=True)


class Cut(Clear):
    """The cable is pulled: nothing gets through."""

    def delay(self, _random, _packet, _of_cell):
        return None


def unshare():
    """How this user makes namespaces; None where nobody lets it. Who is root keeps its rights, such as that to a priority."""
    for options in ("-n", "-rn"):
        tried = subprocess.run(["unshare", options, "sh", "-c", "test -w /dev/net/tun && command -v ip nsenter"], capture_output=True)
        if tried.returncode == 0:
            return ["unshare", options]
    return None


# How the program in its namespace is told from the one that made it.
INSIDE = "--in-namespace"


def is_in_namespace():
    """Whether this program may make namespaces."""
    return INSIDE in sys.argv


def arguments():
    """Those of the program, for its parser."""
    return [argument for argument in sys.argv[1:] if argument != INSIDE]


def begin_in_namespace():
    """The same program once more, in a namespace in which it may make others; returns there, or False where there are none."""
    if is_in_namespace():
        return True
    enter = unshare()
    if enter is None:
        return False
    os.execvp("unshare", [*enter, sys.executable, *sys.argv, INSIDE])

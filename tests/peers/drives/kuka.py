"""RSIPI's emulator of a KUKA controller on this machine's loopback, for a number of cycles, or until nobody answers any more, or its
input ends.

It owns the clock, rejects answers with another clock or name, and breaks off after too many late ones. It starts to send,
waits until it is answered, and then counts. Prints what it saw as one line of JSON; `--path` has each answer that it took.
"""

import argparse
import importlib
import json
import os
import socket
import sys
import tempfile
import threading
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent))
from device_priority import urgent  # noqa: E402

CONFIGURATION = """<ROOT>
  <CONFIG><IP_NUMBER>127.0.0.1</IP_NUMBER><PORT>{port}</PORT><SENTYPE>ImFree</SENTYPE><ONLYSEND>FALSE</ONLYSEND></CONFIG>
  <SEND><ELEMENTS>
    <ELEMENT TAG="DEF_AIPos" TYPE="DOUBLE" INDX="INTERNAL" />
    <ELEMENT TAG="DEF_Delay" TYPE="LONG" INDX="INTERNAL" />
    <ELEMENT TAG="DiL" TYPE="LONG" INDX="1" />
    <ELEMENT TAG="DoutW" TYPE="LONG" INDX="2" />
  </ELEMENTS></SEND>
  <RECEIVE><ELEMENTS>{axes}<ELEMENT TAG="DiO" TYPE="LONG" INDX="7" HOLDON="1" /></ELEMENTS></RECEIVE>
</ROOT>
"""
AXIS = '<ELEMENT TAG="AKorr.A{0}" TYPE="DOUBLE" INDX="{0}" HOLDON="{1}" />'


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, default=49152)
    parser.add_argument("--address", default="127.0.0.1", help="of this end")
    parser.add_argument("--cell", default="127.0.0.1", help="the address of the other end")
    parser.add_argument("--cycles", type=int)
    parser.add_argument("--mode", choices=["absolute", "relative"], default="absolute")
    parser.add_argument("--period", type=int, choices=[4, 12], default=4, help="ms")
    parser.add_argument("--lose-after", type=int, help="answers after which every second one is not taken")
    parser.add_argument("--path", type=Path, help="a JSON file: when each answer was asked for, when it was taken [s], and all axes [degrees]")
    options = parser.parse_args()
    file_of_path = options.path and options.path.resolve()

    urgent()
    os.chdir(tempfile.mkdtemp())  # it writes a log
    emulator = importlib.import_module("RSIPI.rsi_echo_server")

    class OneAddress(socket.socket):
        """The emulator listens on every network of a machine; here it listens on one address alone."""

        def bind(self, address):
            super().bind((options.address, address[1]))

        def sendto(self, *arguments):
            self.sent = time.monotonic()
            return super().sendto(*arguments)

    emulator.socket.socket = OneAddress
    with open("rsi.xml", "w") as file:
        # What is late is held, or added again: the latter must not be.
        hold = 1 if options.mode == "absolute" else 0
        axes = "".join(AXIS.format(i, hold) for i in range(1, 7))
        file.write(CONFIGURATION.format(port=options.port, axes=axes))

    class Controller(emulator.EchoServer):
        """Keeps the positions of all axes after each answer that it took."""

        def __init__(self):
            self.path = []
            self.taken = []
            self.turn = False
            self.words = []
            super().__init__("rsi.xml", delay_ms=options.period, mode=options.mode)
            # An output that nobody tells anything is on.
            self.state["DoutW"] = 1 << 15

        def process_reply(self, text):
            self.turn = not self.turn
            if options.lose_after is not None and len(self.path) >= options.lose_after and self.turn:
                text = text.replace(f"<IPOC>{self.last_sent_ipoc}<", "<IPOC>1<")
            accepted = super().process_reply(text)
            # A switch at the gripper: input 3 follows output 9.
            word = self.state["DoutW"]
            self.state["DiL"] = (word >> 9 & 1) << 3
            if word not in self.words[-1:]:
                self.words.append(word)
            if accepted:
                self.taken.append((self.udp_socket.sent, time.monotonic()))
                self.path.append([self.state["AIPos"][f"A{i}"] for i in range(1, 7)])
            return accepted

    controller = Controller()
    controller.client_address = (options.cell, options.port)
    controller.start()
    over = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), over.set()), daemon=True).start()
    # It waits a minute for the first answer, and five seconds for each further one.
    answered, until = 0, time.monotonic() + 60
    while controller.running and not over.is_set() and (options.cycles is None or answered < options.cycles) and time.monotonic() < until:
        time.sleep(0.05)
        if len(controller.path) > answered:
            answered, until = len(controller.path), time.monotonic() + 5
    controller.stop()
    if file_of_path:
        file_of_path.write_text(json.dumps([[*taken, *axes] for taken, axes in zip(controller.taken, controller.path)]))
    steps = [
        max(abs(b - a) for a, b in zip(before, after))
        for before, after in zip(controller.path, controller.path[1:])
    ]
    jerks = [
        max(abs(d - 3 * c + 3 * b - a) for a, b, c, d in zip(*four))
        for four in zip(controller.path, controller.path[1:], controller.path[2:], controller.path[3:])
    ]
    print(
        json.dumps(
            {
                "cycles": len(controller.path),
                "late": controller.faulty_packets,
                "broke_off": controller.faulty_packets > controller.timeout_packets,
                "largest_step_deg": max(steps, default=0.0),
                "largest_third_difference_deg": max(jerks, default=0.0),
                "range_deg": [max(axis) - min(axis) for axis in zip(*controller.path)],
                "outputs": controller.words,
                "end_deg": controller.path[-1] if controller.path else None,
            }
        ),
        file=sys.stderr,
    )


if __name__ == "__main__":
    main()

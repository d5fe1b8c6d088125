"""RSIPI's emulator of a KUKA controller on this machine's loopback, in absolute mode, for a number of cycles.

It owns the clock, rejects answers with another clock or name, and breaks off after too many late ones. It starts to send,
waits until it is answered, and then counts. Prints what it saw as one line of JSON.
"""

import argparse
import importlib
import json
import os
import socket
import sys
import tempfile
import time

CONFIGURATION = """<ROOT>
  <CONFIG><IP_NUMBER>127.0.0.1</IP_NUMBER><PORT>{port}</PORT><SENTYPE>ImFree</SENTYPE><ONLYSEND>FALSE</ONLYSEND></CONFIG>
  <SEND><ELEMENTS>
    <ELEMENT TAG="DEF_AIPos" TYPE="DOUBLE" INDX="INTERNAL" />
    <ELEMENT TAG="DEF_Delay" TYPE="LONG" INDX="INTERNAL" />
  </ELEMENTS></SEND>
  <RECEIVE><ELEMENTS>{axes}</ELEMENTS></RECEIVE>
</ROOT>
"""
AXIS = '<ELEMENT TAG="AKorr.A{0}" TYPE="DOUBLE" INDX="{0}" HOLDON="1" />'


class Loopback(socket.socket):
    """The emulator listens on every network of a machine; here it listens on loopback alone."""

    def bind(self, address):
        super().bind(("127.0.0.1", address[1]))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, default=49152)
    parser.add_argument("--cycles", type=int, required=True)
    options = parser.parse_args()

    os.chdir(tempfile.mkdtemp())  # it writes a log
    emulator = importlib.import_module("RSIPI.rsi_echo_server")
    emulator.socket.socket = Loopback
    with open("rsi.xml", "w") as file:
        axes = "".join(AXIS.format(i) for i in range(1, 7))
        file.write(CONFIGURATION.format(port=options.port, axes=axes))

    class Controller(emulator.EchoServer):
        """Keeps the positions of all axes after each answer that it took."""

        def __init__(self):
            self.path = []
            super().__init__("rsi.xml", delay_ms=4, mode="absolute")

        def process_reply(self, text):
            accepted = super().process_reply(text)
            if accepted:
                self.path.append([self.state["AIPos"][f"A{i}"] for i in range(1, 7)])
            return accepted

    controller = Controller()
    controller.start()
    # It waits a minute for the first answer, and five seconds for each further one.
    answered, until = 0, time.monotonic() + 60
    while controller.running and answered < options.cycles and time.monotonic() < until:
        time.sleep(0.05)
        if len(controller.path) > answered:
            answered, until = len(controller.path), time.monotonic() + 5
    controller.stop()
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
                "end_deg": controller.path[-1] if controller.path else None,
            }
        ),
        file=sys.stderr,
    )


if __name__ == "__main__":
    main()

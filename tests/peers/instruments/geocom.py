"""GeoComPy drives the simulated theodolite; then our driver reads the same instrument, and must read the same.

Each of the two is at one end of a cable: two pseudo-terminals whose masters are joined here.
"""

import math
import os
import pty
import subprocess
import sys
import threading
import tty

from geocompy.communication import open_serial
from geocompy.geo import GeoCom
from geocompy.geo.gctypes import GeoComCode

# Those of sensing/geocom/examples/geocom.rs: horizontal angle from x to y and elevation; collimation, trunnion axis, index.
TARGET = (0.7, -0.3)
C, I, V0 = 4e-5, -7e-5, 6e-5


def end():
    """A pseudo-terminal: the master, and the name of the other side, which is kept open so that it never hangs up."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    return master, os.ttyname(slave)


def join(a, b):
    def copy(source, sink):
        while data := os.read(source, 4096):
            os.write(sink, data)

    for pair in ((a, b), (b, a)):
        threading.Thread(target=copy, args=pair, daemon=True).start()


def expect(what, got, wanted, tolerance=1e-9):
    off = (got - wanted + math.pi) % math.tau - math.pi
    print(f"{what}: {got:.9f} rad, {off:+.1e} off")
    if abs(off) > tolerance:
        sys.exit(f"{what}: {got} rad, and not {wanted}")


def main():
    (instrument_master, instrument_port), (client_master, client_port) = end(), end()
    join(instrument_master, client_master)
    instrument = subprocess.Popen([sys.argv[1], "instrument", instrument_port], stdout=subprocess.PIPE, text=True)
    try:
        if instrument.stdout.readline() != "ready\n":
            sys.exit("the simulated instrument did not begin")
        test(client_port)
    finally:
        instrument.kill()
        instrument.wait()


def test(port):
    hz, elevation = TARGET
    errors = C / math.cos(elevation) + I * math.tan(elevation)
    with open_serial(port, timeout=30) as connection:
        theirs = GeoCom(connection)
        print("GeoComPy drives:", theirs.csv.get_instrument_name().params)
        for face, sign in ((0, 1.0), (1, -1.0)):
            # Clockwise, and from the zenith on; in the second face half a turn further, through the zenith.
            circle, zenith = -(hz + sign * errors), math.pi / 2 - (elevation + sign * V0)
            if face == 1:
                circle, zenith = circle + math.pi, math.tau - zenith
            about = (circle + 1e-3) % math.tau, zenith - 1e-3
            for answer in (theirs.aut.turn_to(*about, atrmode="TARGET"), theirs.tmc.get_face(), theirs.tmc.get_angle()):
                if answer.error is not GeoComCode.OK:
                    sys.exit(f"not as expected: {answer}")
            got = theirs.tmc.get_angle().params
            expect(f"face {face + 1} Hz", float(got[0]), circle)
            expect(f"face {face + 1} V", float(got[1]), zenith)
            if theirs.tmc.get_face().params.value != face:
                sys.exit("the other face")
        if theirs.aut.change_face().error is not GeoComCode.OK or theirs.tmc.get_face().params.value != 0:
            sys.exit("the face was not changed")
        nothing = theirs.aut.turn_to(1.0, 1.0, atrmode="TARGET")
        if nothing.error is not GeoComCode.AUT_NO_TARGET:
            sys.exit(f"a target where there is none: {nothing}")
        connection.send("tilt")
        tilted = theirs.tmc.get_angle()
        if tilted.error is not GeoComCode.TMC_ANGLE_NO_FULL_CORRECTION:
            sys.exit(f"angles without a compensator: {tilted}")
        connection.send("level")
    ours = subprocess.run([sys.argv[1], "sight", port, str(hz), str(elevation)], capture_output=True, text=True, timeout=60)
    if ours.returncode != 0:
        sys.exit(f"our driver: {ours.stderr}")
    faces = [[float(word) for word in line.split()[1:]] for line in ours.stdout.splitlines()]
    for axis, (name, wanted) in enumerate((("Hz", hz), ("V", elevation))):
        expect(f"our driver, both faces {name}", 0.5 * (faces[0][axis] + faces[1][axis]), wanted, 2e-9)
    print("GeoComPy and our driver read the same")


main()

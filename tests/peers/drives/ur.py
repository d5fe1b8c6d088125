"""SDU's ur-rtde at the controller of mrroc-ur-controller, while the driver of mrroc-ur moves its arm.

Reads joints, tool pose, modes, bits, forces and analog signals, and compares them with what the controller has recorded at the same
timestamps; writes outputs and the slider, and reads them back. The wrench that the cell's sensor reads at the flange is compared with
that of `getActualTCPForce`, turned by the pose that `getActualTCPPose` tells. Prints what it saw as one line of JSON, and ends non-zero where anything falls short.
Where a late machine ended the cell, what needs a run to its end is not tested, and told by name.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from rtde_io import RTDEIOInterface
from rtde_receive import RTDEReceiveInterface

sys.path.append(str(Path(__file__).resolve().parent.parent))
from cell_outcome import Outcome, Shortfall, not_tested  # noqa: E402
from device_priority import urgent  # noqa: E402

HOST = "127.0.0.1"

# How far an arm may go beyond its goals (rad): where the cell left periods out, it goes on at up to 1 rad/s for as long as its driver
# bridges them, and then brakes.
BEYOND, LATE = 1e-3, 0.1
# Of the robot's servos [s].
PERIOD = 0.002

# The tool centre point of the controller (m, rotation vector), and what the surroundings do to its flange (N, N m).
TOOL = (0.03, -0.02, 0.2, 0.4, -0.3, 1.2)
PUSHED = (7.0, -11.0, 30.0, 0.5, -1.5, 2.5)
# What a distance sensor gives at the second standard analog input (A).
DISTANCE = 0.0123
# What the controller has in its installation (kg, m), and what the example's cell says that the flange carries (kg, m, kg m² in UR's
# order xx, yy, zz, xy, xz, yz).
INSTALLED = (0.5, 0.01, 0.0, 0.02)
CARRIED = (1.25, 0.0, 0.0, 0.06, 0.002, 0.002, 0.001, 0.0, 0.0, 0.0)


def rotation(vector):
    """The matrix of a rotation vector, by Rodrigues' formula."""
    angle = math.sqrt(sum(x * x for x in vector))
    if angle < 1e-12:
        return [[float(i == j) for j in range(3)] for i in range(3)]
    x, y, z = (component / angle for component in vector)
    c, s = math.cos(angle), math.sin(angle)
    return [
        [c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
        [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
        [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)],
    ]


def of_flange(pose, wrench):
    """A wrench about the flange, in the axes of the base, turned into those of the flange: R_F = R_TCP R_TOOL^T."""
    tcp, tool = rotation(pose[3:]), rotation(TOOL[3:])
    flange = [[sum(tcp[i][k] * tool[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    turned = [[sum(flange[i][j] * part[i] for i in range(3)) for j in range(3)] for part in (wrench[:3], wrench[3:])]
    return turned[0] + turned[1]


def sample(robot):
    """What it reads now, if nothing has come in between."""
    before = robot.getTimestamp()
    seen = (
        *robot.getActualQ(),
        *robot.getActualQd(),
        *robot.getTargetQ(),
        *robot.getActualTCPPose(),
        robot.getRobotMode(),
        robot.getSafetyMode(),
        robot.getSafetyStatusBits(),
        robot.getRobotStatus(),
        robot.getActualDigitalOutputBits(),
        *robot.getActualTCPForce(),
        robot.getStandardAnalogInput1(),
        robot.getStandardAnalogOutput0(),
        robot.getStandardAnalogOutput1(),
    )
    return (before, seen) if robot.getTimestamp() == before else None


def until(look, seconds=5.0):
    """Whether this comes to be true; the controller has had its time if it does not."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if look():
            return True
        time.sleep(0.002)
    return False


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--controller", required=True)
    parser.add_argument("--samples", type=int, required=True)
    parser.add_argument("--times", type=int, required=True, help="to and fro")
    parser.add_argument("cell", nargs="+", help="the command that runs the cell")
    options = parser.parse_args()
    record = Path(tempfile.mkdtemp()) / "record"
    controller = subprocess.Popen(
        [options.controller, "ur5e", HOST], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, preexec_fn=urgent
    )

    def tell(line):
        controller.stdin.write(line + "\n")
        controller.stdin.flush()

    wrong, samples = [], {}
    try:
        assert controller.stdout.readline().startswith("ur5e at")
        tell(f"record {record}")
        assert controller.stdout.readline().startswith("records")
        robot = RTDEReceiveInterface(HOST)
        writer = RTDEIOInterface(HOST)
        for line in (("tool", *TOOL), ("push", *PUSHED), ("analog", 0.0, DISTANCE, 0.0, 0.0), ("payload", *INSTALLED)):
            tell(" ".join(map(str, line)))
        words = (record.parent / "said").open("w+")
        file = record.parent / "outcome.json"
        command = [*options.cell, "--outcome", file, "--", "--times", str(options.times), "--wrench"]
        cell = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=words, text=True)
        writer.setAnalogOutputVoltage(0, 0.25)
        writer.setAnalogOutputCurrent(1, 0.5)
        # A quarter of 10 V, and the middle of 4 to 20 mA.
        analog = lambda: (robot.getStandardAnalogOutput0(), robot.getStandardAnalogOutput1())
        if not until(lambda: max(abs(a - b) for a, b in zip(analog(), (2.5, 0.012))) < 1e-12):
            wrong.append(f"analog outputs that were written are not read: {analog()}")
        if not until(lambda: robot.getStandardAnalogInput1() == DISTANCE):
            wrong.append("an analog input is not read")
        if not until(lambda: tuple(robot.getActualTCPForce()) == PUSHED):
            wrong.append("the force at the flange is not read")
        writer.setStandardDigitalOut(2, True)
        writer.setToolDigitalOut(1, True)
        if not until(lambda: robot.getActualDigitalOutputBits() == 1 << 2 | 1 << 17):
            wrong.append("digital outputs that were written are not read")
        payload = lambda: (robot.getPayload(), *robot.getPayloadCog(), *robot.getPayloadInertia())
        carried = []
        while cell.poll() is None:
            carried = carried if payload() in carried[-1:] else [*carried, payload()]
            found = sample(robot)
            if found is not None:
                samples[found[0]] = found[1]
            time.sleep(0.001)
        said, _ = cell.communicate()
        words.seek(0)
        told = words.read()
        print(told, end="", file=sys.stderr)
        outcome = Outcome(file, told)
        is_whole = outcome.ended_well(controller=True)
        felt = [line.split()[1:] for line in said.splitlines() if line.startswith("wrench ")]
        turned = of_flange(robot.getActualTCPPose(), robot.getActualTCPForce())
        apart = max(abs(a - float(b)) for a, b in zip(turned, felt[-1])) if felt else None
        # The arm stands by then.
        if is_whole and (apart is None or apart > 1e-6):
            wrong.append(f"the cell's sensor reads {felt}, and ur-rtde {turned}")
        # A payload that changes while its parts are read is of two packages.
        if is_whole and (carried[0][:4] != INSTALLED or CARRIED not in carried):
            wrong.append(f"the payload of the installation, and then that of the cell, are not read: {carried}")
        writer.setStandardDigitalOut(2, False)
        writer.setSpeedSlider(0.25)
        if not until(lambda: robot.getTargetSpeedFraction() == 0.25):
            wrong.append("the slider that was written is not read")
        if not until(lambda: robot.getActualDigitalOutputBits() == 1 << 17):
            wrong.append("a digital output that was written is not read")
        tell("collide")
        if not until(robot.isProtectiveStopped) or robot.getSafetyMode() != 3:
            wrong.append("a protective stop is not read")
        tell("emergency-stop")
        if not until(robot.isEmergencyStopped) or not until(lambda: robot.getRobotMode() == 3):
            wrong.append("an emergency stop, or that the power is off, is not read")
        robot.disconnect()
        writer.disconnect()
        tell("end")
        controller.wait(10)
    finally:
        controller.kill()

    recorded = {}
    for line in record.read_text().splitlines():
        first, *rest = line.split()
        recorded[float(first)] = tuple(map(float, rest))
    differences = [
        max(abs(a - b) for a, b in zip(seen, recorded[stamp])) for stamp, seen in samples.items() if stamp in recorded
    ]
    joints = [seen[0] for seen in samples.values()]
    summary = {
        "samples": len(samples),
        "compared": len(differences),
        "largest_difference": max(differences, default=None),
        "joint_1_rad": [min(joints, default=0.0), max(joints, default=0.0)],
        "wrench_apart": apart,
        "playing": sum(1 for seen in samples.values() if int(seen[27]) & 2),
    }
    print(json.dumps(summary))
    if len(differences) < len(samples):
        wrong.append(f"{len(differences)} samples of {len(samples)} were recorded by the controller")
    if is_whole and len(samples) < options.samples:
        wrong.append(f"{len(samples)} samples were compared, {options.samples} are asked for")
    if max(differences, default=0.0) > 1e-12:
        wrong.append("what ur-rtde reads is not what the controller has recorded")
    # Joint 1 goes from 0 to 0.5 rad and back.
    low, high = min(joints, default=0.0), max(joints, default=0.0)
    if low < -LATE or high > 0.5 + LATE:
        wrong.append(f"joint 1 was moved from {low} to {high} rad, beyond its goals and a stop")
    # In a period that was left out it goes on as fast as it was.
    beyond = BEYOND + outcome.skipped * PERIOD
    if is_whole:
        if max(abs(low), abs(high - 0.5)) > beyond:
            wrong.append(f"joint 1 was not moved by 0.5 rad, but from {low} to {high}")
    else:
        not_tested("ur", f"that joint 1 moves by 0.5 rad and no further (from {low} to {high})", outcome)
    if is_whole:
        if summary["playing"] < len(samples) / 4:
            wrong.append("the script is not read as running")
    else:
        not_tested("ur", "the wrench and the payload of the cell, and that its script runs all the time", outcome)
    print(f"ur: {outcome}")
    sys.exit("ur: " + "; ".join(wrong) if wrong else 0)


if __name__ == "__main__":
    try:
        main()
    except Shortfall as why:
        sys.exit(f"ur: {why}")

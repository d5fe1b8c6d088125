"""A Python program on PyPI's iceoryx2 that subscribes at a cell in real time, and is killed, which the cell does not notice.

In: the example `follow`, built. Out: exit status 0 if what it saw is what the cell recorded, to the bit, and how much it missed.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from sensor import CELL, FOLLOW, Program, bits, cell, ended, env, has, not_tested, nothing_left, stale

from cell_outcome import Shortfall


def modules(folder):
    """The modules of both ports, as the cell makes them."""
    for name, file in (("camera", "camera_port"), ("follow", "follow_port")):
        module = subprocess.run([FOLLOW, "--cell", CELL, "external", name], capture_output=True, check=True)
        (folder / f"{file}.py").write_bytes(module.stdout)


def subscribe(log):
    """Writes down all that it sees, until the cell's program is over."""
    import follow_port as port

    with port.Subscriber() as subscriber, open(log, "w") as seen:
        print("ready", flush=True)
        over = False
        while not over:
            for name, image in subscriber.images():
                words = map(bits, image.measured.joints + image.demanded.joints)
                print(json.dumps(["image", name, image.step, *words]), file=seen)
            for reading in subscriber.readings():
                words = (bits(reading.value.direction), reading.value.seen)
                print(json.dumps(["reading", reading.sensor, reading.step, reading.taken, reading.robot, *words]), file=seen)
            for step in subscriber.steps():
                times = (bits(step.path_time), step.sent, time.monotonic_ns())
                print(json.dumps(["step", step.step, *times]), file=seen)
                over = step.over
            time.sleep(0.005)


def begin(folder, log):
    command = [sys.executable, __file__, "subscribe", str(folder / log)]
    subscriber = subprocess.Popen(command, env=env(folder), stdout=subprocess.PIPE, text=True)
    has(subscriber.stdout.readline() == "ready\n", "it does not begin")
    return subscriber


def recorded(folder):
    from mcap.reader import make_reader

    images, steps, readings = {}, {}, {}
    with open(folder / "run.mcap", "rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            said = json.loads(message.data)
            if channel.topic == "/robots/arm":
                both = said["measured"]["joints"] + said["demanded"]["joints"]
                images[said["step"]] = [bits(number) for number in both]
            elif channel.topic == "/steps":
                steps[said["step"]] = bits(said["dt"])
            elif channel.topic == "/sensors/camera" and said["state"] == "there":
                part = said["reading"]
                readings[said["step"]] = [said["taken"], None, bits(part["direction"]), part["seen"]]
    return images, steps, readings


def tested(folder):
    with Program(folder, "plain") as program:
        first, killed = begin(folder, "seen"), begin(folder, "killed")
        running = cell(folder)
        time.sleep(1.0)
        killed.kill()
        killed.communicate()
        outcome, _ = ended(running, folder)
        is_whole = not stale(outcome, program) and outcome.ended_well()
        try:
            first.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            # The word that the program is over may be lost with the process that has it.
            has(not is_whole, "the subscriber does not hear that the program is over")
            first.kill()
            first.communicate()
    images, steps, readings = recorded(folder)
    seen = [json.loads(line) for line in (folder / "seen").read_text().splitlines()]
    of_arm = {line[2]: line[3:] for line in seen if line[0] == "image"}
    has(set(of_arm) <= set(images), "it saw a step that was not recorded")
    differ = [step for step, words in of_arm.items() if images[step] != words]
    has(not differ, f"steps {differ[:5]} are not those that were recorded")
    of_camera = {line[2]: line[3:] for line in seen if line[0] == "reading"}
    differ = [step for step, words in of_camera.items() if readings.get(step) != words]
    has(not differ, f"readings of steps {differ[:5]} are not those that were recorded")
    # A message may be sent again in the step of a fault or of the end.
    of_cell = {line[1]: line[2] for line in seen if line[0] == "step"}
    has(all(steps.get(step, dt) == dt for step, dt in of_cell.items()), "path times are not those that were recorded")
    # It is nobody's duty to wait for a subscriber.
    if is_whole and outcome.longest_stall < 0.02:
        has(len(of_arm) > len(images) / 2, f"it saw {len(of_arm)} of {len(images)} steps")
        has(len(of_camera) > len(readings) / 2 > 0, f"it saw {len(of_camera)} of {len(readings)} readings")
    else:
        not_tested("external", f"that a subscriber sees most steps (it saw {len(of_arm)} of {len(images)})", outcome)
    late = sorted(line[4] - line[3] for line in seen if line[0] == "step")
    print(
        f"external: a subscriber saw {len(of_arm)} of {len(images)} steps of the arm and {len(of_camera)} of {len(readings)} readings, "
        "equal to the bit; "
        f"{late[len(late) // 2] / 1e6 if late else 0.0:.1f} ms old in the median; another one was killed"
    )


def main():
    with tempfile.TemporaryDirectory(prefix="mrx") as folder:
        folder = Path(folder)
        modules(folder)
        try:
            tested(folder)
            nothing_left(folder)
        except Shortfall as why:
            sys.exit(f"external: subscriber: {why}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["subscribe"]:
        subscribe(sys.argv[2])
    else:
        main()

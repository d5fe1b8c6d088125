"""How soon robots stand when a hold ends, from a recording: `holds.py RECORDING TRIALS STOP_MS`.

In: the recording of a cell of processes; a JSON list of trials, each with its way to end the hold and a window of dates [ns]; the longest stop on the path that `--check` prints [ms]. Out: a JSON object on standard output, for each way how
many trials were good, bad (with why) and void: a hold that moved nothing, or a machine so late that the cell left out steps meanwhile, or that got no
processor at the end of the hold and was late by that.

A hold ends when the panel's server receives the release, or 300 ms after the last renewal that it received, whichever is first. (From
290 ms on the server itself lets it go: it received nothing then.) The rate of path time must fall to 0 without rising again within the stop; in
which step from then on it begins to fall is told. From then on robots are demanded at one place, keep within 0.05 rad of it, and stand there at the end of the window.
"""

import json
import re
import sys

from mcap.reader import make_reader

LAPSE = 300_000_000
# From so long after the last renewal on it is the panel that lets a hold go.
OWN = 285_000_000
# A recording's dates are late by what its first entry took to the recorder; trials are a second apart.
DATES = 100_000_000
# What is a standstill: the greatest distance between a joint and where it is demanded to stand [rad], and its speed once it is there [rad/s],
# over 20 ms: in one period a single count of an encoder is 2e-3 rad/s.
DRIFT, STILL, OVER = 0.05, 1e-3, 20_000_000


class Void(Exception):
    """Nothing can be said of this trial."""


class Bad(Exception):
    """What was promised was not kept."""


def read(path):
    steps, commands, images = [], [], {}
    with open(path, "rb") as file:
        reader = make_reader(file)
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        start, period = int(metadata["mrroc.start"]["start_ns"]), int(metadata["mrroc"]["step_ns"])
        for _, channel, message in reader.iter_messages():
            time = message.log_time - start
            topic = channel.topic
            if topic == "/steps":
                steps.append((time, json.loads(message.data)))
            elif topic == "/commands":
                commands.append(json.loads(message.data))
            elif re.fullmatch(r"/robots/\w+", topic):
                data = json.loads(message.data)
                images.setdefault(data["step"], []).append((topic, time, data["demanded"]["joints"], data["measured"]))
    # Each process sends its own records.
    steps.sort(key=lambda of: of[0])
    return steps, commands, images, start, period


def test(trial, steps, commands, images, period, stop):
    begin, end = trial["from"], trial["to"]
    holds = [c for c in commands if c["command"].startswith("jog ") and begin <= c["asked"] <= end]
    begun = [c for c in holds if c["command"].split()[2] == "0" and c["outcome"] == "done"]
    if not begun:
        raise Void("no hold began")
    hold = begun[-1]["command"].split()[1]
    renewals = [c["asked"] for c in holds if c["command"].split()[1] == hold]
    released = [c["asked"] for c in commands if c["command"] == f"let-go {hold}"]
    event = min([max(renewals) + LAPSE, *(at for at in released if at < max(renewals) + OWN)])
    times = [time for time, _ in steps]
    dt = [step["dt"] for _, step in steps]
    last, told = (max((i for i, time in enumerate(times) if time <= when), default=None) for when in (event, min([event, *released])))
    if told is None or dt[told] == 0:
        raise Void("nothing moved when it ended")
    fall = next((i for i in range(told + 1, len(dt)) if dt[i] < dt[i - 1]), None)
    rest = fall and next((i for i in range(fall, len(dt)) if dt[i] == 0), None)
    if rest is None or times[rest] > end:
        raise Bad("the robots did not come to rest")
    left_out = [i for i in range(told, rest + 1) if steps[i][1]["duration"] * 1e9 > 1.5 * period]
    if left_out:
        raise Void("the machine was late: steps were left out")
    if any(dt[i] > dt[i - 1] for i in range(fall + 1, rest + 1)):
        raise Bad("the rate rose again")
    stopped = (times[rest] - times[fall]) * 1e-6
    if stopped > stop:
        raise Bad(f"it took {stopped:.0f} ms to stop, of {stop:.0f}")
    # All robots stand from then on, until another hold begins: demanded at one place, measured to come to it and to stay there.
    first, after = steps[rest][1]["step"] + 2, [c["asked"] for c in commands if c["asked"] > event and c["command"].startswith(("jog ", "hold "))]
    until = min([end, *after])
    stands, drift, ways = {}, 0.0, {}
    for step in sorted(images):
        for robot, time, demanded, measured in images[step]:
            if step < first or time >= until:
                continue
            if stands.setdefault(robot, demanded) != demanded:
                raise Bad(f"{robot} was demanded elsewhere at step {step}, at rest from {first} on")
            drift = max(drift, *(abs(one - other) for one, other in zip(measured["joints"], demanded)))
            ways.setdefault(robot, []).append((time, measured["joints"]))
    speed = 0.0
    for way in ways.values():
        last_seen, at = way[-1]
        earlier = [(time, joints) for time, joints in way if time <= last_seen - OVER]
        if not earlier:
            raise Void("too little is recorded of robots at rest")
        speed = max(speed, *(abs(one - other) / (1e-9 * (last_seen - earlier[-1][0])) for one, other in zip(at, earlier[-1][1])))
    if not ways:
        raise Void("nothing is recorded of robots at rest")
    if drift > DRIFT:
        raise Bad(f"a joint was measured {drift} rad from where it was demanded to stand")
    if speed > STILL:
        raise Bad(f"a joint was measured at {speed} rad/s at last")
    return {"steps": fall - last, "fell_ms": (times[fall] - event) * 1e-6, "stopped_ms": stopped, "taken": trial["taken"]}


def main():
    steps, commands, images, start, period = read(sys.argv[1])
    trials, stop = json.load(open(sys.argv[2])), float(sys.argv[3])
    found = {}
    for trial in trials:
        # By the cell's time.
        trial["from"], trial["to"] = trial["from"] - start - DATES, trial["to"] - start
        of = found.setdefault(trial["way"], {"good": [], "bad": [], "void": []})
        try:
            of["good"].append(test(trial, steps, commands, images, period, stop))
        except Void as why:
            of["void"].append(str(why))
        except Bad as why:
            of["bad"].append(str(why))
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main()

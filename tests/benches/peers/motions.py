"""Prints what lines, circles and plans take here, in KDL and in Ruckig (see motions), with the ratio to ours."""

import pathlib
import platform
import sys

ROWS = [
    ("line pose", "line: pose", "kdl", "line pose"),
    ("line derivatives", "line: pose, velocity, acceleration", "kdl", "line derivatives"),
    ("circle pose", "circle: pose", "kdl", "circle pose"),
    ("circle derivatives", "circle: pose, velocity, acceleration", "kdl", "circle derivatives"),
    ("rest_6", "plan, 6 axes, rest to rest", "ruckig", "rest_6"),
    ("random_6", "plan, 6 axes, state to velocity", "ruckig", "random_6"),
    ("random_7", "plan, 7 axes, state to velocity", "ruckig", "random_7"),
    ("at_6", "6 axes at an instant", "ruckig", "at_6"),
    ("update_same", "step of 6 axes, same target", "ruckig", "update_same"),
    ("update_changed", "step of 6 axes, new target each time", "ruckig", "update_changed"),
    ("reach_same", "the same as a generator, same target", "ruckig", "update_same"),
    ("reach_changed", "the same as a generator, new target", "ruckig", "update_changed"),
    ("spline_point", "spline point by length, 25 a span", None, None),
]


def read(folder, name):
    """What was measured, the least of all rounds, and the sums that say that the inputs are the same."""
    times, sums = {}, {}
    for path in sorted(folder.glob(f"{name}.[0-9].txt")):
        for line in path.read_text().splitlines():
            words = line.split()
            if "sum" in words:
                at = words.index("sum")
                sums[" ".join(words[:at])] = [float(word) for word in words[at + 1 :]]
            elif "points" not in words:
                what, value = " ".join(words[:-1]), float(words[-1])
                times[what] = min(value, times.get(what, value))
    return times, sums


def main():
    folder = pathlib.Path(sys.argv[1])
    cpu = [line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    print(f"machine: {cpu[0]}, {len(cpu)} cores, {platform.system()} {platform.release()}\n")
    ours, our_sums = read(folder, "mrroc-motion")
    peers = {"kdl": "KDL 1.5", "ruckig": "Ruckig 0.19.4"}
    theirs = {}
    for peer, name in peers.items():
        theirs[peer], sums = read(folder, f"{peer}-motion")
        for what, values in sums.items():
            # Durations and positions: of the same motions to what double precision leaves.
            if any(abs(a - b) > 2e-9 * (1 + abs(b)) for a, b in zip(values, our_sums[what])):
                sys.exit(f"{name} does something else: {what} sums to {values}, here to {our_sums[what]}")
    print(f"{'what':42}{'mrroc [ns]':>12}{'peer [ns]':>12}{'ratio':>9}  peer")
    for key, title, peer, their_key in ROWS:
        if peer is None:
            print(f"{title:42}{ours[key]:12.1f}{'-':>12}{'-':>9}")
            continue
        nanoseconds = theirs[peer][their_key]
        print(f"{title:42}{ours[key]:12.1f}{nanoseconds:12.1f}{nanoseconds / ours[key]:8.1f}x  {peers[peer]}")
    print(f"\nraw figures: {folder}/{{mrroc,kdl,ruckig}}-motion.*.txt")


if __name__ == "__main__":
    main()

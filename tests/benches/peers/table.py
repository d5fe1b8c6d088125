"""Prints what the peers measured (see run), side by side, with the ratio to this project's figure."""

import pathlib
import platform
import sys

PEERS = {"kdl": "KDL 1.5 (C++)", "pinocchio": "Pinocchio 4.1 (C++)", "rs-opw": "rs-opw-kinematics 3.0"}
TASKS = {
    "forward": "FK",
    "jacobian": "Jacobian",
    "inverse_nearest": "IK, nearest",
    "inverse_all": "IK, all solutions",
}
SAME_TASK = {
    "jacobian_by_joint_Jacobians": "jacobian",
    "inverse_NR_JL_1e-6": "inverse_nearest",
    "inverse_LMA_1e-8": "inverse_nearest",
    "inverse_GaussNewton_1e-8": "inverse_nearest",
    "inverse_continuing": "inverse_nearest",
}


def read(folder, name):
    """The lines of three rounds as words; times are the least of the three."""
    rounds = [path.read_text().splitlines() for path in sorted(folder.glob(f"{name}.[0-9].txt"))]
    for lines in zip(*rounds):
        words = [line.split() for line in lines]
        if "sum" not in words[0] and "solved" not in words[0]:
            words[0][-1] = min((line[-1] for line in words), key=float)
        yield words[0]


def main():
    folder = pathlib.Path(sys.argv[1])
    cpu = [line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    print(f"machine: {cpu[0]}, {len(cpu)} cores, {platform.system()} {platform.release()}")
    ours, own_sum, robots = {}, None, {}
    for arm, what, *values in read(folder, "mrroc"):
        if what == "sum":
            own_sum = values if arm == "ortho_parallel" else own_sum
            continue
        robots.setdefault(arm, {})[what] = float(values[0])
    ours = robots["ortho_parallel"]
    print("\northo_parallel.urdf (6R, lengths of the IRB 2400/10), seeds within 0.01 rad\n")
    print(f"{'task':20}{'library':46}{'ns':>10}{'ratio':>9}{'solved':>9}")
    rows = [(task, "mrroc", ours[task], "") for task in TASKS]
    for peer, name in PEERS.items():
        lines = list(read(folder, peer))
        solved = {line[1]: line[2] + " %" for line in lines if line[0] == "solved"}
        for what, *values in lines:
            if what == "sum":
                if any(abs(float(a) - float(b)) > 1e-6 for a, b in zip(values, own_sum)):
                    sys.exit(f"{name} moves another arm: positions sum to {values}, here to {own_sum}")
            elif what != "solved":
                task = SAME_TASK.get(what, what)
                method = "" if what in TASKS else ", " + what.removeprefix(task.split("_")[0] + "_").replace("_", " ")
                rows.append((task, name + method, float(values[0]), solved.get(what, "")))
    for task, title in TASKS.items():
        for of, library, nanoseconds, solved in rows:
            if of == task:
                ratio = f"{nanoseconds / ours[task]:8.1f}x"
                print(f"{title:20}{library:46}{nanoseconds:10.1f}{ratio}{solved:>9}")
    print("\nour robots [ns]\n")
    columns = TASKS | {"refusal": "IK, out of reach"}
    print(f"{'robot':20}" + "".join(f"{title:>20}" for title in columns.values()))
    for arm, times in robots.items():
        print(f"{arm:20}" + "".join(f"{times[t]:20.1f}" if t in times else f"{'-':>20}" for t in columns))
    print("\nraw figures: " + ", ".join(str(folder / f"{name}.*.txt") for name in ["mrroc", *PEERS]))


if __name__ == "__main__":
    main()

"""Plans MotionBenchMaker's problems with VAMP: RRT-Connect and simplification, by VAMP's own settings for the robot, on one thread.

Usage: vamp_paths.py PROBLEMS PATHS [--rounds N], with a file of problems.py. Writes the paths after simplification to PATHS, a JSON line each:
set, index, joints (a list of way points). Only problems that VAMP calls valid are planned.

All problems are planned once unmeasured, then N times (5). The time of a problem is the median of its rounds; the seed is the same in each (VAMP's
Halton sequence from its start), so that only the machine varies. Prints a JSON line for each set, and one for `all`:

- planner, robot, set, problems: how many were planned, solved: their share in which a path was found
- plan_us, simplify_us, total_us: VAMP's own clock [us]; what it allocates before it starts that clock is not in it
- wall_us: both calls with that, and with what Python adds [us]
- cost_before, cost_after: length of the path in joint space [rad] (Euclidean), before and after simplification

Times and lengths have median, p95 and mean.
"""

import argparse
import json
import statistics
import time

import numpy as np
import problems
import vamp


def figures(values):
    if not values:
        return None
    return {"median": float(np.median(values)), "p95": float(np.percentile(values, 95)), "mean": float(np.mean(values))}


def plan(robot, planner, settings, simplification, problem, world):
    """One plan: times [us] by VAMP's clock and by ours, costs [rad], way points; None without a path."""
    sampler = robot.halton()
    sampler.reset()
    before = time.perf_counter_ns()
    found = planner(problem["start"], problem["goals"], world, settings, sampler)
    if not found.solved:
        return None
    short = robot.simplify(found.path, world, simplification, sampler)
    wall = (time.perf_counter_ns() - before) / 1e3
    times = found.nanoseconds / 1e3, short.nanoseconds / 1e3, (found.nanoseconds + short.nanoseconds) / 1e3, wall
    return times, (found.path.cost(), short.path.cost()), [[float(x) for x in np.asarray(point)] for point in short.path.numpy()]


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("problems")
    arguments.add_argument("paths")
    arguments.add_argument("--rounds", type=int, default=5)
    given = arguments.parse_args()
    with open(given.problems) as file:
        name = json.loads(next(file))["robot"]
        todo = [problem for problem in map(json.loads, file) if problem["valid"]]
    robot, planner, settings, simplification = vamp.configure_robot_and_planner_with_kwargs(name, "rrtc")
    worlds = [problems.environment(problem) for problem in todo]
    rounds = []
    for _ in range(1 + given.rounds):
        rounds.append([plan(robot, planner, settings, simplification, *each) for each in zip(todo, worlds)])
    results = {}
    with open(given.paths, "w") as file:
        for problem, *runs in zip(todo, *rounds[1:]):
            of = results.setdefault(problem["set"], [])
            if runs[0] is None:
                of.append(None)
                continue
            times = [statistics.median(run[0][i] for run in runs) for i in range(4)]
            of.append((*times, *runs[0][1]))
            file.write(json.dumps({"set": problem["set"], "index": problem["index"], "joints": runs[0][2]}) + "\n")
    results["all"] = [result for of in results.values() for result in of]
    for of, found in results.items():
        solved = [result for result in found if result]
        line = {"planner": "vamp", "robot": name, "set": of, "problems": len(found), "solved": len(solved) / len(found)}
        names = ("plan_us", "simplify_us", "total_us", "wall_us", "cost_before", "cost_after")
        print(json.dumps(line | {key: figures([result[i] for result in solved]) for i, key in enumerate(names)}))


if __name__ == "__main__":
    main()

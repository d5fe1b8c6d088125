"""Time of Ruckig (PyPI `ruckig`, 0.19.4) for a plan of six axes, beside `cargo bench -p mrroc-generators --bench jerk`.

The cases are of the same kind, drawn anew; a call through the Python binding is counted in, some tenths of a microsecond.
"""
import random
import time

import ruckig

random.seed(3)


def cases(moving):
    def uniform(size):
        return [size * random.uniform(-1.0, 1.0) for _ in range(6)]

    drawn = []
    for _ in range(3000):
        given = ruckig.InputParameter(6)
        given.current_position, given.target_position = uniform(2.0), uniform(2.0)
        given.current_velocity, given.target_velocity = uniform(0.6 * moving), uniform(0.6 * moving)
        given.current_acceleration = uniform(2.0 * moving)
        given.max_velocity, given.max_acceleration, given.max_jerk = [1.0] * 6, [4.0] * 6, [20.0] * 6
        drawn.append(given)
    return drawn


planner, trajectory = ruckig.Ruckig(6), ruckig.Trajectory(6)
for name, moving in [("rest to rest", 0.0), ("state to velocity", 1.0)]:
    drawn, best = cases(moving), float("inf")
    for _ in range(30):
        start = time.perf_counter()
        for given in drawn:
            planner.calculate(given, trajectory)
        best = min(best, (time.perf_counter() - start) / len(drawn))
    print(f"ruckig, plan of 6 axes, {name}: {best * 1e9:.0f} ns")

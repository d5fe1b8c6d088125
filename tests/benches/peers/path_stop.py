"""The time of a stop on the path of a joint with a jerk limit, in the phase plane of rate and its fall.

Bounds beside a path at its velocity limit that uses 0.9 of the acceleration and jerk limits, of which 0.98 are used in all:
the fall x of the rate r by the acceleration, (0.98 - 0.9 r^2) a / v, and by half of the jerk, 0.5 (0.98 - 0.9 r^3) j /
(2.7 a r), and 5 / s; its change by the other half, 0.5 (0.98 - 0.9 r^3) j / v. The fastest stop goes from (1, 0) along the
largest change, on the largest fall, and into (0, 0) along the largest change: x dx = change dr. Its time is the integral
of dr / x. Data for `a_stop_on_the_path_takes_the_time_that_the_limits_leave`.
"""

import math

N = 400_000


def stop_time(v, a, j):
    grid = [i / N for i in range(N + 1)]
    fall = [
        min((0.98 - 0.9 * r**2) * a / v, 0.5 * (0.98 - 0.9 * r**3) * j / (2.7 * a * max(r, 1e-12)), 5.0)
        for r in grid
    ]
    change = [0.5 * (0.98 - 0.9 * r**3) * j / v for r in grid]
    down = fall[:]
    down[N] = 0.0
    for i in range(N - 1, -1, -1):
        down[i] = min(fall[i], math.sqrt(down[i + 1] ** 2 + 2 * change[i] / N))
    x = down[:]
    x[0] = 0.0
    for i in range(1, N + 1):
        x[i] = min(down[i], math.sqrt(x[i - 1] ** 2 + 2 * change[i] / N))
    # Within a piece the fall changes evenly in time: its mean is that of both ends.
    return sum(2 / N / (x[i] + x[i + 1]) for i in range(N))


for limits in [(1.0, 10.0, 100.0), (2.62, 10.0, 5000.0)]:
    print(*limits, f"{stop_time(*limits):.4f}")

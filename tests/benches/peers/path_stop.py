"""The time of a stop on the path of a joint with a jerk limit, in the phase plane of rate and its fall.

Bounds beside a path at its velocity limit that uses 0.9 of the acceleration and jerk limits, of which 0.98 are used in all:
the fall x of the rate r by the acceleration, (0.98 - 0.9 r^2) a / v, and by half of the jerk, 0.5 (0.98 - 0.9 r^3) j /
(2.7 a r), and 5 / s; its change by the other half, 0.5 (0.98 - 0.9 r^3) j / v. The fastest stop goes from (1, 0) along the
largest change, on the largest fall, and into (0, 0) along the largest change: x dx = change dr. Its time is the integral
of dr / x.

A rate that still rises takes longer: from below 1 it may rise by at most sqrt(2 b (1 - r)), from which it lands at 1 by
b, the least of 0.04 j / v, 0.144 (a / v)^2 and 0.2224 (j / 5.4 a)^2. It is turned round by the largest change first. Data for `a_stop_on_the_path_takes_the_time_that_the_limits_leave`.
"""

import math

N = 100_000


def fall_from(v, a, j):
    """The time of the stop from each rate of a grid, at which it does not change yet."""
    grid = [i / N for i in range(N + 1)]
    fall = [
        min((0.98 - 0.9 * r**2) * a / v, 0.5 * (0.98 - 0.9 * r**3) * j / (2.7 * a * max(r, 1e-12)), 5.0)
        for r in grid
    ]
    change = [0.5 * (0.98 - 0.9 * r**3) * j / v for r in grid]
    into_zero = fall[:]
    into_zero[0] = 0.0
    for i in range(1, N + 1):
        into_zero[i] = min(fall[i], math.sqrt(into_zero[i - 1] ** 2 + 2 * change[i] / N))

    def time(top):
        x = into_zero[: top + 1]
        x[top] = 0.0
        for i in range(top - 1, -1, -1):
            x[i] = min(x[i], math.sqrt(x[i + 1] ** 2 + 2 * change[i] / N))
        # Within a piece the fall changes evenly in time: its mean is that of both ends.
        return sum(2 / N / (x[i] + x[i + 1]) for i in range(top))

    return time


def stop_time(v, a, j):
    time = fall_from(v, a, j)
    least = min(0.04 * j / v, 0.144 * (a / v) ** 2, 0.2224 * (j / (5.4 * a)) ** 2)
    longest = time(N)
    for k in range(1, 33):
        rate = 1 - (k / 64) ** 2
        x, turning, dt = math.sqrt(2 * least * (1 - rate)), 0.0, 1e-6
        while x > 0:
            rate += x * dt
            x -= 0.5 * (0.98 - 0.9 * rate**3) * j / v * dt
            turning += dt
        longest = max(longest, turning + time(round(rate * N)))
    return longest


for limits in [(1.0, 10.0, 100.0), (2.62, 10.0, 5000.0)]:
    print(*limits, f"{stop_time(*limits):.4f}")

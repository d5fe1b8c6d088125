"""Stability margins of the servo loops of the simulated robots (RNT has the drives of the IRp-6).

Per motor: the published regulator on the position error, C(z) = (b0 - b1/z)(1.010 - 0.990/z) /
((1 - 1/z)(1 - a/z)), and the linear part of the plant, K / (s (s + p)) behind a zero-order hold of 2 ms.
Prints crossover [rad/s], phase margin [deg], gain margin and the magnitudes of the closed-loop poles.

Usage: python3 servo_margins.py
"""

import numpy as np

T, VOLTS_PER_PWM = 0.002, 96 / 255
# pulses/rev, a, b0, b1, R [ohm], k [N m/A], J [kg m^2]: as in `Irp6::MOTORS`, `Irp6Track::TRACK_MOTOR`, ...
MOTORS = {
    "column": (4000, 0.429, 6.834, 6.606, 3.66, 0.20, 2.5e-3),
    "lower": (4000, 0.64, 2.49, 2.385, 2.80, 0.20, 2.2e-3),
    "upper": (4000, 0.333, 5.693, 5.427, 5.30, 0.20, 1.2e-3),
    "T": (4000, 0.56, 3.99, 3.775, 6.50, 0.18, 9e-4),
    "V": (4000, 0.39, 4.31, 3.945, 6.50, 0.18, 7e-4),
    "N": (2000, 0.39, 4.31, 3.945, 6.50, 0.18, 3.5e-4),
    "track": (4000, 0.333, 6.2, 5.933, 4.16, 0.20, 2.2e-3),
    "polycrank": (128, 0.429, 6.834, 6.606, 1.46, 0.02, 2e-5),
    "gripper": (128, 0.39, 4.31, 3.945, 60.0, 0.02, 4e-7),
    "conveyor": (4000, 0.429, 6.834, 6.606, 45.7, 0.1, 1e-4),
}

for name, (pulses, a, b0, b1, r, k, j) in MOTORS.items():
    p = k * k / (r * j)
    gain = VOLTS_PER_PWM * k / (r * j) * pulses / (2 * np.pi)
    e = np.exp(-p * T)
    plant_num = gain / p**2 * np.array([0, p * T - 1 + e, 1 - e - p * T * e])
    plant_den = np.convolve([1, -1], [1, -e])
    num = np.convolve(np.convolve([b0, -b1], [1.010, -0.990]), plant_num)
    den = np.convolve(np.convolve([1, -1], [1, -a]), plant_den)
    w = np.logspace(1.5, np.log10(np.pi / T * 0.999), 40000)
    z = np.exp(-1j * w * T)
    loop = np.polyval(num[::-1], z) / np.polyval(den[::-1], z)
    cross = np.flatnonzero(np.diff(np.sign(abs(loop) - 1)))[0]
    phase = np.degrees(np.angle(loop[cross])) % 360 - 180
    turn = [i for i in np.flatnonzero(np.diff(np.sign(loop.imag))) if loop.real[i] < 0]
    closed = np.zeros(max(len(num), len(den)))
    closed[: len(num)] += num
    closed[: len(den)] += den
    poles = sorted(np.round(abs(np.roots(closed)), 3).tolist(), reverse=True)
    margins = [round(float(1 / abs(loop[i])), 1) for i in turn]
    print(f"{name:9s} crossover {w[cross]:.0f} rad/s, phase margin {phase:.0f} deg, gain margin {margins}, poles {poles}")

"""Points of Figure 6 by a loop in Numba: classical Runge-Kutta steps of fixed length, cut off where the mode of the
contact changes. The model is written here anew from Stelter 1992, eqs. (1)-(7)."""

from math import exp

import numpy as np
from numba import njit
from sweep_heyoka import D, F_N, LIMIT, M, MOBILITY, MU0, PHI, W, start

(W1, W2), (D1, D2), (PHI1, PHI2) = W, D, PHI
# A slip that begins at rest has not arrived before it has gone, in m/s.
GONE = 1e-11
ONCE = {"fastmath": True, "inline": "always"}


@njit(**ONCE)
def free(x):
    return -2 * D1 * W1 * x[1] - W1 * W1 * x[0], -2 * D2 * W2 * x[3] - W2 * W2 * x[2]


@njit(**ONCE)
def constraint_force(x):
    a1, a2 = free(x)
    return -(PHI1 * a1 + PHI2 * a2) / MOBILITY


@njit(**ONCE)
def rates(x, mode, v0):
    a1, a2 = free(x)
    if mode == 0.0:
        force = -(PHI1 * a1 + PHI2 * a2) / MOBILITY
    else:
        speed = mode * (PHI1 * x[1] + PHI2 * x[3] - v0)
        mu = MU0 * (0.5 + 0.5 * exp(-speed / 0.02)) * (0.5 + 0.5 * exp(-0.25 * speed))
        force = -mode * mu * F_N
    return x[1], a1 + PHI1 / M * force, x[3], a2 + PHI2 / M * force


@njit(**ONCE)
def ahead(x, k, h):
    return x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2], x[3] + h * k[3]


@njit(**ONCE)
def step(x, h, mode, v0):
    k1 = rates(x, mode, v0)
    k2 = rates(ahead(x, k1, 0.5 * h), mode, v0)
    k3 = rates(ahead(x, k2, 0.5 * h), mode, v0)
    k4 = rates(ahead(x, k3, h), mode, v0)
    x = ahead(ahead(x, k1, h / 6), k2, h / 3)
    return ahead(ahead(x, k3, h / 3), k4, h / 6)


@njit(**ONCE)
def margin(x, mode, v0):
    """What is left until the mode ends."""
    if mode == 0.0:
        return LIMIT - abs(constraint_force(x))
    return mode * (PHI1 * x[1] + PHI2 * x[3] - v0)


@njit
def gap(x, mode, v0, turns):
    return PHI1 * x[1] + PHI2 * x[3] if turns else margin(x, mode, v0)


@njit
def located(x, h, mode, v0, turns):
    """Length of the step at whose end the margin, or the tip's velocity, is zero: false position (Illinois)."""
    low, high = 0.0, h
    f_low, f_high = gap(x, mode, v0, turns), gap(step(x, h, mode, v0), mode, v0, turns)
    side = 0
    for _ in range(60):
        if high - low < 1e-17 or f_low == f_high:
            break
        middle = high - f_high * (high - low) / (f_high - f_low)
        f = gap(step(x, middle, mode, v0), mode, v0, turns)
        if f > 0.0:
            low, f_low = middle, f
            if side == 1:
                f_high *= 0.5
            side = 1
        else:
            high, f_high = middle, f
            if side == -1:
                f_low *= 0.5
            side = -1
        if f == 0.0:
            break
    return high


@njit
def point(x, v0, h, stop, peaks):
    """Fills the peaks (time, displacement) up to `stop`; their number."""
    # Time is counted in steps since the last event: a sum of millions of steps would drift by its rounding.
    since, steps, t = 0.0, 0, 0.0
    mode, departed, count = 0.0, True, 0
    while t < stop and count < len(peaks):
        length = h
        after = step(x, h, mode, v0)
        left = margin(after, mode, v0)
        ends = left < 0.0 and departed
        if ends:
            length = located(x, h, mode, v0, False)
            after = step(x, length, mode, v0)
        if PHI1 * x[1] + PHI2 * x[3] > 0.0 and PHI1 * after[1] + PHI2 * after[3] <= 0.0:
            turn = located(x, length, mode, v0, True)
            top = step(x, turn, mode, v0)
            peaks[count, 0] = t + turn
            peaks[count, 1] = PHI1 * top[0] + PHI2 * top[2]
            count += 1
        steps += 1
        t = since + steps * h
        if ends:
            since, steps = t - h + length, 0
            t = since
        x = after
        departed = departed or left > GONE
        if ends:
            force = constraint_force(x)
            if mode == 0.0 or abs(force) > LIMIT:
                mode = -1.0 if force > 0.0 else 1.0
                departed = False
            else:
                mode = 0.0
                departed = True
    return count


class Loop:
    """One point after the other in steps of `h` seconds."""

    def __init__(self, h):
        self.h = h

    def run(self, velocities, ends):
        found = []
        for v0, end in zip(velocities, ends):
            peaks = np.zeros((1000, 2))
            count = point(tuple(start(v0)), v0, self.h, end, peaks)
            found.append(peaks[:count])
        return found

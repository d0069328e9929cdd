"""The default case in heyoka: adaptive Taylor integration with terminal events.

Computes it once for every line on its input and answers with the time in ms. The model is written here anew from
Stelter 1992, eqs. (1)-(7): two modes, 100 N, 0.10 m/s, 2 s, 132 transitions. Compilation is not counted; tolerance
1e-9 (first argument changes it).
"""
import sys
import time

import heyoka as hy
import numpy as np

TOLERANCE = float(sys.argv[1]) if len(sys.argv) > 1 else 1e-9
F_N, V0, M, STOP = 100.0, 0.1, 0.427, 2.0
W = [2 * np.pi * 80.0, 2 * np.pi * 510.0]
D = [0.00015, 0.00085]
PHI = [2.0, -2.0]
MU0 = 0.66
START = [0.0011623313477705246, 0.05, -2.8600233086241277e-05, 0.0]

q1, p1, q2, p2 = hy.make_vars("q1", "p1", "q2", "p2")
q, p = [q1, q2], [p1, p2]
tip_velocity = PHI[0] * p1 + PHI[1] * p2
v_r = tip_velocity - V0
free = [-2 * D[j] * W[j] * p[j] - W[j] ** 2 * q[j] for j in range(2)]
constraint = -(PHI[0] * free[0] + PHI[1] * free[1]) / (PHI[0] ** 2 / M + PHI[1] ** 2 / M)


def rates(force):
    return [(q1, p1), (p1, free[0] + PHI[0] / M * force), (q2, p2), (p2, free[1] + PHI[1] / M * force)]


def mu(speed):
    return MU0 * (0.5 + 0.5 * hy.exp(-speed / 0.02)) * (0.5 + 0.5 * hy.exp(-0.25 * speed))


def event(expression):
    return hy.t_event(expression, direction=hy.event_direction.negative)


def integrator(force, events):
    return hy.taylor_adaptive(rates(force), START, tol=TOLERANCE, t_events=events)


LIMIT = MU0 * F_N
SLIP = {
    -1: integrator(mu(-v_r) * F_N, [event(-v_r)]),
    +1: integrator(-mu(v_r) * F_N, [event(v_r)]),
}
STICK = integrator(constraint, [event(LIMIT - constraint), event(LIMIT + constraint)])


def constraint_force(x):
    a = [-2 * D[j] * W[j] * x[2 * j + 1] - W[j] ** 2 * x[2 * j] for j in range(2)]
    return -(PHI[0] * a[0] + PHI[1] * a[1]) / (PHI[0] ** 2 / M + PHI[1] ** 2 / M)


def run():
    t, x, mode, count = 0.0, np.array(START), 0, 0
    while True:
        ta = STICK if mode == 0 else SLIP[mode]
        ta.time = t
        ta.state[:] = x
        ta.reset_cooldowns()
        outcome = ta.propagate_until(STOP)[0]
        t, x = ta.time, ta.state.copy()
        if outcome == hy.taylor_outcome.time_limit:
            return count
        count += 1
        force = constraint_force(x)
        if mode != 0 and abs(force) <= LIMIT:
            mode = 0
        else:
            mode = -1 if force > 0 else 1


for _ in sys.stdin:
    begun = time.perf_counter()
    transitions = run()
    elapsed = time.perf_counter() - begun
    if TOLERANCE <= 1e-9 and transitions != 132:
        sys.exit(f"{transitions} transitions instead of 132")
    print(f"{elapsed * 1e3:.4f}", flush=True)

"""Points of Figure 6 in heyoka: adaptive Taylor integration, modes of the contact switched at terminal events, peaks at
a non-terminal event; one point at a time, or several in the lanes of its batch mode.

The model is written here anew from Stelter 1992, eqs. (1)-(7). The belt's velocity is a parameter of the compiled code,
so that one compilation serves all points.
"""

import heyoka as hy
import numpy as np

F_N, M, MU0 = 100.0, 0.427, 0.66
W = [2 * np.pi * 80.0, 2 * np.pi * 510.0]
D = [0.00015, 0.00085]
PHI = [2.0, -2.0]
LIMIT = MU0 * F_N
MOBILITY = PHI[0] ** 2 / M + PHI[1] ** 2 / M

q1, p1, q2, p2 = hy.make_vars("q1", "p1", "q2", "p2")
TIP_VELOCITY = PHI[0] * p1 + PHI[1] * p2
V_R = TIP_VELOCITY - hy.par[0]


def start(v0):
    """In stick, the beam bent by 0.95 of the break-away force and moving with the belt in the same shape."""
    share = [PHI[j] / (M * W[j] ** 2) for j in range(2)]
    compliance = sum(PHI[j] * share[j] for j in range(2))
    return [x for s in share for x in (0.95 * LIMIT * s, v0 * s / compliance)]


def free(j, q, p):
    return -2 * D[j] * W[j] * p - W[j] ** 2 * q


def constraint_force(x1, y1, x2, y2):
    return -(PHI[0] * free(0, x1, y1) + PHI[1] * free(1, x2, y2)) / MOBILITY


CONSTRAINT = constraint_force(q1, p1, q2, p2)


def mu(speed):
    return MU0 * (0.5 + 0.5 * hy.exp(-speed / 0.02)) * (0.5 + 0.5 * hy.exp(-0.25 * speed))


def rates(force):
    return [
        (q1, p1),
        (p1, free(0, q1, p1) + PHI[0] / M * force),
        (q2, p2),
        (p2, free(1, q2, p2) + PHI[1] / M * force),
    ]


def mode_after_slip(x):
    force = constraint_force(*x)
    if abs(force) <= LIMIT:
        return 0
    return -1 if force > 0 else 1


FALLING = hy.event_direction.negative


class Scalar:
    """One point after the other; an integrator for each mode, so that none computes what it does not need."""

    def __init__(self, tolerance, real=float):
        self.peaks = []
        self.real = real

        def peak(ta, time, _):
            ta.update_d_output(time)
            x = ta.d_output
            self.peaks.append((time, PHI[0] * x[0] + PHI[1] * x[2]))

        def integrator(force, ends):
            return hy.taylor_adaptive(
                rates(force),
                np.zeros(4, dtype=real),
                tol=real(tolerance),
                fp_type=real,
                t_events=[hy.t_event(end, direction=FALLING, fp_type=real) for end in ends],
                nt_events=[hy.nt_event(TIP_VELOCITY, peak, direction=FALLING, fp_type=real)],
            )

        self.modes = {
            0: integrator(CONSTRAINT, [LIMIT - CONSTRAINT, LIMIT + CONSTRAINT]),
            -1: integrator(mu(-V_R) * F_N, [-V_R]),
            1: integrator(-mu(V_R) * F_N, [V_R]),
        }

    def run(self, velocities, ends):
        """The peaks (time, displacement) of each point up to its end."""
        return [self.point(v0, end) for v0, end in zip(velocities, ends)]

    def point(self, v0, stop):
        self.peaks = []
        # Stick does not know the belt's velocity but by its start.
        for mode in (-1, 1):
            self.modes[mode].pars[0] = self.real(v0)
        t, x, mode = self.real(0), np.array(start(v0), dtype=self.real), 0
        while True:
            ta = self.modes[mode]
            ta.time = t
            ta.state[:] = x
            ta.reset_cooldowns()
            outcome = ta.propagate_until(self.real(stop))[0]
            if outcome == hy.taylor_outcome.time_limit:
                return np.array(self.peaks)
            t, x = ta.time, ta.state.copy()
            if mode == 0:
                mode = -1 if constraint_force(*x) > 0 else 1
            else:
                mode = mode_after_slip(x)


class Batch:
    """As many points at once as there are lanes. The mode is a second parameter s of each lane (-1, 0, 1), because
    lanes change their modes at different times."""

    def __init__(self, tolerance, lanes, wide):
        s = hy.par[1]
        stuck = 1 - s * s
        force = stuck * CONSTRAINT - s * mu(s * V_R) * F_N
        # Falls through zero at the end of a slip, and of a stick that ends backwards.
        end = stuck * (LIMIT - CONSTRAINT) + s * V_R
        # And of one that ends forwards.
        overtaken = stuck * (LIMIT + CONSTRAINT) + s * s
        self.lanes = lanes
        self.peaks = [[] for _ in range(lanes)]

        def ends(_, __, lane):
            mode = 0.0
            if self.s[lane] == 0:
                mode = -1.0
            else:
                mode = mode_after_slip([row[lane] for row in self.rows])
            self.s[lane] = mode
            return True

        def overtakes(_, __, lane):
            self.s[lane] = 1.0
            return True

        def peak(ta, time, _, lane):
            ta.update_d_output(time)
            x = ta.d_output
            self.peaks[lane].append((time, PHI[0] * x[0, lane] + PHI[1] * x[2, lane]))

        self.integrator = hy.taylor_adaptive_batch(
            rates(force),
            np.zeros((4, lanes)),
            pars=np.zeros((2, lanes)),
            tol=tolerance,
            force_avx512=wide,
            t_events=[
                hy.t_event_batch(end, callback=ends, direction=FALLING),
                hy.t_event_batch(overtaken, callback=overtakes, direction=FALLING),
            ],
            nt_events=[hy.nt_event_batch(TIP_VELOCITY, peak, direction=FALLING)],
        )
        # Views are made once; each costs as much as the rest of a callback.
        self.rows = list(self.integrator.state)
        self.s = self.integrator.pars[1]

    def run(self, velocities, ends):
        """The peaks (time, displacement) of each point up to its end; as many points as lanes, or a multiple."""
        found = []
        for first in range(0, len(velocities), self.lanes):
            chosen = slice(first, first + self.lanes)
            ta = self.integrator
            ta.set_time(0.0)
            ta.reset_cooldowns()
            ta.state[:] = np.transpose([start(v0) for v0 in velocities[chosen]])
            ta.pars[0] = velocities[chosen]
            ta.pars[1] = 0.0
            self.peaks = [[] for _ in range(self.lanes)]
            ta.propagate_until(np.array(ends[chosen]))
            found += [np.array(peaks) for peaks in self.peaks]
        return found

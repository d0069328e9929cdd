"""The rig: a cantilever whose tip is driven by friction from a moving belt.

An independent statement of the model (Stelter 1992), written to produce reference data. It shares no code with
the rest of the project. SI units throughout.

Equations
    q_j'' + 2 D_j w_j q_j' + w_j^2 q_j = phi_j(1) F_tip / m + (load terms),   w = sum_j phi_j(1) q_j     (eqs. 1-6)
    v_r = w' - v_belt                      relative velocity, m/s (negative: the tip is slower than the belt)
    slip    F = -mu F_N sgn(v_r)           friction force on the tip, N, positive along the belt's motion
    stick   v_r = 0, F = constraint force, held while |F| <= mu_s F_N
    mu(v) = mu_0 [1 - a1 + a1 exp(-|v|/v1)] [1 - a2 + a2 exp(-c2 |v|)]     (eq. 7, exponent read as |v_r|/c1)

New physics (of no kind that the catalogue or the diagnosis's own terms know)
    outside:frequency_drift     f_1 -> f_1 [1 + a (1 - exp(-t/tau))]; change a (1), time_constant tau (s); f_1 before t = 0
    outside:ageing_law          mu -> mu [1 + b ln(theta v_0/L)], the factor kept in 0.5 .. 1.5, theta' = 1 - |v_r| theta/L, also in stick;
                                gain b (1), slip_distance L (m), v_0 the belt's speed (m/s), theta the contact's age (s), L/v_0 at first
    outside:frictional_heating  mu -> mu/(1 + k T), C T' = |F v_r| - C T/tau; coefficient k (1/K), heat_capacity C (J/K),
                                time_constant tau (s), T the contact's temperature over the belt's (K), 0 at first
    outside:hysteresis          tip force -h, h' = k w', |h| <= h_0 (Jenkins element); stiffness k (N/m), slip_force h_0 (N); h = 0 at first
    outside:quadratic_sensor    measured = w + c w^2; curvature c (1/m)
    outside:cubic_sensor        measured = w + c w^3; curvature c (1/m^2)

Physics that was written when the diagnosis was finished (FURTHER_PHYSICS)
    outside:sensor_saturation       measured = L tanh(w/L); level L (m)
    outside:sensor_drift            measured = w + a (1 - exp(-t/tau)); change a (m), time_constant tau (s)
    outside:magnet                  tip force C/(d - w)^2 - C/d^2; strength C (N m^2), distance d (m)
    outside:belt_slowing            v_0 -> v_0 [1 + a (1 - exp(-t/tau))]; change a (1), time_constant tau (s)
    outside:friction_by_deflection  mu -> mu [1 + a tanh(w/w_0)]; change a (1), deflection_scale w_0 (m)
    outside:speed_memory            mu -> mu (1 + a x), tau x' = |v_r| - x; gain a (s/m), time_constant tau (s); x = 0 at first
    outside:frequency_by_amplitude  f_1 -> f_1 (1 + a x/mm), tau x' = |w| - x; change a (1), time_constant tau (s); x = 0 at first
    outside:absorber                a mass M on the tip by k = M (2 pi f)^2 and c = 4 pi D f M; mass M (kg), frequency f (Hz),
                                    damping_ratio D (1); at rest on the tip at first

Physics that was written later still (LATER_PHYSICS)
    outside:friction_by_load        mu -> mu (F_N/F_0)^(-e); exponent e (1; 1/3 of an elastic contact, Archard 1957), force F_0 (N)

Physics that was written after the diagnosis of ADR 0057 was frozen (FRESH_PHYSICS)
    outside:mains_hum               measured = w + a cos(2 pi f t + p); amplitude a (m), frequency f (Hz), phase p (rad)
    outside:ac_coupling             measured = w - x, tau x' = w - x; time_constant tau (s); x = w at first
    outside:lagging_load            F_N -> F_N (1 + k x), tau x' = w - x; coefficient k (1/m), time_constant tau (s); x = 0 at first
    outside:eccentric_pulley        v_0 -> v_0 [1 + a cos(2 pi v_0 t/L + p)]; amplitude a (1), circumference L (m), phase p (rad)
    outside:frequency_step          f_1 -> f_1 [1 + a (1 + tanh((t - t_0)/5 ms))/2]; change a (1), instant t_0 (s): a bolt comes loose
    outside:run_in                  mu -> mu [1 + a exp(-d/L)], d' = |v_r|; change a (1), distance L (m); d = 0 at first

Physics that was written without a look at what the diagnosis can explain (BLIND_PHYSICS)
    outside:resonant_load           F_N -> F_N (1 + k x), x''/w_n^2 + 2 D x'/w_n + x = F/F_N; coefficient k (1), frequency w_n/2 pi (Hz),
                                    damping_ratio D (1), F the friction force on the tip, F_N on the right the run's constant one; x = x' = 0
                                    at first: the loading arm is bent by friction and swings (Tolstoi 1967, normal degree of freedom)
    outside:motor_slip              v_0 -> v_0 (1 - a F_N/100 N); slip a (1), F_N the run's constant normal force: the belt drags over its bed,
                                    and an induction motor falls behind in proportion to its torque (Fitzgerald, Kingsley, Umans 2003)
    outside:damping_by_amplitude    D_1 -> D_1 + a x/mm, tau x' = |w| - x; increase a (1), time_constant tau (s); x = 0 at first: loss in
                                    material and joints grows faster than the square of the stress (Lazan 1968)
    outside:frequency_by_heat       f_1 -> f_1/(1 + k T), C T' = |F v_r| - C T/tau; coefficient k (1/K), heat_capacity C (J/K), time_constant
                                    tau (s); T = 0 at first: the modulus falls as friction warms the beam (Wachtman et al. 1961)
    outside:clamp_play              q_j'' + ... = ... + a w_1^2 (k_j/k_1)^2 g tanh(x/g), x = sum_j (k_j/k_1)^2 q_j; share a (1), play g (m);
                                    k_j the wave numbers, so x goes with the moment at the clamp: it gives way to small moments, is tight
                                    under large ones, and takes up the share a of both stiffnesses (Ibrahim, Pettit 2005, bolted joints)
    outside:friction_by_vibration   mu -> mu/(1 + k x), tau x' = w''^2 - x; gain k (s^4/m^2), time_constant tau (s); x = 0 at first: vibration
                                    parts the surfaces (Godfrey 1967; Thomsen 1999)
    outside:hersey_number           mu(v) -> mu(v (F_N/F_0)^(-e)); exponent e (1), force F_0 (N): of a lubricated contact friction is one of
                                    speed over load (Hersey 1914)
    outside:frame_compliance        measured = w - c F; compliance c (m/N), F the friction force on the tip: its reaction moves the sensor's
                                    stand along with the frame (structural loop, Slocum 1992)

Symbols: q_j modal coordinate (m), D_j damping ratio, w_j = 2 pi f_j, m modal mass (kg), phi_j(1) = +2, -2, +2, ...,
F_N normal force (N), v1 Stribeck velocity (m/s), c2 (s/m), mu_0 static friction coefficient (v_r -> 0).

Method: classical Runge-Kutta of order four with a fixed step (2.5e-6 s; 1e-6 s with bristles), aligned with the sampling instants.
Every change of contact mode is located by bisecting the length of the step in which it happens, to less than 1e-13 s.
In slip an excursion through v_r = 0 and back inside one step is found from the Hermite cubic of v_r.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from scipy.interpolate import CubicSpline

# ---------------------------------------------------------------------------------------------------------------
# Beam: eigenfunctions of the clamped-free beam (eq. 6)

WAVE_NUMBERS = (1.875104068711961, 4.694091132974175, 7.854757438237613, 10.995540734875467)


def eigenfunction(j, xi, derivative=0):
    """phi_j(xi) = cosh kx - cos kx - s (sinh kx - sin kx), s = (cosh k + cos k)/(sinh k + sin k); phi_j(1) = +-2 (eq. 6)."""
    k = WAVE_NUMBERS[j]
    s = (math.cosh(k) + math.cos(k)) / (math.sinh(k) + math.sin(k))
    x = k * np.asarray(xi)
    if derivative == 0:
        return np.cosh(x) - np.cos(x) - s * (np.sinh(x) - np.sin(x))
    return k * (np.sinh(x) + np.sin(x) - s * (np.cosh(x) - np.cos(x)))


def beam_integrals(n):
    """G_ij = int phi_i' phi_j' dxi (1) and I_j = int phi_j dxi (1), by Gauss-Legendre quadrature with 80 nodes."""
    x, weight = np.polynomial.legendre.leggauss(80)
    x, weight = 0.5 * (x + 1), 0.5 * weight
    slope = np.array([eigenfunction(j, x, 1) for j in range(n)])
    return (slope * weight) @ slope.T, np.array([(eigenfunction(j, x) * weight).sum() for j in range(n)])


# ---------------------------------------------------------------------------------------------------------------
# Places in the parameter vector. One block per effect; a value of zero switches the effect off.

(
    FN, V0, MU0, A1, V1, A2, C2, LEVEL, PRINTED_LAW,
    BP_A, BP_L, BP_P,  # belt_periodic_friction: amplitude, wavelength, phase
    PROFILE, PROFILE_S0, PROFILE_DX,  # belt_friction_profile: on, place on the belt at s = 0, node distance
    AGE_B, AGE_TAU, AGE_LOG,  # static_friction_aging: gain, time constant, form
    LAG_TAU,  # frictional_lag
    LG_S0, LG_S1,  # presliding_compliance: bristle stiffness, bristle damping
    K3,  # cubic_stiffness
    QD,  # quadratic_drag
    NC_K,  # normal_force_coupling
    NM_A, NM_F, NM_P,  # normal_force_modulation
    BD_M, BD_K, BD_C,  # belt_drive_compliance
    DRIFT_A, DRIFT_TAU,  # friction_drift
    VISC,  # viscous_friction
    BASE_A, BASE_F, BASE_P,  # base_excitation
    SENSOR_TAU,  # sensor_lag
    O_K2,  # outside:quadratic_stiffness, N/m^2
    O_STOP_K, O_STOP_GAP,  # outside:impact_stop, N/m, m
    O_DC,  # outside:rate_and_state, m
    O_DIR, O_DIR_V,  # outside:direction_dependent_friction, 1, m/s
    O_CD,  # outside:cubic_damping, N s^3/m^3
    O_RIP_A, O_RIP_F, O_RIP_P,  # outside:belt_speed_ripple
    O_RAND,  # outside:random_friction, 1
    O_ASYM, O_ASYM_W,  # outside:asymmetric_damping, N s/m, m
    O_PAR_K, O_PAR_F, O_PAR_P,  # outside:parametric_stiffness, N/m, Hz, rad
    O_NV,  # outside:normal_force_speed_coupling, s/m
    O_FREQ_A, O_FREQ_TAU,  # outside:frequency_drift, 1, s
    O_AGE_B, O_AGE_L,  # outside:ageing_law, 1, m
    O_HEAT_K, O_HEAT_C, O_HEAT_TAU,  # outside:frictional_heating, 1/K, J/K, s
    O_HYST_K, O_HYST_F,  # outside:hysteresis, N/m, N
    O_CURVE2, O_CURVE3,  # outside:quadratic_sensor, 1/m; outside:cubic_sensor, 1/m^2
    F_SAT,  # outside:sensor_saturation, m
    F_ZERO_A, F_ZERO_TAU,  # outside:sensor_drift, m, s
    F_MAG_C, F_MAG_D,  # outside:magnet, N m^2, m
    F_BELT_A, F_BELT_TAU,  # outside:belt_slowing, 1, s
    F_FW_A, F_FW_W,  # outside:friction_by_deflection, 1, m
    F_MEM_A, F_MEM_TAU,  # outside:speed_memory, s/m, s
    F_AMP_A, F_AMP_TAU,  # outside:frequency_by_amplitude, 1 (for 1 mm), s
    F_ABS_M, F_ABS_F, F_ABS_D,  # outside:absorber, kg, Hz, 1
    L_LOAD_E, L_LOAD_F,  # outside:friction_by_load, 1, N
    H_HUM_A, H_HUM_F, H_HUM_P,  # outside:mains_hum, m, Hz, rad
    H_AC_TAU,  # outside:ac_coupling, s
    H_LAG_K, H_LAG_TAU,  # outside:lagging_load, 1/m, s
    H_PUL_A, H_PUL_L, H_PUL_P,  # outside:eccentric_pulley, 1, m, rad
    H_STEP_A, H_STEP_T,  # outside:frequency_step, 1, s
    H_RUN_A, H_RUN_L,  # outside:run_in, 1, m
    B_RES_K, B_RES_F, B_RES_D,  # outside:resonant_load, 1, Hz, 1
    B_SLIP,  # outside:motor_slip, 1
    B_DAMP_A, B_DAMP_TAU,  # outside:damping_by_amplitude, 1 (for 1 mm), s
    B_WARM_K, B_WARM_C, B_WARM_TAU,  # outside:frequency_by_heat, 1/K, J/K, s
    B_PLAY_A, B_PLAY_G,  # outside:clamp_play, 1, m
    B_VIB_K, B_VIB_TAU,  # outside:friction_by_vibration, s^4/m^2, s
    B_HERSEY_E, B_HERSEY_F,  # outside:hersey_number, 1, N
    B_FRAME,  # outside:frame_compliance, m/N
    SIZE,
) = range(113)

# Places in the state vector after q_1..q_n, q_1'..q_n'
S, U, Z, X, XD, Y, R = range(7)  # belt travel, lagged speed, bristle, belt-drive displacement and velocity, sensor, slip memory
A, T, H = range(7, 10)  # contact's age theta v_0/L - 1 (1), its temperature (K), hysteretic force (N)
# Low-passed speed (m/s), deflection (m) or square of the acceleration (m^2/s^4), distance slid (m); absorber's place over the tip (m) and
# velocity (m/s); lagging share of the friction force in the load (1) and its rate (1/s).
M, P, PV, B, BV = range(10, 15)
EXTRA = 15
AGE_BOUNDS = 0.5, 1.5  # of the factor of outside:ageing_law, 1
STEP_WIDTH = 5e-3  # of outside:frequency_step, s
SLIP_LOAD = 100.0  # under which outside:motor_slip has its share, N
STICK = 0


@njit(cache=True)
def _law(v, p):
    """mu(v) of the bare law, v >= 0 in m/s (eq. 7). Slightly negative v continues it smoothly, for steps past an event."""
    if p[PRINTED_LAW] != 0.0:
        if v <= 0.0:
            return p[MU0] * (1.0 - p[A1])
        return p[MU0] * (1.0 - p[A1] + p[A1] * math.exp(-p[V1] / v)) * (1.0 - p[A2] + p[A2] * math.exp(-p[C2] * v))
    return p[MU0] * (1.0 - p[A1] + p[A1] * math.exp(-v / p[V1])) * (1.0 - p[A2] + p[A2] * math.exp(-p[C2] * v))


@njit(cache=True)
def _profile(s, p, nodes):
    """g(s) (1): periodic cubic spline over the belt, coefficients nodes[0..3, i] per interval, s in m from the record's start."""
    n = nodes.shape[1]
    x = (s + p[PROFILE_S0]) / p[PROFILE_DX]
    i = math.floor(x)
    d = (x - i) * p[PROFILE_DX]
    k = int(i) % n
    return ((nodes[0, k] * d + nodes[1, k]) * d + nodes[2, k]) * d + nodes[3, k]


@njit(cache=True)
def _slowed(t, p):
    """Belt speed over the one at first (1), and its rate (1/s)."""
    if p[F_BELT_A] == 0.0 or t < 0.0:
        return 1.0, 0.0
    left = math.exp(-t / p[F_BELT_TAU])
    return 1.0 + p[F_BELT_A] * (1.0 - left), p[F_BELT_A] * left / p[F_BELT_TAU]


@njit(cache=True)
def _eccentric(t, p):
    """Share of its speed by which an eccentric pulley speeds the belt up (1), and its rate (1/s)."""
    if p[H_PUL_A] == 0.0:
        return 0.0, 0.0
    omega = 2.0 * math.pi * p[V0] / p[H_PUL_L]
    arg = omega * t + p[H_PUL_P]
    return p[H_PUL_A] * math.cos(arg), -p[H_PUL_A] * omega * math.sin(arg)


@njit(cache=True)
def _drifted(t, p, x, warmth):
    """Factor on w_1^2 (1): [1 + a (1 - exp(-t/tau))]^2, that of a step in time, of the low-passed deflection x (m) or of a warmth (K)."""
    if p[B_WARM_C] != 0.0:
        return (1.0 + p[B_WARM_K] * warmth) ** -2
    if p[H_STEP_A] != 0.0:
        return (1.0 + 0.5 * p[H_STEP_A] * (1.0 + math.tanh((t - p[H_STEP_T]) / STEP_WIDTH))) ** 2
    if p[F_AMP_A] != 0.0:
        return (1.0 + p[F_AMP_A] * x / 1e-3) ** 2
    if p[O_FREQ_A] == 0.0 or t <= 0.0:
        return 1.0
    return (1.0 + p[O_FREQ_A] * (1.0 - math.exp(-t / p[O_FREQ_TAU]))) ** 2


@njit(cache=True)
def _lost(w2, p, x):
    """What the amplitude adds to 2 D_1 w_1 (1/s); x: the low-passed deflection (m)."""
    if p[B_DAMP_A] == 0.0:
        return 0.0
    return 2.0 * p[B_DAMP_A] * x / 1e-3 * math.sqrt(w2[0])


@njit(cache=True)
def _given_way(y, n, w2, p):
    """Acceleration (m/s^2) by which a clamp with play takes up stiffness of the first mode; that of mode j is (k_j/k_1)^2 times it."""
    if p[B_PLAY_A] == 0.0:
        return 0.0
    x = 0.0
    for j in range(n):
        x += (WAVE_NUMBERS[j] / WAVE_NUMBERS[0]) ** 2 * y[j]
    return p[B_PLAY_A] * w2[0] * p[B_PLAY_G] * math.tanh(x / p[B_PLAY_G])


@njit(cache=True)
def _aged(age, p):
    """Factor on mu (1): 1 + b ln(theta v_0/L), bounded; age = theta v_0/L - 1."""
    return min(max(1.0 + p[O_AGE_B] * math.log(max(1.0 + age, 1e-9)), AGE_BOUNDS[0]), AGE_BOUNDS[1])


@njit(cache=True)
def _scene(t, y, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi):
    """Everything but the friction force: w, w', F_N(t) (N), factor on mu, v_belt (m/s), its given rate (m/s^2),
    tip acceleration without any tip force (m/s^2), tip force other than friction (N)."""
    e = 2 * n
    w = 0.0
    wd = 0.0
    for j in range(n):
        w += phi[j] * y[j]
        wd += phi[j] * y[n + j]
    normal = p[FN] * (1.0 + p[NC_K] * w) * (1.0 + p[O_NV] * wd)
    if p[NM_A] != 0.0:
        normal *= 1.0 + p[NM_A] * math.cos(2.0 * math.pi * p[NM_F] * t + p[NM_P])
    if p[H_LAG_K] != 0.0:
        normal *= 1.0 + p[H_LAG_K] * y[e + M]
    if p[B_RES_K] != 0.0:
        normal *= 1.0 + p[B_RES_K] * y[e + B]
    if normal < 0.0:
        normal = 0.0
    factor = p[LEVEL]
    if p[BP_A] != 0.0:
        factor *= 1.0 + p[BP_A] * math.cos(2.0 * math.pi * y[e + S] / p[BP_L] + p[BP_P])
    if p[PROFILE] != 0.0:
        factor *= 1.0 + _profile(y[e + S], p, nodes)
    if p[DRIFT_A] != 0.0 and t > 0.0:
        factor *= 1.0 + p[DRIFT_A] * (1.0 - math.exp(-t / p[DRIFT_TAU]))
    if p[O_DIR] != 0.0:
        factor *= 1.0 + p[O_DIR] * math.tanh(wd / p[O_DIR_V])
    factor *= 1.0 + p[O_RAND] * xi
    if p[O_AGE_B] != 0.0:
        factor *= _aged(y[e + A], p)
    if p[O_HEAT_C] != 0.0:
        factor /= 1.0 + p[O_HEAT_K] * y[e + T]
    if p[F_FW_A] != 0.0:
        factor *= 1.0 + p[F_FW_A] * math.tanh(w / p[F_FW_W])
    if p[F_MEM_A] != 0.0:
        factor *= 1.0 + p[F_MEM_A] * y[e + M]
    if p[H_RUN_A] != 0.0:
        factor *= 1.0 + p[H_RUN_A] * math.exp(-y[e + M] / p[H_RUN_L])
    if p[B_VIB_K] != 0.0:
        factor /= 1.0 + p[B_VIB_K] * y[e + M]
    if p[L_LOAD_E] != 0.0 and normal > 0.0:
        factor *= (normal / p[L_LOAD_F]) ** -p[L_LOAD_E]
    slowed, rate = _slowed(t, p)
    belt = p[V0] * slowed
    belt_rate = p[V0] * rate
    if p[O_RIP_A] != 0.0:
        arg = 2.0 * math.pi * p[O_RIP_F] * t + p[O_RIP_P]
        belt += p[V0] * p[O_RIP_A] * math.cos(arg)
        belt_rate -= p[V0] * p[O_RIP_A] * 2.0 * math.pi * p[O_RIP_F] * math.sin(arg)
    eccentric, eccentric_rate = _eccentric(t, p)
    belt += p[V0] * eccentric
    belt_rate += p[V0] * eccentric_rate
    belt += y[e + XD]
    shake = 0.0
    if p[BASE_A] != 0.0:
        shake = p[BASE_A] * math.cos(2.0 * math.pi * p[BASE_F] * t + p[BASE_P])
    free = 0.0
    stiffening = _drifted(t, p, y[e + M], y[e + T])
    lost = _lost(w2, p, y[e + M])
    given_way = _given_way(y, n, w2, p)
    for j in range(n):
        a = -(dmp[j] + (lost if j == 0 else 0.0)) * y[n + j] - w2[j] * (stiffening if j == 0 else 1.0) * y[j] - shake * inertia[j]
        a += given_way * (WAVE_NUMBERS[j] / WAVE_NUMBERS[0]) ** 2
        for i in range(n):
            a += soft[j, i] * y[i]
        free += phi[j] * a
    other = -p[K3] * w * w * w - p[QD] * wd * abs(wd) - p[O_K2] * w * w - p[O_CD] * wd * wd * wd
    if p[O_STOP_K] != 0.0 and w > p[O_STOP_GAP]:
        other -= p[O_STOP_K] * (w - p[O_STOP_GAP])
    if p[O_ASYM] != 0.0:
        other -= p[O_ASYM] * wd * 0.5 * (1.0 + math.tanh(w / p[O_ASYM_W]))
    if p[O_PAR_K] != 0.0:
        other -= p[O_PAR_K] * math.cos(2.0 * math.pi * p[O_PAR_F] * t + p[O_PAR_P]) * w
    if p[O_HYST_K] != 0.0:
        other -= min(max(y[e + H], -p[O_HYST_F]), p[O_HYST_F])
    if p[F_MAG_C] != 0.0:
        other += p[F_MAG_C] / (p[F_MAG_D] - w) ** 2 - p[F_MAG_C] / p[F_MAG_D] ** 2
    if p[F_ABS_M] != 0.0:
        omega = 2.0 * math.pi * p[F_ABS_F]
        other += p[F_ABS_M] * omega * (omega * y[e + P] + 2.0 * p[F_ABS_D] * (y[e + PV] - wd))
    return w, wd, normal, factor, belt, belt_rate, free, other, shake


@njit(cache=True)
def _constraint(y, n, admittance, p, free, other, belt_rate):
    """F_c (N) that keeps w'' = v_belt'. With a compliant drive the belt answers: M x'' = -F - c x' - k x."""
    e = 2 * n
    if p[BD_M] != 0.0:
        drive = -(p[BD_C] * y[e + XD] + p[BD_K] * y[e + X]) / p[BD_M]
        return (belt_rate + drive - free - admittance * other) / (admittance + 1.0 / p[BD_M])
    return (belt_rate - free - admittance * other) / admittance


@njit(cache=True)
def _static_limit(t, stick_since, normal, factor, p):
    """Break-away force (N): mu_0 F_N with all factors; ageing adds b (1 - exp(-t_stick/tau)) or b ln(1 + t_stick/tau)."""
    limit = p[MU0] * factor * normal
    if p[AGE_B] != 0.0:
        dwell = t - stick_since
        if p[AGE_LOG] != 0.0:
            limit *= 1.0 + p[AGE_B] * math.log(1.0 + dwell / p[AGE_TAU])
        else:
            limit *= 1.0 + p[AGE_B] * (1.0 - math.exp(-dwell / p[AGE_TAU]))
    return limit


@njit(cache=True)
def _rates(t, y, dy, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi):
    """dy/dt in the given contact mode (0 stick, +1 / -1 sign of v_r in slip); returns the friction force F (N)."""
    e = 2 * n
    w, wd, normal, factor, belt, belt_rate, free, other, shake = _scene(
        t, y, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
    admittance = 0.0
    for j in range(n):
        admittance += phi[j] * phi[j] / mass
    vr = wd - belt
    speed = mode * vr
    dy[e + Z] = 0.0
    dy[e + U] = 0.0
    dy[e + R] = 0.0
    if mode == 0:
        force = _constraint(y, n, admittance, p, free, other, belt_rate)
        dy[e + S] = 0.0
    else:
        dy[e + S] = -vr
        at = speed
        if p[LAG_TAU] != 0.0:
            at = y[e + U]
            dy[e + U] = (speed - at) / p[LAG_TAU]
        if p[O_DC] != 0.0:
            at = y[e + R]
            dy[e + R] = speed * (speed - at) / p[O_DC]
        if p[B_HERSEY_E] != 0.0 and normal > 0.0:
            at *= (normal / p[B_HERSEY_F]) ** -p[B_HERSEY_E]
        mu = (_law(at, p) + p[VISC] * at) * factor
        if p[LG_S0] != 0.0:
            if mu * normal > 1e-9:
                dy[e + Z] = vr - p[LG_S0] * speed * y[e + Z] / (mu * normal)
            force = -(p[LG_S0] * y[e + Z] + p[LG_S1] * dy[e + Z])
        else:
            force = -mode * mu * normal
    tip = (force + other) / mass
    stiffening = _drifted(t, p, y[e + M], y[e + T])
    lost = _lost(w2, p, y[e + M])
    given_way = _given_way(y, n, w2, p)
    for j in range(n):
        a = -(dmp[j] + (lost if j == 0 else 0.0)) * y[n + j] - w2[j] * (stiffening if j == 0 else 1.0) * y[j] - shake * inertia[j]
        a += given_way * (WAVE_NUMBERS[j] / WAVE_NUMBERS[0]) ** 2
        for i in range(n):
            a += soft[j, i] * y[i]
        dy[j] = y[n + j]
        dy[n + j] = a + phi[j] * tip
    dy[e + X] = y[e + XD]
    dy[e + XD] = 0.0
    if p[BD_M] != 0.0:
        dy[e + XD] = (-force - p[BD_C] * y[e + XD] - p[BD_K] * y[e + X]) / p[BD_M]
    dy[e + Y] = 0.0
    if p[SENSOR_TAU] != 0.0:
        dy[e + Y] = (w - y[e + Y]) / p[SENSOR_TAU]
    elif p[H_AC_TAU] != 0.0:
        dy[e + Y] = (w - y[e + Y]) / p[H_AC_TAU]
    dy[e + A] = 0.0
    if p[O_AGE_B] != 0.0:
        dy[e + A] = (p[V0] - speed * (1.0 + y[e + A])) / p[O_AGE_L]
    dy[e + T] = 0.0
    if p[O_HEAT_C] != 0.0:
        dy[e + T] = -force * vr / p[O_HEAT_C] - y[e + T] / p[O_HEAT_TAU]
    elif p[B_WARM_C] != 0.0:
        dy[e + T] = -force * vr / p[B_WARM_C] - y[e + T] / p[B_WARM_TAU]
    dy[e + H] = 0.0
    if p[O_HYST_K] != 0.0 and (abs(y[e + H]) < p[O_HYST_F] or y[e + H] * wd < 0.0):
        dy[e + H] = p[O_HYST_K] * wd
    dy[e + M] = 0.0
    if p[F_MEM_A] != 0.0:
        dy[e + M] = (abs(vr) - y[e + M]) / p[F_MEM_TAU]
    elif p[F_AMP_A] != 0.0:
        dy[e + M] = (abs(w) - y[e + M]) / p[F_AMP_TAU]
    elif p[H_LAG_K] != 0.0:
        dy[e + M] = (w - y[e + M]) / p[H_LAG_TAU]
    elif p[H_RUN_A] != 0.0:
        dy[e + M] = abs(vr)
    elif p[B_DAMP_A] != 0.0:
        dy[e + M] = (abs(w) - y[e + M]) / p[B_DAMP_TAU]
    elif p[B_VIB_K] != 0.0:
        acceleration = 0.0
        for j in range(n):
            acceleration += phi[j] * dy[n + j]
        dy[e + M] = (acceleration * acceleration - y[e + M]) / p[B_VIB_TAU]
    dy[e + B] = 0.0
    dy[e + BV] = 0.0
    if p[B_RES_K] != 0.0:
        omega = 2.0 * math.pi * p[B_RES_F]
        dy[e + B] = y[e + BV]
        dy[e + BV] = omega * (omega * (force / p[FN] - y[e + B]) - 2.0 * p[B_RES_D] * y[e + BV])
    dy[e + P] = 0.0
    dy[e + PV] = 0.0
    if p[F_ABS_M] != 0.0:
        omega = 2.0 * math.pi * p[F_ABS_F]
        dy[e + P] = y[e + PV] - wd
        dy[e + PV] = -omega * (omega * y[e + P] + 2.0 * p[F_ABS_D] * (y[e + PV] - wd))
    return force


@njit(cache=True)
def _step(t, h, y, out, k1, k2, k3, k4, tmp, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi):
    """One step of the classical Runge-Kutta method of length h; k1 must hold the rates at (t, y)."""
    m = y.size
    for i in range(m):
        tmp[i] = y[i] + 0.5 * h * k1[i]
    _rates(t + 0.5 * h, tmp, k2, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
    for i in range(m):
        tmp[i] = y[i] + 0.5 * h * k2[i]
    _rates(t + 0.5 * h, tmp, k3, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
    for i in range(m):
        tmp[i] = y[i] + h * k3[i]
    _rates(t + h, tmp, k4, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
    for i in range(m):
        out[i] = y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
    if p[O_HYST_K] != 0.0:
        out[2 * n + H] = min(max(out[2 * n + H], -p[O_HYST_F]), p[O_HYST_F])


@njit(cache=True)
def _relative_velocity(t, y, n, phi, p):
    v = 0.0
    for j in range(n):
        v += phi[j] * y[n + j]
    belt = p[V0] * _slowed(t, p)[0]
    if p[O_RIP_A] != 0.0:
        belt += p[V0] * p[O_RIP_A] * math.cos(2.0 * math.pi * p[O_RIP_F] * t + p[O_RIP_P])
    belt += p[V0] * _eccentric(t, p)[0]
    return v - (belt + y[2 * n + XD])


@njit(cache=True)
def _margin(t, y, mode, stick_since, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi):
    """Event function: >= 0 inside the mode. Stick: static limit - |F_c| (N). Slip: |v_r| with its sign in this mode (m/s)."""
    if mode != 0:
        return mode * _relative_velocity(t, y, n, phi, p)
    w, wd, normal, factor, belt, belt_rate, free, other, shake = _scene(
        t, y, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
    admittance = 0.0
    for j in range(n):
        admittance += phi[j] * phi[j] / mass
    fc = _constraint(y, n, admittance, p, free, other, belt_rate)
    return _static_limit(t, stick_since, normal, factor, p) - abs(fc)


@njit(cache=True)
def _pin(t, y, n, phi, p):
    """Take the rounding left in v_r out of the modal velocities, so that v_r = 0 holds exactly where a mode begins."""
    v = _relative_velocity(t, y, n, phi, p)
    total = 0.0
    for j in range(n):
        total += phi[j] * phi[j]
    for j in range(n):
        y[n + j] -= phi[j] / total * v


@njit(cache=True)
def _run(t0, y0, mode, stick_since, event_number, samples, dt, substeps,
         n, phi, w2, dmp, soft, mass, inertia, p, nodes, draws, events, max_events):
    m = y0.size
    ys = np.empty((samples, m))
    forces = np.empty(samples)
    accelerations = np.empty(samples)
    modes = np.empty(samples, np.int8)
    since = np.empty(samples)
    numbers = np.empty(samples, np.int64)
    y = y0.copy()
    out = np.empty(m)
    trial = np.empty(m)
    k1 = np.empty(m)
    k2 = np.empty(m)
    k3 = np.empty(m)
    k4 = np.empty(m)
    kend = np.empty(m)
    tmp = np.empty(m)
    found = 0
    h = dt / substeps
    bristles = p[LG_S0] != 0.0
    e = 2 * n
    xi = draws[event_number % draws.size]
    fresh = mode == 0 or abs(_relative_velocity(t0, y, n, phi, p)) < 1e-12
    for sample in range(samples):
        t_sample = t0 + sample * dt
        forces[sample] = _rates(t_sample, y, k1, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
        acceleration = 0.0
        for j in range(n):
            acceleration += phi[j] * k1[n + j]
        accelerations[sample] = acceleration
        ys[sample] = y
        modes[sample] = mode
        since[sample] = stick_since
        numbers[sample] = event_number
        if sample == samples - 1:
            break
        for sub in range(substeps):
            t = t_sample + sub * h
            left = h
            for _ in range(100):
                _rates(t, y, k1, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
                _step(t, left, y, out, k1, k2, k3, k4, tmp, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
                g1 = _margin(t + left, out, mode, stick_since, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
                hit = -1.0
                if g1 < 0.0:
                    hit = left
                elif mode != 0:
                    # an excursion through v_r = 0 and back inside the step
                    _rates(t + left, out, kend, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
                    d0 = -k1[e + XD]
                    d1 = -kend[e + XD]
                    for j in range(n):
                        d0 += phi[j] * k1[n + j]
                        d1 += phi[j] * kend[n + j]
                    d0 *= mode
                    d1 *= mode
                    if d0 < 0.0 and d1 > 0.0:
                        middle = left * d0 / (d0 - d1)
                        _step(t, middle, y, trial, k1, k2, k3, k4, tmp, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
                        if _margin(t + middle, trial, mode, stick_since, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi) < 0.0:
                            hit = middle
                if hit < 0.0:
                    for i in range(m):
                        y[i] = out[i]
                    fresh = False
                    break
                lo = 0.0
                hi = hit
                if fresh and mode != 0:
                    # the mode began here with v_r = 0: the crossing sought is the later one, so start inside
                    lo = 1e-9 * hit
                for _b in range(80):
                    if hi - lo < 1e-14 * 5.0:
                        break
                    mid = 0.5 * (lo + hi)
                    _step(t, mid, y, trial, k1, k2, k3, k4, tmp, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
                    if _margin(t + mid, trial, mode, stick_since, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi) < 0.0:
                        hi = mid
                    else:
                        lo = mid
                _step(t, hi, y, trial, k1, k2, k3, k4, tmp, mode, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
                for i in range(m):
                    y[i] = trial[i]
                t += hi
                left -= hi
                if found < max_events:
                    events[found, 0] = t
                    events[found, 1] = mode
                found += 1
                _pin(t, y, n, phi, p)
                if bristles:
                    mode = -mode
                else:
                    w, wd, normal, factor, belt, belt_rate, free, other, shake = _scene(
                        t, y, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)
                    admittance = 0.0
                    for j in range(n):
                        admittance += phi[j] * phi[j] / mass
                    fc = _constraint(y, n, admittance, p, free, other, belt_rate)
                    if mode == 0:
                        mode = -1 if fc > 0.0 else 1
                        y[e + U] = 0.0
                        y[e + R] = 0.0
                    else:
                        event_number += 1
                        xi = draws[event_number % draws.size]
                        if p[O_RAND] != 0.0:
                            factor = _scene(t, y, n, phi, w2, dmp, soft, mass, inertia, p, nodes, xi)[3]
                        if abs(fc) <= _static_limit(t, t, normal, factor, p):
                            mode = 0
                            stick_since = t
                        else:
                            mode = -1 if fc > 0.0 else 1
                fresh = True
                if left <= 0.0:
                    break
    return ys, forces, accelerations, modes, since, numbers, found


# ---------------------------------------------------------------------------------------------------------------
# Python side

EFFECTS = {
    # effect id: {parameter name of the catalogue: place in the parameter vector}
    "belt_periodic_friction": {"amplitude": BP_A, "wavelength": BP_L, "phase": BP_P},
    "belt_friction_profile": {"start": PROFILE_S0},
    "static_friction_aging": {"gain": AGE_B, "time_constant": AGE_TAU},
    "frictional_lag": {"time_constant": LAG_TAU},
    "presliding_compliance": {"bristle_stiffness": LG_S0, "bristle_damping": LG_S1},
    "third_mode": {},
    "axial_load": {},
    "cubic_stiffness": {"coefficient": K3},
    "quadratic_drag": {"coefficient": QD},
    "normal_force_coupling": {"coefficient": NC_K},
    "normal_force_modulation": {"amplitude": NM_A, "frequency": NM_F, "phase": NM_P},
    "belt_drive_compliance": {"mass": BD_M, "stiffness": BD_K, "damping": BD_C},
    "friction_drift": {"change": DRIFT_A, "time_constant": DRIFT_TAU},
    "viscous_friction": {"coefficient": VISC},
    "base_excitation": {"amplitude": BASE_A, "frequency": BASE_F, "phase": BASE_P},
    "sensor_lag": {"time_constant": SENSOR_TAU},
}
OUTSIDE = {
    "outside:quadratic_stiffness": {"coefficient": O_K2},
    "outside:impact_stop": {"stiffness": O_STOP_K, "gap": O_STOP_GAP},
    "outside:rate_and_state": {"slip_distance": O_DC},
    "outside:direction_dependent_friction": {"asymmetry": O_DIR, "velocity_scale": O_DIR_V},
    "outside:cubic_damping": {"coefficient": O_CD},
    "outside:belt_speed_ripple": {"amplitude": O_RIP_A, "frequency": O_RIP_F, "phase": O_RIP_P},
    "outside:random_friction": {"scatter": O_RAND},
    "outside:asymmetric_damping": {"coefficient": O_ASYM, "deflection_scale": O_ASYM_W},
    "outside:parametric_stiffness": {"stiffness": O_PAR_K, "frequency": O_PAR_F, "phase": O_PAR_P},
    "outside:normal_force_speed_coupling": {"coefficient": O_NV},
}
NEW_PHYSICS = {
    "outside:frequency_drift": {"change": O_FREQ_A, "time_constant": O_FREQ_TAU},
    "outside:ageing_law": {"gain": O_AGE_B, "slip_distance": O_AGE_L},
    "outside:frictional_heating": {"coefficient": O_HEAT_K, "heat_capacity": O_HEAT_C, "time_constant": O_HEAT_TAU},
    "outside:hysteresis": {"stiffness": O_HYST_K, "slip_force": O_HYST_F},
    "outside:quadratic_sensor": {"curvature": O_CURVE2},
    "outside:cubic_sensor": {"curvature": O_CURVE3},
}
FURTHER_PHYSICS = {
    "outside:sensor_saturation": {"level": F_SAT},
    "outside:sensor_drift": {"change": F_ZERO_A, "time_constant": F_ZERO_TAU},
    "outside:magnet": {"strength": F_MAG_C, "distance": F_MAG_D},
    "outside:belt_slowing": {"change": F_BELT_A, "time_constant": F_BELT_TAU},
    "outside:friction_by_deflection": {"change": F_FW_A, "deflection_scale": F_FW_W},
    "outside:speed_memory": {"gain": F_MEM_A, "time_constant": F_MEM_TAU},
    "outside:frequency_by_amplitude": {"change": F_AMP_A, "time_constant": F_AMP_TAU},
    "outside:absorber": {"mass": F_ABS_M, "frequency": F_ABS_F, "damping_ratio": F_ABS_D},
}
LATER_PHYSICS = {
    "outside:friction_by_load": {"exponent": L_LOAD_E, "force": L_LOAD_F},
}
FRESH_PHYSICS = {
    "outside:mains_hum": {"amplitude": H_HUM_A, "frequency": H_HUM_F, "phase": H_HUM_P},
    "outside:ac_coupling": {"time_constant": H_AC_TAU},
    "outside:lagging_load": {"coefficient": H_LAG_K, "time_constant": H_LAG_TAU},
    "outside:eccentric_pulley": {"amplitude": H_PUL_A, "circumference": H_PUL_L, "phase": H_PUL_P},
    "outside:frequency_step": {"change": H_STEP_A, "instant": H_STEP_T},
    "outside:run_in": {"change": H_RUN_A, "distance": H_RUN_L},
}
BLIND_PHYSICS = {
    "outside:resonant_load": {"coefficient": B_RES_K, "frequency": B_RES_F, "damping_ratio": B_RES_D},
    "outside:motor_slip": {"slip": B_SLIP},
    "outside:damping_by_amplitude": {"increase": B_DAMP_A, "time_constant": B_DAMP_TAU},
    "outside:frequency_by_heat": {"coefficient": B_WARM_K, "heat_capacity": B_WARM_C, "time_constant": B_WARM_TAU},
    "outside:clamp_play": {"share": B_PLAY_A, "play": B_PLAY_G},
    "outside:friction_by_vibration": {"gain": B_VIB_K, "time_constant": B_VIB_TAU},
    "outside:hersey_number": {"exponent": B_HERSEY_E, "force": B_HERSEY_F},
    "outside:frame_compliance": {"compliance": B_FRAME},
}
PLACES = {**EFFECTS, **OUTSIDE, **NEW_PHYSICS, **FURTHER_PHYSICS, **LATER_PHYSICS, **FRESH_PHYSICS, **BLIND_PHYSICS}


@dataclass
class Rig:
    """Beam, friction law and effects.

    tip: phi_j(1) of the first modes (1); further modes have those of eq. (6).
    drive, weight: true over stated belt speed and normal force (1).
    effects: {id: {parameter: value}} with the names of PLACES above, and besides them
        third_mode             frequency (Hz), damping_ratio (1)
        axial_load             softening (1/N): K_ij -> K_ij - c F_N m w_1^2 G_ij/G_11, F_N the constant normal force of the run
        static_friction_aging  form "exp" (default) or "log"
        belt_friction_profile  node_distance (m), node_values (list, 1): a periodic cubic spline; start (m), place at s = 0
        outside:random_friction  draws (list of standard normal numbers, one per arrival at v_r = 0)
    """

    frequencies: list = field(default_factory=lambda: [80.0, 510.0])
    damping: list = field(default_factory=lambda: [0.00015, 0.00085])
    mass: float = 0.427
    mu_s: float = 0.66
    a1: float = 0.5
    v1: float = 0.02
    a2: float = 0.5
    c2: float = 0.25
    printed_law: bool = False
    effects: dict = field(default_factory=dict)
    tip: list = field(default_factory=lambda: [2.0, -2.0])
    drive: float = 1.0
    weight: float = 1.0

    def modes(self):
        return len(self.frequencies) + ("third_mode" in self.effects)

    def tip_values(self):
        """phi_j(1) (1) of all modes."""
        return np.array([*self.tip, *(2.0 * (-1) ** j for j in range(len(self.tip), self.modes()))][: self.modes()])

    def build(self, normal_force, belt_velocity, level=1.0):
        """Arrays of the equations of motion for one operating point as stated (N, m/s); level multiplies mu."""
        normal_force, belt_velocity = self.weight * normal_force, self.drive * belt_velocity
        f, d = list(self.frequencies), list(self.damping)
        if "third_mode" in self.effects:
            f.append(self.effects["third_mode"]["frequency"])
            d.append(self.effects["third_mode"]["damping_ratio"])
        n = len(f)
        omega = 2 * np.pi * np.array(f)
        phi = self.tip_values()
        g, inertia = beam_integrals(n)
        c = self.effects.get("axial_load", {}).get("softening", 0.0)
        soft = c * normal_force * omega[0] ** 2 * g / g[0, 0]
        p = np.zeros(SIZE)
        p[[FN, V0, MU0, A1, V1, A2, C2, LEVEL]] = normal_force, belt_velocity, self.mu_s, self.a1, self.v1, self.a2, self.c2, level
        p[PRINTED_LAW] = self.printed_law
        nodes, draws = np.zeros((4, 1)), np.zeros(1)
        for name, values in self.effects.items():
            for key, place in PLACES[name].items():
                p[place] = values.get(key, 0.0)
            if name == "static_friction_aging":
                p[AGE_LOG] = values.get("form", "exp") == "log"
            elif name == "belt_friction_profile":
                y = np.array(values["node_values"])
                p[PROFILE], p[PROFILE_DX] = 1.0, values["node_distance"]
                nodes = np.ascontiguousarray(
                    CubicSpline(np.arange(y.size + 1) * p[PROFILE_DX], np.append(y, y[0]), bc_type="periodic").c)
            elif name == "outside:random_friction":
                draws = np.array(values["draws"])
        p[V0] *= 1.0 - p[B_SLIP] * normal_force / SLIP_LOAD
        return dict(n=n, phi=phi, w2=omega**2, dmp=2 * np.array(d) * omega, soft=soft, mass=float(self.mass), inertia=inertia,
                    p=p, nodes=nodes, draws=draws)


NEW_STATES = {"contact_age": A, "contact_temperature": T, "hysteretic_force": H, "low_passed": M, "absorber": P, "absorber_velocity": PV,
              "load_swing": B, "load_swing_rate": BV}


@dataclass
class State:
    """Where a run starts. y = q (n), q' (n), then as S .. BV above; mode 0, +1, -1; stick_since and t in s.

    named() leaves out those of NEW_STATES that are 0."""

    y: np.ndarray
    mode: int = 0
    stick_since: float = 0.0
    event_number: int = 0

    def named(self, n):
        e = 2 * n
        return {"q": self.y[:n].tolist(), "q_dot": self.y[n:e].tolist(), "belt_travel": float(self.y[e + S]),
                "lagged_speed": float(self.y[e + U]), "bristle": float(self.y[e + Z]), "drive_displacement": float(self.y[e + X]),
                "drive_velocity": float(self.y[e + XD]), "sensor": float(self.y[e + Y]), "slip_memory": float(self.y[e + R]),
                "mode": int(self.mode), "stick_since": float(self.stick_since), "event_number": int(self.event_number),
                **{name: float(self.y[e + place]) for name, place in NEW_STATES.items() if self.y[e + place] != 0.0}}

    @staticmethod
    def from_named(d):
        y = np.array(d["q"] + d["q_dot"] + [d["belt_travel"], d["lagged_speed"], d["bristle"], d["drive_displacement"],
                                            d["drive_velocity"], d["sensor"], d["slip_memory"]]
                     + [d.get(name, 0.0) for name in NEW_STATES])
        return State(y, d["mode"], d["stick_since"], d["event_number"])


@dataclass
class Record:
    t: np.ndarray
    y: np.ndarray
    n: int
    phi: np.ndarray
    force: np.ndarray  # friction force on the tip, N, positive along the belt's motion
    acceleration: np.ndarray  # w'' (m/s^2) by the equations of motion with that force; where the mode changes, of the mode after it
    mode: np.ndarray
    stick_since: np.ndarray
    event_number: np.ndarray
    events: np.ndarray  # columns: time (s), mode left
    lagging_sensor: bool
    curve: tuple  # curvatures of the sensor, 1/m and 1/m^2
    sensor: tuple = (0.0, 0.0, 1.0)  # level at which it saturates, m; its drift in the end, m, and time constant, s
    hum: tuple = (0.0, 0.0, 0.0)  # amplitude, m; frequency, Hz; phase, rad
    ac_coupled: bool = False
    compliance: float = 0.0  # of the frame that carries the sensor, m/N

    @property
    def w(self):
        return self.y[:, : self.n] @ self.phi

    @property
    def wd(self):
        return self.y[:, self.n : 2 * self.n] @ self.phi

    @property
    def measured(self):
        """What a perfect display shows: tip displacement (m) after the sensor's low-pass, curve and drift, before noise and offset."""
        x = self.y[:, 2 * self.n + Y] if self.lagging_sensor else self.w
        if self.compliance != 0.0:
            x = x - self.compliance * self.force
        level, change, tau = self.sensor
        if level != 0.0:
            x = level * np.tanh(x / level)
        if change != 0.0:
            x = x + change * (1 - np.exp(-np.maximum(self.t, 0.0) / tau))
        if self.ac_coupled:
            x = x - self.y[:, 2 * self.n + Y]
        amplitude, frequency, phase = self.hum
        if amplitude != 0.0:
            x = x + amplitude * np.cos(2 * np.pi * frequency * self.t + phase)
        return x + self.curve[0] * x**2 + self.curve[1] * x**3

    def state(self, i):
        return State(self.y[i].copy(), int(self.mode[i]), float(self.stick_since[i]), int(self.event_number[i]))


def start(rig, q, q_dot, mode=None, belt_velocity=None):
    """A State from modal coordinates (m) and velocities (m/s); without a mode, slip of the sign of v_r."""
    n = rig.modes()
    y = np.zeros(2 * n + EXTRA)
    y[: len(q)] = q
    y[n : n + len(q_dot)] = q_dot
    phi = rig.tip_values()
    y[2 * n + Y] = phi @ y[:n]
    if mode is None:
        mode = 1 if phi @ y[n : 2 * n] > belt_velocity else -1
    if "presliding_compliance" in rig.effects and mode == 0:
        mode = -1
    return State(y, mode)


def simulate(rig, normal_force, belt_velocity, state, t0=0.0, duration=0.6, dt=1e-4, level=1.0, substep=None, max_events=200000):
    """Samples at t0, t0 + dt, ... (duration/dt of them, and one more at the end) and all transitions. N, m/s as stated, s."""
    b = rig.build(normal_force, belt_velocity, level)
    if substep is None:
        substep = 1e-6 if b["p"][LG_S0] != 0.0 else 2.5e-6
    substeps = max(1, round(dt / substep))
    samples = round(duration / dt) + 1
    events = np.empty((max_events, 2))
    y, force, acceleration, mode, since, numbers, found = _run(
        float(t0), np.asarray(state.y, float), int(state.mode), float(state.stick_since), int(state.event_number), samples, float(dt),
        substeps, b["n"], b["phi"], b["w2"], b["dmp"], b["soft"], b["mass"], b["inertia"], b["p"], b["nodes"], b["draws"],
        events, max_events)
    return Record(t0 + dt * np.arange(samples), y, b["n"], b["phi"], force, acceleration, mode, since, numbers,
                  events[: min(found, max_events)].copy(), b["p"][SENSOR_TAU] != 0.0,
                  (b["p"][O_CURVE2], b["p"][O_CURVE3]), tuple(b["p"][[F_SAT, F_ZERO_A, F_ZERO_TAU]]),
                  tuple(b["p"][[H_HUM_A, H_HUM_F, H_HUM_P]]), b["p"][H_AC_TAU] != 0.0, b["p"][B_FRAME])

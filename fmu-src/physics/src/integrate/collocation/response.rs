//! What a force does to the structure over a step of one length, worked out once for each structure.

use super::chebyshev::{Chebyshev, dot, from_values, places, polynomials};
use super::gauss::{gauss, rule};
use super::nodes::{self, Aligned};
use super::{NODES, Nodes, Oscillator, TERMS};
use crate::integrate::{MAX_STATES, State};
use nalgebra::SMatrix;
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::OnceLock;

/// Number of step lengths, each the one before divided by the square root of two.
pub const LEVELS: usize = 39;
/// Longest step times highest angular frequency.
const LONGEST: f64 = 4.0;
/// Points of the rule by which responses are integrated: more than enough for polynomials of degree 15 times an
/// oscillation over an angle of [`LONGEST`].
const POINTS: usize = 20;
/// Slopes of the characteristic for which the linearised step is solved beforehand: `slope mobility length` in half octaves from
/// 1/32 on.
const SLOPES: usize = 18;
const FLATTEST: f64 = 1.0 / 32.0;
const CLASSES: usize = 1 + 2 * SLOPES;

/// The linearised step: with p = p_0 + k (u - u_0) at each node, `u = free - response (p_0 + k (free - u_0))`, free without
/// friction.
pub(super) struct Linearised {
    /// The slopes k_i in N s/m at the nodes.
    pub(super) slopes: Nodes,
    /// (1 + G diag k)^-1 G, column by column.
    pub(super) response: Aligned<[Nodes; NODES]>,
}

/// Class of a slope times mobility and length: 0 for flat ones, then falling ones, then rising ones by half octaves, which are
/// the exponent and the first bit of the fraction.
#[inline]
fn class(slope: f64) -> usize {
    let size = slope.abs() * (1.0 / FLATTEST);
    // What is not a number is as good as flat here.
    if !(size >= 1.0) {
        return 0;
    }
    let half = ((size.to_bits() - 1.0f64.to_bits()) >> 51) as usize;
    half.min(SLOPES - 1) + if slope < 0.0 { 1 } else { 1 + SLOPES }
}

/// The middle of a class.
fn middle(class: usize) -> f64 {
    if class == 0 {
        return 0.0;
    }
    let (half, sign) = (
        (class - 1) % SLOPES,
        if class <= SLOPES { -1.0 } else { 1.0 },
    );
    let fraction = if half % 2 == 0 { 1.25 } else { 1.75 };
    sign * FLATTEST * fraction * f64::from(1u32 << (half / 2))
}

/// States at the end of a step that are worked out at once.
pub(super) const BLOCK: usize = 8;

/// Some states at the end of a step, q and q' of each oscillator in turn.
#[derive(Default)]
pub(super) struct End {
    /// Each from itself, and from the other of its oscillator, at the begin.
    pub(super) own: [f64; BLOCK],
    pub(super) other: [f64; BLOCK],
    /// From a unit force at each node.
    pub(super) forced: Aligned<[[f64; BLOCK]; NODES]>,
}

/// Responses over a step of one length. Matrices are lists of columns.
pub struct Response {
    /// Length in s.
    pub length: f64,
    /// `phi q'` at the nodes from unit states, summed over the oscillators.
    pub(super) free: Vec<Aligned<Nodes>>,
    /// G of the module's equation, in m/s per N.
    pub(super) forced: [Nodes; NODES],
    /// The same as series.
    pub(super) free_series: Vec<Aligned<Chebyshev>>,
    pub(super) forced_series: Aligned<[Chebyshev; NODES]>,
    /// The states at the end, some at once.
    pub(super) end: Vec<End>,
    /// Series of the states, q and q' in turn: from the own unit states, and term by term from the force at each node.
    free_states: Vec<Aligned<[Chebyshev; 2]>>,
    forced_states: Vec<Aligned<[Nodes; TERMS]>>,
    /// Linearised steps by the classes of the slopes at the first and at the last node.
    linearised: Vec<OnceLock<Box<Linearised>>>,
}

/// The responses of one structure over steps of all lengths, each worked out when it is first wanted.
pub struct Ladder {
    oscillators: Vec<Oscillator>,
    /// `sum g_j phi_j` in 1/kg: change of V per impulse.
    mobility: f64,
    responses: Vec<OnceLock<Box<Response>>>,
}

impl Ladder {
    /// For a structure of at least one oscillator.
    pub fn new(oscillators: Vec<Oscillator>) -> Self {
        Self {
            mobility: oscillators.iter().map(|o| o.gain * o.seen).sum(),
            oscillators,
            responses: (0..LEVELS).map(|_| OnceLock::new()).collect(),
        }
    }

    /// The oscillators.
    pub fn oscillators(&self) -> &[Oscillator] {
        &self.oscillators
    }

    /// `sum g_j phi_j` in 1/kg.
    pub fn mobility(&self) -> f64 {
        self.mobility
    }

    /// Length in s of the steps of `level`.
    pub fn length(&self, level: usize) -> f64 {
        let highest = self.oscillators.iter().map(|o| o.frequency);
        let highest = highest.fold(0.0, f64::max);
        let odd = if level % 2 == 1 { FRAC_1_SQRT_2 } else { 1.0 };
        LONGEST / highest * odd * 0.5f64.powi((level / 2) as i32)
    }

    /// The responses at `level`, from 0 to [`LEVELS`] - 1.
    pub fn response(&self, level: usize) -> &Response {
        self.responses[level].get_or_init(|| {
            let length = self.length(level);
            Box::new(Response::new(&self.oscillators, length))
        })
    }
}

/// Values of all Lagrange polynomials of the nodes at the points of the rule between 0 and each target; the targets are the
/// nodes, the places of a series, and the end.
struct Weights {
    targets: Vec<f64>,
    /// For each target: point, and its weight times each polynomial there.
    points: Vec<[(f64, Nodes); POINTS]>,
}

fn weights() -> &'static Weights {
    static WEIGHTS: OnceLock<Weights> = OnceLock::new();
    WEIGHTS.get_or_init(|| {
        let gauss = gauss();
        let rule = rule(POINTS);
        let mut targets = gauss.nodes.to_vec();
        targets.extend(places());
        targets.push(1.0);
        let points = targets.iter().map(|target| {
            std::array::from_fn(|i| {
                let (x, weight) = rule[i];
                let lagrange = gauss.lagrange(target * x);
                (target * x, lagrange.map(|l| target * weight * l))
            })
        });
        Weights {
            points: points.collect(),
            targets,
        }
    })
}

impl Response {
    fn new(oscillators: &[Oscillator], length: f64) -> Self {
        let weights = weights();
        let states = 2 * oscillators.len();
        let mut out = Self {
            length,
            free: vec![Aligned([0.0; NODES]); states],
            forced: [[0.0; NODES]; NODES],
            free_series: vec![Aligned([0.0; TERMS]); states],
            forced_series: Aligned([[0.0; TERMS]; NODES]),
            end: (0..states.div_ceil(BLOCK))
                .map(|_| End::default())
                .collect(),
            free_states: Vec::new(),
            forced_states: Vec::new(),
            linearised: (0..CLASSES * CLASSES).map(|_| OnceLock::new()).collect(),
        };
        for (j, o) in oscillators.iter().enumerate() {
            // q and q' at each target from unit states, and from the force at each node.
            let free: Vec<_> = weights.targets.iter().map(|t| o.free(t * length)).collect();
            let forced: Vec<[Nodes; 2]> = weights
                .targets
                .iter()
                .zip(&weights.points)
                .map(|(target, points)| {
                    let mut sum = [[0.0; NODES]; 2];
                    for (t, weight) in points {
                        let [q, v] = o.free((target - t) * length)[1].map(|x| x * o.gain * length);
                        for i in 0..NODES {
                            sum[0][i] += q * weight[i];
                            sum[1][i] += v * weight[i];
                        }
                    }
                    sum
                })
                .collect();
            for i in 0..NODES {
                for from in 0..2 {
                    out.free[2 * j + from].0[i] = o.seen * free[i][from][1];
                }
                for node in 0..NODES {
                    out.forced[node][i] += o.seen * forced[i][1][node];
                }
            }
            let series =
                |at: &dyn Fn(usize) -> f64| from_values(&std::array::from_fn(|i| at(NODES + i)));
            for what in 0..2 {
                let of_states = [0, 1].map(|from| series(&|i| free[i][from][what]));
                let of_forces: [Chebyshev; NODES] =
                    std::array::from_fn(|node| series(&|i| forced[i][what][node]));
                if what == 1 {
                    for k in 0..TERMS {
                        for from in 0..2 {
                            out.free_series[2 * j + from].0[k] = o.seen * of_states[from][k];
                        }
                        for node in 0..NODES {
                            out.forced_series.0[node][k] += o.seen * of_forces[node][k];
                        }
                    }
                }
                out.free_states.push(Aligned(of_states));
                out.forced_states.push(Aligned(std::array::from_fn(|k| {
                    std::array::from_fn(|node| of_forces[node][k])
                })));
            }
            let (free, forced) = (free[NODES + TERMS], forced[NODES + TERMS]);
            let end = &mut out.end[2 * j / BLOCK];
            for what in 0..2 {
                let i = 2 * j % BLOCK + what;
                end.own[i] = free[what][what];
                end.other[i] = free[1 - what][what];
                for node in 0..NODES {
                    end.forced.0[node][i] = forced[what][node];
                }
            }
        }
        out
    }

    /// The linearised step for slopes in N s/m near those given at its first and last node, up to the steepest there are.
    #[inline]
    pub(super) fn linearised(&self, first: f64, last: f64, mobility: f64) -> &Linearised {
        let unit = mobility * self.length;
        let (first, last) = (class(first * unit), class(last * unit));
        self.linearised[first * CLASSES + last].get_or_init(|| {
            Box::new(self.linearise([first, last].map(|class| middle(class) / unit)))
        })
    }

    /// Falling slopes of a slip that speeds up fall late, those of one that slows down rise evenly in their logarithm.
    fn linearise(&self, [first, last]: [f64; 2]) -> Linearised {
        let slopes = gauss().nodes.map(|theta| {
            if first * last > 0.0 {
                let late = if last.abs() < first.abs() {
                    theta * theta
                } else {
                    theta
                };
                first * (last / first).powf(late)
            } else {
                first + theta * (last - first)
            }
        });
        self.solved_for(slopes)
            // Slopes for which the linear step has no solution do not help; none are as good.
            .or_else(|| self.solved_for([0.0; NODES]))
            .expect("the unit matrix has an inverse")
    }

    fn solved_for(&self, slopes: Nodes) -> Option<Linearised> {
        type Square = SMatrix<f64, NODES, NODES>;
        let forced = Square::from_fn(|i, j| self.forced[j][i]);
        let bent = Square::from_fn(|i, j| self.forced[j][i] * slopes[j]);
        let inverse = (Square::identity() + bent).try_inverse()?;
        let response = inverse * forced;
        let columns = |m: &Square| -> [Nodes; NODES] {
            std::array::from_fn(|j| std::array::from_fn(|i| m[(i, j)]))
        };
        Some(Linearised {
            slopes,
            response: Aligned(columns(&response)),
        })
    }

    /// The states at `theta` of a step from `x` with the forces `-sign capacity` at the nodes.
    pub fn state_at(&self, theta: f64, x: &State, sign: f64, capacity: &Nodes) -> State {
        state_at(self, theta, x, sign, capacity)
    }
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
fn state_at(response: &Response, theta: f64, x: &State, sign: f64, capacity: &Nodes) -> State {
    let terms = nodes::apart(polynomials(theta));
    let mut out = [0.0; MAX_STATES];
    for (i, (own, forced)) in response
        .free_states
        .iter()
        .zip(&response.forced_states)
        .enumerate()
    {
        // Two sums side by side, so that none waits long for the one before.
        let (mut parts, mut odd) = ([0.0; NODES], [0.0; NODES]);
        for k in (0..TERMS).step_by(2) {
            for node in 0..NODES {
                parts[node] = terms[k].mul_add(forced.0[k][node], parts[node]);
                odd[node] = terms[k + 1].mul_add(forced.0[k + 1][node], odd[node]);
            }
        }
        for node in 0..NODES {
            parts[node] += odd[node];
        }
        let parts = nodes::apart(parts);
        let first = i - i % 2;
        let free = dot(&own.0[0], &terms) * x[first] + dot(&own.0[1], &terms) * x[first + 1];
        out[i] = free - sign * nodes::dot(&parts, capacity);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn val_a_constant_force_bends_as_in_closed_form() {
        // Source: q = g/w^2 (1 - cos) for a unit force from rest, undamped; two oscillators side by side.
        let oscillator = |frequency, seen| Oscillator {
            frequency,
            damping: 0.0,
            seen,
            gain: 3.0,
        };
        let ladder = Ladder::new(vec![oscillator(10.0, 2.0), oscillator(70.0, -1.0)]);
        for level in [0, 3] {
            let r = ladder.response(level);
            let at = |theta| r.state_at(theta, &[0.0; MAX_STATES], -1.0, &[1.0; NODES]);
            for (j, w) in [10.0, 70.0].into_iter().enumerate() {
                for theta in [0.1, 0.6, 1.0] {
                    let angle: f64 = w * theta * r.length;
                    let exact = 3.0 / (w * w) * (1.0 - angle.cos());
                    assert_relative_eq!(at(theta)[2 * j], exact, epsilon = 1e-15);
                    let exact = 3.0 / w * angle.sin();
                    assert_relative_eq!(at(theta)[2 * j + 1], exact, epsilon = 1e-14);
                }
                let end: f64 = r.end[0].forced.0.iter().map(|f| f[2 * j]).sum();
                let whole: f64 = w * r.length;
                let exact = 3.0 / (w * w) * (1.0 - whole.cos());
                assert_relative_eq!(end, exact, epsilon = 1e-15);
            }
        }
    }
}

//! Friction that depends on the place along the track, without a period.

use super::series::{EffectSeries, Hooks, MotionSeries, Series, product, sign_until};
use super::{Card, Context, Effect, Motion, Parameter, Role};
use crate::error::PhysicsError;
use crate::real::{Real, ZERO, value};
use crate::unit::{METRE, ONE};

/// Most nodes of a profile.
pub const MAX_NODES: usize = 96;
/// Parameters before the nodes.
const LENGTH: usize = 0;
const START: usize = 1;
const COUNT: usize = 2;
const FIRST_NODE: usize = 3;

/// Describes the effect.
pub static CARD: Card = Card {
    id: "belt_friction_profile",
    title: "Friction depends on the place along the track",
    equation: "mu -> mu [1 + g(s)],  g: natural cubic spline through (start + (i - 1) length/(count - 1), node[i]), \
               constant outside",
    description: "The track is rougher or slicker at some places: the coefficient of friction, static and kinetic, \
                  depends on the place s of the belt that the tip stands on, without a period.",
    source: "Stelter 1992, sect. 2 (fluctuation of friction along the length of the belt); \
             Press et al. 2007, Numerical Recipes, sect. 3.3 (spline)",
    signature: "the same friction at the same place in every passage; long sticks at the same places",
    confounders: "static_friction_aging, belt_periodic_friction, friction_drift; a second passage over the same track \
                  at another speed separates them",
    first_value_reference: 1100,
    parameters: &parameters(),
    states: &[],
    build,
};

const fn parameter(
    name: &'static str,
    description: &'static str,
    unit: crate::unit::Unit,
    (start, typical, min, max): (f64, f64, f64, f64),
    role: Role,
) -> Parameter {
    Parameter {
        name,
        description,
        unit,
        start,
        typical,
        min,
        max,
        role,
    }
}

#[rustfmt::skip]
const NODE_NAMES: [&str; MAX_NODES] = [
    "node[1]", "node[2]", "node[3]", "node[4]", "node[5]", "node[6]", "node[7]", "node[8]",
    "node[9]", "node[10]", "node[11]", "node[12]", "node[13]", "node[14]", "node[15]", "node[16]",
    "node[17]", "node[18]", "node[19]", "node[20]", "node[21]", "node[22]", "node[23]", "node[24]",
    "node[25]", "node[26]", "node[27]", "node[28]", "node[29]", "node[30]", "node[31]", "node[32]",
    "node[33]", "node[34]", "node[35]", "node[36]", "node[37]", "node[38]", "node[39]", "node[40]",
    "node[41]", "node[42]", "node[43]", "node[44]", "node[45]", "node[46]", "node[47]", "node[48]",
    "node[49]", "node[50]", "node[51]", "node[52]", "node[53]", "node[54]", "node[55]", "node[56]",
    "node[57]", "node[58]", "node[59]", "node[60]", "node[61]", "node[62]", "node[63]", "node[64]",
    "node[65]", "node[66]", "node[67]", "node[68]", "node[69]", "node[70]", "node[71]", "node[72]",
    "node[73]", "node[74]", "node[75]", "node[76]", "node[77]", "node[78]", "node[79]", "node[80]",
    "node[81]", "node[82]", "node[83]", "node[84]", "node[85]", "node[86]", "node[87]", "node[88]",
    "node[89]", "node[90]", "node[91]", "node[92]", "node[93]", "node[94]", "node[95]", "node[96]",
];
/// Typical values of the nodes: a rough track, repeated.
const TYPICAL: [f64; 8] = [0.03, -0.06, 0.08, 0.02, -0.09, 0.05, -0.02, 0.07];

const fn parameters() -> [Parameter; FIRST_NODE + MAX_NODES] {
    let node = parameter(
        "",
        "relative change g of friction at a node",
        ONE,
        (0.0, 0.0, -0.8, 0.8),
        Role::Node,
    );
    let mut all = [node; FIRST_NODE + MAX_NODES];
    all[LENGTH] = parameter(
        "length",
        "belt travel from the first node to the last",
        METRE,
        (0.1, 0.1, 1e-3, 10.0),
        Role::Setting,
    );
    all[START] = parameter(
        "start",
        "belt travel s of the first node",
        METRE,
        (0.0, 0.0, -100.0, 100.0),
        Role::Setting,
    );
    all[COUNT] = parameter(
        "count",
        "number of nodes in use; 0 means off",
        ONE,
        (0.0, 16.0, 0.0, MAX_NODES as f64),
        Role::Setting,
    );
    let mut i = 0;
    while i < MAX_NODES {
        all[FIRST_NODE + i].name = NODE_NAMES[i];
        all[FIRST_NODE + i].typical = TYPICAL[i % TYPICAL.len()];
        i += 1;
    }
    all
}

/// A natural cubic spline on a uniform grid: `g = c0 + u (c1 + u (c2 + u c3))` in each interval.
struct Profile {
    start: Real,
    /// Intervals per metre.
    density: Real,
    intervals: usize,
    coefficients: Vec<[Real; 4]>,
}

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let [length, start, count, nodes @ ..] = context.values else {
        unreachable!("three parameters before the nodes")
    };
    if *count == 0.0 {
        return Ok(None);
    }
    context.require(LENGTH, *length > 0.0, "positive")?;
    context.require(START, true, "finite")?;
    let whole = value(*count).fract() == 0.0 && (2.0..=MAX_NODES as f64).contains(&value(*count));
    context.require(COUNT, whole, "0 (off) or a whole number from 2 to 96")?;
    let nodes = &nodes[..value(*count) as usize];
    for (i, g) in nodes.iter().enumerate() {
        context.require(FIRST_NODE + i, *g >= -1.0, "at least -1")?;
    }
    if nodes.iter().all(|g| *g == 0.0) {
        return Ok(None);
    }
    let intervals = nodes.len() - 1;
    Ok(Some(Box::new(Profile {
        start: *start,
        density: intervals as f64 / length,
        intervals,
        coefficients: spline(nodes),
    })))
}

/// Coefficients of the natural cubic spline through nodes one apart.
fn spline(nodes: &[Real]) -> Vec<[Real; 4]> {
    let n = nodes.len();
    // Second derivatives b: b[i-1] + 4 b[i] + b[i+1] = 6 (g[i-1] - 2 g[i] + g[i+1]), 0 at both ends.
    let mut b = [ZERO; MAX_NODES];
    let mut ratio = [ZERO; MAX_NODES];
    for i in 1..n - 1 {
        let pivot = 4.0 - ratio[i - 1];
        ratio[i] = 1.0 / pivot;
        b[i] = (6.0 * (nodes[i - 1] - 2.0 * nodes[i] + nodes[i + 1]) - b[i - 1]) / pivot;
    }
    for i in (1..n - 1).rev() {
        b[i] -= ratio[i] * b[i + 1];
    }
    let interval = |i: usize| {
        let rise = nodes[i + 1] - nodes[i];
        [
            nodes[i],
            rise - (2.0 * b[i] + b[i + 1]) / 6.0,
            b[i] / 2.0,
            (b[i + 1] - b[i]) / 6.0,
        ]
    };
    (0..n - 1).map(interval).collect()
}

impl Profile {
    /// Place on the grid, in intervals from the first node.
    fn place(&self, travel: Real) -> Real {
        (travel - self.start) * self.density
    }

    /// Index of the interval at a place.
    fn interval(&self, travel: Real) -> usize {
        (value(self.place(travel)).max(0.0) as usize).min(self.intervals - 1)
    }
}

impl Effect for Profile {
    fn friction_factor(&self, m: &Motion, _x: &[Real]) -> Real {
        let place = self.place(m.travel).clamp(0.0, self.intervals as f64);
        let i = self.interval(m.travel);
        let u = place - i as f64;
        let c = &self.coefficients[i];
        1.0 + c[0] + u * (c[1] + u * (c[2] + u * c[3]))
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Profile {
    fn hooks(&self) -> Hooks {
        Hooks {
            factor: true,
            ..Hooks::default()
        }
    }

    fn register_count(&self) -> usize {
        2
    }
    fn factor(&self, k: usize, m: &MotionSeries, _x: &[Real], registers: &mut [Series]) -> Real {
        let [u, square, ..] = registers else {
            unreachable!("two registers declared")
        };
        let i = self.interval(m.start.travel);
        let c = &self.coefficients[i];
        u[k] = self.density * m.travel[k];
        if k == 0 {
            u[0] = self.place(m.start.travel) - i as f64;
        }
        square[k] = product(u, u, k);
        let change = c[1] * u[k] + c[2] * square[k] + c[3] * product(square, u, k);
        if k == 0 { 1.0 + c[0] + change } else { change }
    }
    fn until(&self, m: &MotionSeries, registers: &[Series], degree: usize, theta: f64) -> f64 {
        // Within one interval of the spline.
        let place = self.place(m.start.travel);
        let mut left = registers[0];
        left.iter_mut().for_each(|c| *c = -*c);
        left[0] += 1.0;
        if !(0.0..=self.intervals as f64).contains(&place) {
            return 0.0;
        }
        let end = |f: &Series| sign_until(f, degree, theta);
        end(&registers[0]).min(end(&left))
    }
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn val_the_spline_is_natural_and_smooth() {
        // Source: definition of the natural cubic spline: value, slope and curvature are continuous at
        // the inner nodes, curvature is zero at the ends.
        let nodes = [0.1, -0.3, 0.2, 0.05, -0.4];
        let c = spline(&nodes);
        for i in 0..3 {
            assert_relative_eq!(c[i].iter().sum::<f64>(), nodes[i + 1], epsilon = 1e-14);
            let slope = c[i][1] + 2.0 * c[i][2] + 3.0 * c[i][3];
            assert_relative_eq!(slope, c[i + 1][1], epsilon = 1e-14);
            assert_relative_eq!(c[i][2] + 3.0 * c[i][3], c[i + 1][2], epsilon = 1e-14);
        }
        assert_eq!(c[0][2], 0.0);
        assert_relative_eq!(c[3][2] + 3.0 * c[3][3], 0.0, epsilon = 1e-14);
        assert_relative_eq!(c[3].iter().sum::<f64>(), nodes[4], epsilon = 1e-14);
    }
}

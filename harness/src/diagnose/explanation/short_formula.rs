//! A short formula for the curve of an unknown function: sparse regression over a few shapes.
//!
//! The curve's values y at its nodes, with covariance C, are regressed on a constant and one or two shapes,
//!
//! ```text
//! score = 1/2 (y - X b)' C^-1 (y - X b) + 1/2 k ln N
//! ```
//!
//! with k constants and N samples fitted: what the formula loses of the curve's likelihood, and the price of its constants
//! (Schwarz 1978). The constant is not part of the formula: friction level, frequencies or offset take it up. Holds for curves
//! that are smooth between their nodes; what the formula is worth is seen when it is fitted to the data itself.

use crate::diagnose::model::unknown_function::FormulaConstant;
use nalgebra::{DMatrix, DVector};

/// Places of a shape that has one, in units of the largest argument; a fit to the data refines them.
const PLACES: [f64; 6] = [0.05, 0.1, 0.2, 0.3, 0.5, 0.7];

/// A shape: a formula with `X` for the argument and `L` for its place, and its value.
struct Shape {
    formula: &'static str,
    /// Power of the argument's unit that the value has.
    power: i32,
    value: fn(f64, f64) -> f64,
}

const fn shape(formula: &'static str, power: i32, value: fn(f64, f64) -> f64) -> Shape {
    Shape {
        formula,
        power,
        value,
    }
}

/// Even and odd powers ...
const POWERS: [Shape; 5] = [
    shape("X", 1, |x, _| x),
    shape("X^2", 2, |x, _| x * x),
    shape("X^3", 3, |x, _| x * x * x),
    shape("abs(X)", 1, |x, _| x.abs()),
    shape("abs(X)*X", 2, |x, _| x.abs() * x),
];
/// ..., saturation, step, and thresholds.
const PLACED: [Shape; 4] = [
    shape("1 - exp(-abs(X)/L)", 0, |x, l| 1.0 - (-x.abs() / l).exp()),
    shape("tanh(X/L)", 0, |x, l| (x / l).tanh()),
    shape("max(X - L, 0)", 1, |x, l| (x - l).max(0.0)),
    shape("max(abs(X) - L, 0)", 1, |x, l| (x.abs() - l).max(0.0)),
];

/// A formula for a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct ShortFormula {
    /// The curve but for its constant, in terms of the variable.
    pub curve: String,
    /// Its constants.
    pub constants: Vec<FormulaConstant>,
    /// The constant that it leaves out.
    pub level: f64,
    /// What it loses and costs, nats.
    pub score: f64,
}

/// A curve to be described.
pub struct Curve<'a> {
    /// Places of the nodes.
    pub at: &'a [f64],
    /// Values there.
    pub values: &'a DVector<f64>,
    /// Their covariance.
    pub covariance: &'a DMatrix<f64>,
    /// Samples that it was fitted to.
    pub samples: f64,
    /// What a formula calls the argument, and its unit.
    pub variable: (&'a str, &'a str),
    /// Unit of the values.
    pub unit: &'a str,
}

/// The best formula of one shape and the best of two for a curve, the better first; none where its covariance is not known. The
/// data themselves say whether a second shape is worth its constants.
pub fn short_formulas(curve: &Curve) -> Vec<ShortFormula> {
    let largest = curve.at.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
    let mut columns: Vec<(&Shape, Option<f64>)> = POWERS.iter().map(|s| (s, None)).collect();
    for shape in &PLACED {
        columns.extend(PLACES.map(|p| (shape, Some(p * largest))));
    }
    let Some(factor) = curve.covariance.clone().cholesky() else {
        return Vec::new();
    };
    // Columns of a node's unit standard deviation each.
    let whiten = |v: DVector<f64>| {
        factor
            .l()
            .solve_lower_triangular(&v)
            .expect("the factor of a positive definite matrix")
    };
    let y = whiten(curve.values.clone());
    let of = |f: &dyn Fn(f64) -> f64| {
        whiten(DVector::from_iterator(
            curve.at.len(),
            curve.at.iter().map(|&x| f(x)),
        ))
    };
    let level = of(&|_| 1.0);
    let designs: Vec<DVector<f64>> = columns
        .iter()
        .map(|(s, l)| of(&|x| (s.value)(x, l.unwrap_or(f64::NAN))))
        .collect();
    let mut found: Vec<ShortFormula> = Vec::new();
    let mut try_with = |chosen: &[usize]| {
        let parts = chosen.iter().map(|&i| designs[i].clone());
        let design: Vec<DVector<f64>> = std::iter::once(level.clone()).chain(parts).collect();
        let design = DMatrix::from_columns(&design);
        let Ok(b) = design.clone().svd(true, true).solve(&y, 1e-10) else {
            return;
        };
        let left = (&y - &design * &b).norm_squared();
        let places = chosen.iter().filter(|&&i| columns[i].1.is_some()).count();
        let constants = (chosen.len() + places) as f64;
        let chosen: Vec<_> = chosen.iter().map(|&i| columns[i]).collect();
        found.push(ShortFormula {
            score: 0.5 * left + 0.5 * constants * curve.samples.max(2.0).ln(),
            level: b[0],
            curve: formula(&chosen, curve.variable.0),
            constants: constants_of(&chosen, &b, curve),
        });
    };
    for i in 0..columns.len() {
        try_with(&[i]);
        for j in 0..i.min(POWERS.len()) {
            try_with(&[j, i]);
        }
    }
    found.sort_by(|a, b| a.score.total_cmp(&b.score));
    let shapes = |f: &ShortFormula| f.constants.iter().filter(|c| !c.is_shape).count();
    let mut best: Vec<ShortFormula> = Vec::new();
    for formula in found {
        if best.iter().all(|b| shapes(b) != shapes(&formula)) {
            best.push(formula);
        }
    }
    best
}

fn formula(chosen: &[(&Shape, Option<f64>)], variable: &str) -> String {
    let part = |(i, (shape, _)): (usize, &(&Shape, Option<f64>))| {
        let of = shape.formula.replace('X', variable);
        let of = of.replace('L', &format!("l_{}", i + 1));
        format!("c_{}*({of})", i + 1)
    };
    let parts: Vec<String> = chosen.iter().enumerate().map(part).collect();
    parts.join(" + ")
}

fn constants_of(
    chosen: &[(&Shape, Option<f64>)],
    b: &DVector<f64>,
    curve: &Curve,
) -> Vec<FormulaConstant> {
    let unit = |power: i32| per(curve.unit, curve.variable.1, power);
    let mut out = Vec::new();
    for (i, (shape, place)) in chosen.iter().enumerate() {
        out.push(FormulaConstant {
            name: format!("c_{}", i + 1),
            unit: unit(shape.power),
            value: b[i + 1],
            is_shape: false,
        });
        out.extend(place.map(|place| FormulaConstant {
            name: format!("l_{}", i + 1),
            unit: curve.variable.1.to_owned(),
            value: place,
            is_shape: true,
        }));
    }
    out
}

/// The unit of a value over a power of an argument.
fn per(unit: &str, argument: &str, power: i32) -> String {
    let exponent = if power > 1 {
        power.to_string()
    } else {
        String::new()
    };
    match (power, argument) {
        (0, _) | (_, "1") => unit.to_owned(),
        (_, "m/s") if unit == "1" => format!("s{exponent}/m{exponent}"),
        (_, "m/s") => format!("{unit}.s{exponent}/m{exponent}"),
        _ => format!("{unit}/{argument}{exponent}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The best formula of a curve with the same standard deviation at each node.
    fn best(f: impl Fn(f64) -> f64, from: f64, std: f64) -> ShortFormula {
        let at: Vec<f64> = (0..8)
            .map(|i| from + (1.0 - from) * f64::from(i) / 7.0)
            .collect();
        let values = DVector::from_iterator(8, at.iter().map(|&x| f(x)));
        let curve = Curve {
            at: &at,
            values: &values,
            covariance: &(DMatrix::identity(8, 8) * std * std),
            samples: 1000.0,
            variable: ("w", "m"),
            unit: "N",
        };
        short_formulas(&curve).remove(0)
    }

    #[test]
    fn shapes_are_found_again_with_their_constants() {
        let cubic = best(|x| 3.0 - 2.0 * x.powi(3), -1.0, 1e-3);
        assert_eq!(cubic.curve, "c_1*(w^3)");
        assert!((cubic.constants[0].value + 2.0).abs() < 1e-6 && (cubic.level - 3.0).abs() < 1e-6);
        assert_eq!(cubic.constants[0].unit, "N/m3");
        let saturated = best(|x| 1.0 - (-x / 0.2).exp(), 0.0, 1e-3);
        assert_eq!(saturated.curve, "c_1*(1 - exp(-abs(w)/l_1))");
        assert!((saturated.constants[1].value - 0.2).abs() < 1e-9);
        let both = best(|x| x - 0.5 * x * x, -1.0, 1e-3);
        assert!(
            both.curve.contains("w^2") && both.curve.contains("(w)"),
            "{both:?}"
        );
    }

    #[test]
    fn what_is_not_known_well_gets_the_simplest_formula() {
        let found = best(|x| x + 0.1 * x.powi(3), -1.0, 0.5);
        assert_eq!(found.constants.len(), 1, "{found:?}");
    }
}

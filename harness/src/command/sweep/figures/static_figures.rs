//! Figures 1, 2 and 4: what needs no motion.

use std::fmt::Write as _;

use beam_physics::sweep::{mode_shape, static_compliance};

use super::claim::{Bound, Claim, Finding};
use super::{PaperFigure, Workshop};
use crate::error::Error;
use crate::report::{Axis, Colour, Plot, number};

const POINTS: usize = 200;

fn places() -> Vec<f64> {
    (0..=POINTS).map(|i| i as f64 / POINTS as f64).collect()
}

/// First root of cos k cosh k = -1, of the lowest mode of a cantilever.
const FIRST_ROOT: f64 = 1.875_104_068_711_961;

/// Figure 1.
pub fn cantilever(workshop: &Workshop) -> Result<PaperFigure, Error> {
    const FORCE: f64 = 66.0;
    let get = |name: &str| workshop.values(&[]).get(name).unwrap_or(f64::NAN);
    let first = std::f64::consts::TAU * get("mode[1].frequency");
    // E I/l^3 of a uniform beam of this first mode.
    let rigidity = get("mode[1].mass") * first * first / FIRST_ROOT.powi(4);
    let compliance = |modes: f64| {
        let values = workshop.values(&[("mode_count", modes)]);
        values.model().map_or(f64::NAN, |m| static_compliance(&m))
    };
    let share = |modes: f64| 100.0 * compliance(modes) * 3.0 * rigidity;
    let xi = places();
    let exact: Vec<f64> = xi
        .iter()
        .map(|x| 1e3 * FORCE / rigidity * (3.0 * x * x - x.powi(3)) / 6.0)
        .collect();
    let with = |modes: usize| -> Vec<f64> {
        let values = workshop.values(&[("mode_count", modes as f64)]);
        let get = |j: usize, part: &str| {
            values
                .get(&format!("mode[{}].{part}", j + 1))
                .unwrap_or(f64::NAN)
        };
        let deflection = |x: &f64| -> f64 {
            (0..modes)
                .map(|j| {
                    let w = std::f64::consts::TAU * get(j, "frequency");
                    let tip = get(j, "tip_value");
                    // Shape and tip value may differ in sign or scale.
                    let shape = mode_shape(j, *x) * tip / mode_shape(j, 1.0);
                    1e3 * FORCE * shape * tip / (get(j, "mass") * w * w)
                })
                .sum()
        };
        xi.iter().map(deflection).collect()
    };
    let (one, two) = (with(1), with(2));
    let mut csv = String::from("xi,one_mode_m,two_modes_m,exact_m\n");
    for (((x, a), b), c) in xi.iter().zip(&one).zip(&two).zip(&exact) {
        let _ = writeln!(csv, "{x},{},{},{}", 1e-3 * a, 1e-3 * b, 1e-3 * c);
    }
    workshop.data("figure1.csv", &csv)?;
    let plot = Plot::new(
        Axis::linear("place along the beam x/l", "1"),
        Axis::linear("deflection", "mm"),
    )
    .line("exact, F l³/(3 E I) at the tip", Colour::Grey, &xi, &exact)
    .dashed_line("one mode", Colour::Orange, &xi, &one)
    .dashed_line("two modes", Colour::Blue, &xi, &two)
    .size(900.0, 420.0)
    .caption("The cantilever bent by a force of 66 N at its tip, the break-away force at 100 N: exact, with one mode and with two.");
    Ok(PaperFigure {
        number: "1",
        title: "Cantilever driven by dry friction at its tip".into(),
        claims: vec![cantilever_claim(share(1.0), share(2.0))],
        pictures: vec![("figure1".into(), plot)],
    })
}

fn cantilever_claim(one: f64, two: f64) -> Claim {
    Claim::new(
        "The modal approach, eqs. (2) and (3), with two modes stands for the continuous beam of eq. (1).",
        format!(
            "The paper's beam dimensions are not known; only statics can be compared. One mode has {} % of the compliance",
            number(one, 4)
        ),
        vec![Finding::new(
            "static compliance of two modes as share of the uniform beam's l³/(3 E I)",
            two,
            "%",
            Bound::Between(98.0, 102.0),
            "the natural frequencies are given to 0.5 of 80 Hz, which is 1.3 % of stiffness",
        )],
    )
}

/// Eq. (6) with the factor k.
fn equation_6(k: f64, xi: f64) -> f64 {
    let ratio = (k.cos() + k.cosh()) / (k.sin() + k.sinh());
    let z = k * xi;
    ratio * (z.sin() - z.sinh()) - (z.cos() - z.cosh())
}

/// Figure 2.
pub fn mode_shapes(workshop: &Workshop) -> Result<PaperFigure, Error> {
    let xi = places();
    let shape = |j: usize| xi.iter().map(|x| mode_shape(j, *x)).collect::<Vec<_>>();
    let printed = |k: f64| xi.iter().map(|x| equation_6(k, *x)).collect::<Vec<_>>();
    let (first, second) = (shape(0), shape(1));
    let mut csv = String::from("xi,phi_1,phi_2\n");
    for ((x, a), b) in xi.iter().zip(&first).zip(&second) {
        let _ = writeln!(csv, "{x},{a},{b}");
    }
    workshop.data("figure2.csv", &csv)?;
    // The node: where the second shape changes its sign away from the clamp.
    let node = (POINTS / 10..POINTS).find(|&i| second[i] * second[i + 1] <= 0.0);
    let node = node.map_or(f64::NAN, |i| {
        xi[i] + (xi[i + 1] - xi[i]) * second[i] / (second[i] - second[i + 1])
    });
    let apart = |a: &[f64], b: &[f64]| {
        let each = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        each.fold(0.0, f64::max)
    };
    let modes = [(1.875, &first), (4.694, &second)].map(|(k, own)| ModeShape {
        off: apart(own, &printed(k)),
        rounding: [k - 5e-4, k + 5e-4]
            .map(|k_off| apart(&printed(k_off), &printed(k)))
            .into_iter()
            .fold(0.0, f64::max),
    });
    let plot = Plot::new(
        Axis::linear("place along the beam x/l", "1"),
        Axis::linear("mode shape", "1"),
    )
    .line("first mode", Colour::Blue, &xi, &first)
    .line("second mode", Colour::Orange, &xi, &second)
    .level("", Colour::Grey, 0.0)
    .size(900.0, 420.0)
    .caption("The first two mode shapes of the cantilever, eq. (6).");
    Ok(PaperFigure {
        number: "2",
        title: "Mode shapes".into(),
        claims: vec![mode_shapes_claim(&modes, node)],
        pictures: vec![("figure2".into(), plot)],
    })
}

/// How far a shape is from eq. (6) as printed, and how far the rounding of k may take it.
struct ModeShape {
    off: f64,
    rounding: f64,
}

fn mode_shapes_claim(modes: &[ModeShape; 2], node: f64) -> Claim {
    let findings = modes.iter().zip(["first", "second"]).map(|(m, name)| {
        Finding::new(
            format!("{name} mode: largest difference from eq. (6) with the printed k"),
            m.off,
            "",
            Bound::AtMost(m.rounding),
            "what half a unit of the last printed digit of k makes of eq. (6)",
        )
    });
    Claim::new(
        "The first two eigenfunctions are those of eq. (6) with k_1 = 1.875 and k_2 = 4.694.",
        format!("The second mode has its node at x/l = {}", number(node, 3)),
        findings.collect(),
    )
}

/// Figure 4.
pub fn friction(workshop: &Workshop) -> Result<PaperFigure, Error> {
    const POINTS: usize = 400;
    const FASTEST: f64 = 0.5;
    let v: Vec<f64> = (0..=POINTS)
        .map(|i| FASTEST * (i as f64 / POINTS as f64).powi(2))
        .collect();
    let law = |which: f64| -> Vec<f64> {
        let values = workshop.values(&[("friction.law", which)]);
        let at = |v: &f64| values.friction_coefficient(*v).unwrap_or(f64::NAN);
        v.iter().map(at).collect()
    };
    let (read, printed) = (law(1.0), law(2.0));
    let mut csv = String::from("speed_m_per_s,mu_as_read,mu_as_printed\n");
    for ((v, a), b) in v.iter().zip(&read).zip(&printed) {
        let _ = writeln!(csv, "{v},{a},{b}");
    }
    workshop.data("figure4.csv", &csv)?;
    let top = (1..=POINTS).max_by(|a, b| printed[*a].total_cmp(&printed[*b]));
    let top = v[top.unwrap_or(0)];
    // The first point is rest, where the printed law has no value of its own.
    let rise = |mu: &[f64]| {
        let steps = mu[1..].windows(2).map(|w| w[1] - w[0]);
        steps.filter(|d| *d > 0.0).sum::<f64>()
    };
    let plot = Plot::new(
        Axis::linear("sliding speed |v_r|", "m/s"),
        Axis::linear("coefficient of friction", "1").from_to(0.0, 0.7),
    )
    .line(
        "eq. (7), exponent read as |v_r|/c1",
        Colour::Blue,
        &v,
        &read,
    )
    .dashed_line("eq. (7) as printed", Colour::Orange, &v[1..], &printed[1..])
    .size(900.0, 420.0)
    .caption("The friction characteristic, eq. (7), as this model reads it and as it is printed.");
    let context = format!(
        "With the exponent read as |v_r|/c1, mu falls from {} to {} at {FASTEST} m/s; as printed it rises up to {} m/s, and nothing would \
         vibrate by itself",
        number(read[0], 3),
        number(read[POINTS], 3),
        number(top, 2)
    );
    Ok(PaperFigure {
        number: "4",
        title: "Friction characteristic".into(),
        claims: vec![friction_claim(rise(&read), rise(&printed), context)],
        pictures: vec![("figure4".into(), plot)],
    })
}

fn friction_claim(read: f64, printed: f64, context: String) -> Claim {
    let finding = |what: &str, rise| {
        Finding::new(
            format!("sum of all rises of mu from 0 to 0.5 m/s, {what}"),
            rise,
            "",
            Bound::AtMost(0.0),
            "friction that falls rises nowhere",
        )
    };
    Claim::new(
        "The measured means are approximated by eq. (7), a friction that falls with speed.",
        context,
        vec![
            finding("exponent read as |v_r|/c1", read),
            finding("as printed", printed),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::super::claim::Verdict;
    use super::*;

    #[test]
    fn verdicts_come_out_both_ways() {
        assert_eq!(cantilever_claim(97.0, 99.5).verdict(), Verdict::Agrees);
        assert_eq!(cantilever_claim(80.0, 90.0).verdict(), Verdict::Differs);
        let shapes = |off| {
            [(); 2].map(|()| ModeShape {
                off,
                rounding: 2e-3,
            })
        };
        assert_eq!(
            mode_shapes_claim(&shapes(1e-3), 0.78).verdict(),
            Verdict::Agrees
        );
        assert_eq!(
            mode_shapes_claim(&shapes(3e-3), 0.78).verdict(),
            Verdict::Differs
        );
        let friction = |a, b| friction_claim(a, b, String::new()).verdict();
        assert_eq!(friction(0.0, 0.0), Verdict::Agrees);
        assert_eq!(friction(0.0, 0.3), Verdict::InPart);
        assert_eq!(friction(0.1, 0.3), Verdict::Differs);
    }

    #[test]
    fn val_equation_6_is_clamped_and_two_at_the_tip() {
        // Source: Stelter 1992, eq. (6), evaluated by hand: zero and level at the clamp, 2 and -2 at the tip.
        for (k, tip) in [(FIRST_ROOT, 2.0), (4.694_091_132_974_174, -2.0)] {
            assert!(equation_6(k, 0.0).abs() < 1e-12);
            assert!((equation_6(k, 1e-4) / 1e-4).abs() < 1e-2);
            assert!(
                (equation_6(k, 1.0) - tip).abs() < 1e-6,
                "{}",
                equation_6(k, 1.0)
            );
        }
    }
}

//! Figures 2 and 4: what needs no motion.

use std::fmt::Write as _;

use beam_physics::sweep::mode_shape;

use super::{Claim, PaperFigure, Verdict, Workshop};
use crate::error::Error;
use crate::report::{Axis, Colour, Plot, number};

/// Figure 2.
pub fn mode_shapes(workshop: &Workshop) -> Result<PaperFigure, Error> {
    const POINTS: usize = 200;
    let xi: Vec<f64> = (0..=POINTS).map(|i| i as f64 / POINTS as f64).collect();
    let shape = |j: usize| xi.iter().map(|x| mode_shape(j, *x)).collect::<Vec<_>>();
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
    let plot = Plot::new(
        Axis::linear("place along the beam x/l", "1"),
        Axis::linear("mode shape", "1"),
    )
    .line("first mode", Colour::Blue, &xi, &first)
    .line("second mode", Colour::Orange, &xi, &second)
    .level("", Colour::Grey, 0.0)
    .caption("The first two mode shapes of the cantilever, eq. (6).");
    Ok(PaperFigure {
        number: "2",
        title: "Mode shapes".into(),
        claims: vec![Claim {
            paper: "The first two eigenfunctions, eq. (6), with k_1 = 1.875 and k_2 = 4.694."
                .into(),
            model: format!(
                "values {} and {} at the tip; node of the second mode at x/l = {} (theory: 0.783)",
                number(first[POINTS], 4),
                number(second[POINTS], 4),
                number(node, 3)
            ),
            verdict: Verdict::Agrees,
        }],
        pictures: vec![("figure2".into(), Box::new(plot))],
    })
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
    let falls = read.windows(2).all(|w| w[1] < w[0]);
    let top = (1..=POINTS).max_by(|a, b| printed[*a].total_cmp(&printed[*b]));
    let top = v[top.unwrap_or(0)];
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
    .caption("The friction characteristic, eq. (7), as this model reads it and as it is printed.");
    Ok(PaperFigure {
        number: "4",
        title: "Friction characteristic".into(),
        claims: vec![Claim {
            paper:
                "The measured means are approximated by eq. (7), a friction that falls with speed."
                    .into(),
            model: format!(
                "with the exponent read as |v_r|/c1, mu falls from {} to {} at {FASTEST} m/s{}; as printed it would rise up to {} m/s, and \
                 nothing would vibrate by itself",
                number(read[0], 3),
                number(read[POINTS], 3),
                if falls {
                    ", everywhere"
                } else {
                    ", but not everywhere"
                },
                number(top, 2)
            ),
            verdict: if falls {
                Verdict::InPart
            } else {
                Verdict::Differs
            },
        }],
        pictures: vec![("figure4".into(), Box::new(plot))],
    })
}

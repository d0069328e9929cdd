//! Figures 15 and 16: embedding, correlation integral and dimension at the paper's two operating points.

use super::claim::{Bound, Claim, Finding};
use super::{PaperFigure, Workshop};
use crate::command::dimension::pictures;
use crate::command::dimension::series::Series;
use crate::dimension::{Analysis, Settings, Verdict, analyse};
use crate::error::Error;
use crate::report::{Plot, number};

/// Samples, as in the paper; interval and time before them in s, which the paper does not say.
const SAMPLES: usize = 15_000;
const INTERVAL: f64 = 2.5e-4;
const SETTLE: f64 = 5.0;
/// Normal force in N and belt velocities in m/s.
const FORCE: f64 = 41.0;
const REGULAR: f64 = 0.02;
const IRREGULAR: f64 = 0.21;
/// Tolerated deviation from the paper's dimensions, as share.
const TENTH: f64 = 0.1;

/// What counts of a motion.
struct Attractor {
    /// Correlation dimension; NaN where none is claimed.
    dimension: f64,
    /// Largest Lyapunov exponent in 1/s.
    exponent: f64,
    /// In words.
    words: String,
}

/// The figures.
pub fn figures(workshop: &Workshop) -> Result<Vec<PaperFigure>, Error> {
    workshop.begin("figures 15 and 16: correlation dimension");
    let (regular, first) = attractor(workshop, REGULAR, "figure15")?;
    let (irregular, second) = attractor(workshop, IRREGULAR, "figure16")?;
    let order = order_claim(&regular, &irregular);
    Ok(vec![
        PaperFigure {
            number: "15",
            title: "Embedded regular time series and correlation integral (41 N, 20 mm/s)".into(),
            claims: vec![regular_claim(&regular)],
            pictures: first,
        },
        PaperFigure {
            number: "16",
            title: "Embedded irregular time series and correlation integral (41 N, 210 mm/s)"
                .into(),
            claims: vec![irregular_claim(&irregular), order],
            pictures: second,
        },
    ])
}

type Pictures = Vec<(String, Plot)>;

fn attractor(
    workshop: &Workshop,
    velocity: f64,
    file: &str,
) -> Result<(Attractor, Pictures), Error> {
    let outputs = ["tip_displacement"];
    let point = (FORCE, velocity);
    let mut found = workshop.record(point, &outputs, INTERVAL, SETTLE, SAMPLES)?;
    let series = Series {
        name: format!("{FORCE} N, {velocity} m/s"),
        quantity: "tip displacement".into(),
        unit: "m".into(),
        interval: Some(INTERVAL),
        values: found.remove(0),
    };
    let a = analyse(&series.values, &Settings::default(), workshop.watch).map_err(|source| {
        Error::Dimension {
            series: series.name.clone(),
            source,
        }
    })?;
    workshop.data(&format!("{file}.csv"), &sums(&a))?;
    let values = workshop.values(&[("normal_force", FORCE), ("belt_velocity", velocity)]);
    let exponent = workshop.fixed(&values).and_then(|m| m.lyapunov);
    let shown: Pictures = vec![
        (
            format!("{file}_embedding"),
            pictures::embedding(&series, &a),
        ),
        (file.to_owned(), pictures::sums(&series, &a)),
        (format!("{file}_slopes"), pictures::slopes(&series, &a)),
    ];
    let found = Attractor {
        dimension: match a.verdict {
            // A closed curve.
            Verdict::Periodic => 1.0,
            _ => a.dimension().unwrap_or(f64::NAN),
        },
        exponent: exponent.unwrap_or(f64::NAN),
        words: words(&a),
    };
    Ok((found, shown))
}

fn sums(a: &Analysis) -> String {
    use std::fmt::Write as _;
    let mut csv = String::from("m,radius_m,pairs,local_slope\n");
    for (m, counts) in a.sum.counts.iter().enumerate() {
        for ((radius, pairs), slope) in a.sum.radii.iter().zip(counts).zip(&a.slopes[m]) {
            let slope = if slope.is_finite() {
                slope.to_string()
            } else {
                String::new()
            };
            let _ = writeln!(csv, "{},{radius},{pairs},{slope}", m + 1);
        }
    }
    csv
}

fn words(a: &Analysis) -> String {
    // Where C is near 0.001, as far as it is resolved.
    let slope = |m: usize| {
        let shares = a.sum.sums(m);
        let k = (0..shares.len()).find(|k| shares[*k] >= 1e-3)?;
        Some(a.slopes[m - 1][k]).filter(|s| s.is_finite())
    };
    let listed: Vec<String> = [2, 4, 6, 8, 10]
        .into_iter()
        .filter_map(|m| Some(format!("{} at m = {m}", number(slope(m)?, 3))))
        .collect();
    format!(
        "Verdict of the analysis: {}. Slopes of the correlation integral where it is near 0.001: {}. 15 000 samples can show no dimension above 2 \
         log10 N = {}",
        a.verdict.title().to_lowercase(),
        listed.join(", "),
        number(a.eckmann_ruelle_bound(), 2)
    )
}

fn dimension(value: f64, paper: f64) -> Finding {
    Finding::new(
        "correlation dimension",
        value,
        "",
        Bound::Between(paper * (1.0 - TENTH), paper * (1.0 + TENTH)),
        "the paper gives no error; slopes that agree within 10 % are Albano's criterion for one dimension",
    )
}

const EXPONENT: &str = "largest Lyapunov exponent (variational equation)";

fn regular_claim(a: &Attractor) -> Claim {
    attractor_claim(
        "At 41 N and 20 mm/s the motion is regular, of dimension 2.3.",
        a,
        (
            Bound::AtMost(0.0),
            "neighbours of a regular motion do not part",
        ),
        2.3,
    )
}

fn irregular_claim(a: &Attractor) -> Claim {
    attractor_claim(
        "At 41 N and 210 mm/s the motion is irregular, of dimension 5.1.",
        a,
        (Bound::Above(0.0), "neighbours of a chaotic motion part"),
        5.1,
    )
}

/// A claim of how neighbours part, with the bound of their exponent and its reason, and of the dimension.
fn attractor_claim(
    paper: &str,
    a: &Attractor,
    (bound, reason): (Bound, &str),
    of_dimension: f64,
) -> Claim {
    Claim::new(
        paper,
        a.words.clone(),
        vec![
            Finding::new(EXPONENT, a.exponent, "1/s", bound, reason),
            dimension(a.dimension, of_dimension),
        ],
    )
}

fn order_claim(regular: &Attractor, irregular: &Attractor) -> Claim {
    let rise = irregular.exponent - regular.exponent;
    let context = if rise < 0.0 {
        format!(
            "The model has it the other way round: its exponent is {} /s at 20 mm/s and {} /s at 210 mm/s. The paper's motion is measured, on a \
             belt whose friction fluctuates; the model leaves that out",
            number(regular.exponent, 3),
            number(irregular.exponent, 3)
        )
    } else {
        String::new()
    };
    Claim::new(
        "The faster belt makes the irregular motion.",
        context,
        vec![Finding::new(
            "exponent at 210 mm/s less exponent at 20 mm/s",
            rise,
            "1/s",
            Bound::Above(0.0),
            "more irregular is what parts faster",
        )],
    )
}

#[cfg(test)]
mod tests {
    use super::super::claim;
    use super::*;

    #[test]
    fn verdicts_come_out_both_ways() {
        use claim::Verdict::{Agrees, Differs, InPart};
        let of = |dimension, exponent| Attractor {
            dimension,
            exponent,
            words: String::new(),
        };
        assert_eq!(regular_claim(&of(2.2, -1.0)).verdict(), Agrees);
        assert_eq!(regular_claim(&of(f64::NAN, -1.0)).verdict(), InPart);
        assert_eq!(regular_claim(&of(f64::NAN, 48.0)).verdict(), Differs);
        assert_eq!(irregular_claim(&of(5.0, 30.0)).verdict(), Agrees);
        assert_eq!(irregular_claim(&of(1.0, -2.0)).verdict(), Differs);
        let (calm, wild) = (of(1.0, -2.0), of(4.0, 48.0));
        assert_eq!(order_claim(&calm, &wild).verdict(), Agrees);
        let reversed = order_claim(&wild, &calm);
        assert_eq!(reversed.verdict(), Differs);
        assert!(reversed.model.contains("48 /s"));
    }
}

//! What Figures 6 and 7 owe to the second natural frequency, which the paper states to three digits.
//!
//! Where windows of longer periods lie, and which periods they have, turns on how far mode 2 has turned when a stick begins, that is
//! on f_2/f_1 times the cycle's length: half a hertz of 510 moves every window.

use super::Workshop;
use crate::command::sweep::pictures;
use crate::command::sweep::plan::StartKind;
use crate::command::sweep::study::Study;
use crate::error::Error;
use crate::report::{Plot, number};

/// The paper's magnification of Figure 6, m/s.
const MAGNIFICATION: (f64, f64) = (0.06, 0.09);
/// Figure 7, m/s.
const FIGURE_7: (f64, f64) = (0.096, 0.112);

/// Kinds of motion over belt velocity and second natural frequency at 100 N.
pub struct SecondFrequency {
    /// The map.
    pub picture: Plot,
    /// The paper's second natural frequency in Hz.
    nominal: f64,
    /// Number of frequencies tried.
    tried: usize,
    /// Frequencies in Hz at which the magnification of Figure 6 has something else than period one at a tenth of its points or more.
    strange: Vec<f64>,
    /// Frequencies in Hz at which Figure 7's range has periods one and four and irregular motions.
    as_figure_7: Vec<f64>,
}

impl SecondFrequency {
    /// Computes the map.
    ///
    /// # Errors
    /// As the study.
    pub fn new(workshop: &Workshop) -> Result<Self, Error> {
        let axes = [
            ("belt_velocity", "m/s", 0.06, 0.112, workshop.points(53)),
            ("mode[2].frequency", "Hz", 505.0, 530.0, workshop.points(51)),
        ];
        let set = [("normal_force", 100.0)];
        workshop.study("second_frequency", &axes, &set, &[StartKind::Fixed], |s| {
            Self {
                picture: pictures::map(s, StartKind::Fixed),
                nominal: s.plan.base.get("mode[2].frequency").unwrap_or(f64::NAN),
                tried: s.plan.axes[1].values.len(),
                strange: frequencies(s, MAGNIFICATION, |kinds| {
                    10 * (kinds.longer + kinds.irregular) >= kinds.all
                }),
                as_figure_7: frequencies(s, FIGURE_7, |kinds| {
                    kinds.one > 0 && kinds.four > 0 && kinds.irregular > 0
                }),
            }
        })
    }

    /// Of the frequencies tried, the share in % that shows the magnification of Figure 6 as the paper has it.
    pub fn share_strange(&self) -> f64 {
        100.0 * self.strange.len() as f64 / self.tried as f64
    }

    /// What it says of the magnification of Figure 6.
    pub fn of_magnification(&self) -> String {
        let nominal = self.nominal;
        let nearest = |a: &&f64, b: &&f64| (**a - nominal).abs().total_cmp(&(**b - nominal).abs());
        match self.strange.iter().min_by(nearest) {
            Some(f) => format!(
                "With a second natural frequency of {} Hz instead of {} Hz (the paper rounds it, and the windows turn on it: map beside \
                 Figure 7) a tenth of the range or more has longer periods and irregular motions, as at {} of the {} frequencies from 505 to 530 Hz",
                number(*f, 4),
                number(nominal, 4),
                self.strange.len(),
                self.tried
            ),
            None => {
                "No other second natural frequency from 505 to 530 Hz interrupts it either".into()
            }
        }
    }

    /// What it says of Figure 7.
    pub fn of_figure_7(&self) -> String {
        if self.as_figure_7.is_empty() {
            return "No second natural frequency from 505 to 530 Hz on the grid has periods one and four and irregular motions together".into();
        }
        let list: Vec<String> = self.as_figure_7.iter().map(|f| number(*f, 4)).collect();
        format!(
            "Periods one and four and irregular motions together occur with the second natural frequency at {} Hz: the period of the windows turns on \
             less than the paper's rounding of 510 Hz",
            list.join(", ")
        )
    }
}

/// How often each kind of motion occurs at one frequency.
#[derive(Default)]
struct Kinds {
    all: usize,
    one: usize,
    four: usize,
    longer: usize,
    irregular: usize,
}

/// Frequencies in Hz at which the motions at belt velocities in `range` are as wanted.
fn frequencies(study: &Study, range: (f64, f64), is_wanted: impl Fn(&Kinds) -> bool) -> Vec<f64> {
    let grid = &study.plan.axes[1].values;
    let wanted = grid.iter().filter(|f| {
        let mut kinds = Kinds::default();
        for (row, r) in study.rows.iter().zip(&study.results) {
            let v = row.at[0];
            // Ends of ranges on the grid belong to it, whatever their last digit.
            if row.at[1] != **f || v < range.0 - 1e-9 || v > range.1 + 1e-9 {
                continue;
            }
            kinds.all += 1;
            let is_settled = r.status == "ok";
            match r.period {
                Some(1) if is_settled => kinds.one += 1,
                Some(0) if is_settled => kinds.irregular += 1,
                Some(period) if is_settled => {
                    kinds.longer += 1;
                    kinds.four += usize::from(period == 4);
                }
                _ => {}
            }
        }
        is_wanted(&kinds)
    });
    wanted.copied().collect()
}

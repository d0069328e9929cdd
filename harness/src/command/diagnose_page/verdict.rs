//! The verdict bar and what was found in plain words.

use super::{Material, SECTIONS};
use crate::diagnose::result::diagnosis::{Diagnosis, FoundEffect, Verdict};
use crate::diagnose::selection::ties::others;
use crate::diagnose::thresholds::TIE;
use crate::diagnose::validation::estimate::Estimate;
use crate::report::{Colour, Page, number};

/// The bar that stays in sight.
pub fn banner(page: Page, material: &Material) -> Page {
    let diagnosis = material.diagnosis;
    let colour = match diagnosis.verdict {
        Verdict::EffectFound => Colour::Blue,
        Verdict::NoMissingEffect => Colour::Green,
        Verdict::UnknownEffect => Colour::Red,
    };
    page.banner(colour, &headline(material), &fall(material), &SECTIONS)
}

fn headline(material: &Material) -> String {
    let diagnosis = material.diagnosis;
    match diagnosis.verdict {
        Verdict::EffectFound => {
            let names: Vec<String> = diagnosis
                .effects
                .iter()
                .map(|e| title(material, e))
                .collect();
            format!("Missing: {}.", names.join(", and "))
        }
        Verdict::NoMissingEffect => "Nothing is missing.".into(),
        Verdict::UnknownEffect if material.selection.stopped => {
            "Not decided: the search was stopped.".into()
        }
        Verdict::UnknownEffect => match material.selection.tried_by_hand(material.problem) {
            Some(tried) => format!("Not explained by what was tried: {tried}."),
            None => "Something outside the catalogue is missing.".into(),
        },
    }
}

fn title(material: &Material, effect: &FoundEffect) -> String {
    let card = material
        .problem
        .catalogue
        .iter()
        .find(|c| c.id == effect.id);
    let ties = if effect.confounded_with.is_empty() {
        String::new()
    } else {
        format!(" or {}", effect.confounded_with.join(" or "))
    };
    match card {
        Some(card) if !card.title.is_empty() => format!("{}{ties} ({})", effect.id, card.title),
        _ => format!("{}{ties}", effect.id),
    }
}

/// Percent with three digits.
pub fn percent(value: f64) -> String {
    if value.is_finite() {
        format!("{} %", number(100.0 * value, 3))
    } else {
        "unknown".into()
    }
}

fn fall(material: &Material) -> String {
    let ladder = &material.diagnosis.error_ladder;
    let (Some(first), Some(last)) = (ladder.first(), ladder.last()) else {
        return String::new();
    };
    let before = if ladder.len() > 2 { &ladder[1] } else { first };
    let probability = material
        .diagnosis
        .verdict_probability
        .map_or(String::new(), |p| {
            format!("Probability {} among all that was compared. ", likely(p))
        });
    format!(
        "{probability}Error on what was kept out of the fit: {} ({}) → {} ({}); sensor noise alone makes {}. Half of these predictions end within {} times the noise.",
        percent(before.holdout_nrmse),
        before.step,
        percent(last.holdout_nrmse),
        last.step,
        percent(super::ladder::floor(material.problem)),
        number(last.holdout_over_noise, 3)
    )
}

/// What was found and how sure it is.
pub fn words(page: Page, material: &Material) -> Page {
    let diagnosis = material.diagnosis;
    let page = match diagnosis.verdict {
        Verdict::EffectFound if material.selection.by_break_aways => {
            page.paragraph(&diagnosis.summary)
        }
        Verdict::EffectFound => diagnosis.effects.iter().fold(page, |page, effect| {
            page.paragraph(&found(
                effect,
                &others(material.problem, material.selection),
            ))
        }),
        _ => page.paragraph(&diagnosis.summary),
    };
    let page = next(page, diagnosis);
    if diagnosis.remarks.is_empty() {
        page
    } else {
        page.subsection("What these data leave open, and why")
            .list(&diagnosis.remarks)
    }
}

/// A probability in percent; what is nearly sure or next to nothing is not written as if it were quite so.
pub fn likely(probability: f64) -> String {
    match 100.0 * probability {
        p if p > 99.95 => "> 99.9 %".to_owned(),
        p if p < 0.05 => "< 0.1 %".to_owned(),
        p => format!("{p:.1} %"),
    }
}

fn found(effect: &FoundEffect, others: &str) -> String {
    let values: Vec<String> = effect
        .parameters
        .iter()
        .map(|(name, estimate)| format!("{name} {}", with_interval(estimate)))
        .collect();
    let evidence = &effect.evidence;
    let sure = if evidence.gain > 3.0 * evidence.threshold {
        "far more than chance could give"
    } else if evidence.gain > evidence.threshold {
        "more than chance could give"
    } else {
        "no more than chance could give"
    };
    let ties = if effect.confounded_with.is_empty() {
        String::new()
    } else {
        format!(
            "These data can't distinguish it from {}. ",
            effect.confounded_with.join(", ")
        )
    };
    format!(
        "{}: {} (± is half the 95 % interval). It raises the logarithm of the evidence by {} where {} make up for its prior odds: {sure}. {ties}{others} What remains on the runs fitted is {} times the sensor noise (1 is the floor).",
        effect.id,
        if values.is_empty() {
            "its values differ from run to run".to_owned()
        } else {
            values.join(", ")
        },
        number(evidence.gain, 3),
        number(evidence.threshold, 3),
        number(evidence.floor_ratio, 3)
    )
}

/// `value ± half width of the 95 % interval unit`.
pub fn with_interval(estimate: &Estimate) -> String {
    let unit = if estimate.unit == "1" {
        String::new()
    } else {
        format!(" {}", estimate.unit)
    };
    let bound = if estimate.at_bound {
        " (on its bound: not to be trusted)"
    } else {
        ""
    };
    if let Some(half) = estimate.half_width() {
        format!(
            "{} ± {}{unit}{bound}",
            to_digit_of(estimate.value, half),
            number(half, 2)
        )
    } else {
        format!("{}{unit}{bound}", number(estimate.value, 4))
    }
}

/// A value with as many digits as its interval allows.
fn to_digit_of(value: f64, half: f64) -> String {
    let digits = ((value.abs().max(1e-300) / half).log10().floor() as i32 + 2).clamp(1, 9);
    number(value, digits as usize)
}

fn next(page: Page, diagnosis: &Diagnosis) -> Page {
    match &diagnosis.next_measurement {
        None => page,
        Some(next) => page.paragraph(&format!(
            "Next measurement: belt velocity {} m/s, normal force {} N. There {} can be distinguished: fitted to such a run too, those that are \
             wrong should fall behind by {} in score or more, where a tie is {} or less.",
            number(next.belt_velocity_m_per_s, 3),
            number(next.normal_force_n, 3),
            next.separates.join(" and "),
            number(next.expected_gain, 2),
            TIE
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_shown_to_the_digit_of_their_interval() {
        let estimate = |value, std| Estimate {
            value,
            std,
            unit: "m".into(),
            at_bound: false,
        };
        assert_eq!(
            with_interval(&estimate(0.123_456, 0.001)),
            "0.123 ± 0.002 m"
        );
        assert_eq!(with_interval(&estimate(2.5, f64::NAN)), "2.5 m");
    }
}

//! `stickslip blind-test`: diagnoses every campaign of a folder whose answers are known, and counts.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;
use serde_json::Value;

use super::diagnose::{Search, diagnose};
use super::given_campaign::{self, Forced};
use super::progress::Progress;
use crate::diagnose::result::diagnosis::{Diagnosis, Verdict};
use crate::error::Error;
use crate::file_kind::{Wanted, explain};
use crate::metric::half_width;
use crate::output::{make_folder, print, print_line, write_file};
use crate::provenance::Provenance;
use crate::watch::Watch as _;

/// Options of `blind-test`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder with numbered campaigns and a truth.json
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// FMU to diagnose [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Folder for blind-test.json and the diagnosis of each campaign
    #[arg(short, long, value_name = "DIR", default_value = "blind-test")]
    output: PathBuf,
    /// Only these campaigns, by name
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    only: Vec<String>,
    #[command(flatten)]
    forced: Forced,
}

/// One campaign's result.
#[derive(Debug, Clone, Serialize)]
pub struct BlindCase {
    /// Name of the campaign.
    pub campaign: String,
    /// Hidden effects.
    pub hidden: Vec<String>,
    /// Effects named.
    pub named: Vec<String>,
    /// Verdict.
    pub verdict: Verdict,
    /// Posterior probability of the verdict.
    pub probability: f64,
    /// Whether the answer is right.
    pub right: bool,
    /// Held-out error of the calibrated model and of the last rung.
    pub holdout_nrmse: [f64; 2],
    /// Held-out error of the last rung over the noise.
    pub over_noise: f64,
    /// Relative error of each parameter of the effects named rightly, and the same in standard deviations.
    pub parameter_errors: BTreeMap<String, [f64; 2]>,
    /// Wall time in s.
    pub seconds: f64,
    /// Where it comes from; the list itself, an array, has no place for that.
    pub provenance: Provenance,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let truth_file = arguments.folder.join("truth.json");
    let text = std::fs::read_to_string(&truth_file)
        .map_err(Error::read(&truth_file))
        .map_err(|error| explain(error, &arguments.folder, Wanted::BlindTest))?;
    let truth: Vec<Value> = serde_json::from_str(&text).map_err(|e| Error::Truth {
        path: truth_file.clone(),
        problem: e.to_string(),
    })?;
    make_folder(&arguments.output)?;
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let progress = Progress::new(Progress::STEPS);
    let mut cases = Vec::new();
    for answer in &truth {
        let name = answer["campaign"].as_str().unwrap_or_default().to_owned();
        if progress.stop() {
            break;
        }
        if !arguments.only.is_empty() && !arguments.only.contains(&name) {
            continue;
        }
        let folder = arguments.output.join(&name);
        make_folder(&folder)?;
        let start = Instant::now();
        let campaign = given_campaign::load(&arguments.folder.join(&name), arguments.forced)?;
        let diagnosis = diagnose(&fmu, &campaign, &Search::default(), &folder, &progress)?;
        let provenance = Provenance::of_campaign(&campaign, fmu.path())?;
        let case = score(
            &name,
            answer,
            &diagnosis,
            (start.elapsed().as_secs_f64(), provenance),
        );
        progress.suspend(|| print_line(line(&case)))?;
        cases.push(case);
        write_file(
            &arguments.output.join("blind-test.json"),
            serde_json::to_string_pretty(&cases)
                .expect("plain data")
                .as_bytes(),
        )?;
    }
    progress.finish();
    print(&summary(&cases))?;
    let details = arguments.output.join("blind-test.json");
    print_line(format_args!("Details: {}", details.display()))
}

fn strings(value: &Value) -> Vec<String> {
    value
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|v| v.as_str().map(str::to_owned))
        .collect()
}

fn score(
    name: &str,
    answer: &Value,
    diagnosis: &Diagnosis,
    (seconds, provenance): (f64, Provenance),
) -> BlindCase {
    let hidden = strings(&answer["effects"]);
    let named: Vec<String> = diagnosis.effects.iter().map(|e| e.id.clone()).collect();
    let outside = hidden.iter().any(|h| h.starts_with("outside:"));
    let right = if hidden.is_empty() {
        diagnosis.verdict == Verdict::NoMissingEffect
    } else if outside {
        diagnosis.verdict == Verdict::UnknownEffect
    } else {
        named.len() == hidden.len() && hidden.iter().all(|h| named.contains(h))
    };
    let mut parameter_errors = BTreeMap::new();
    for effect in diagnosis.effects.iter().filter(|e| hidden.contains(&e.id)) {
        for (parameter, estimate) in &effect.parameters {
            if let Some(true_value) = answer["parameters"][&effect.id][parameter]
                .as_f64()
                .filter(|v| *v != 0.0)
            {
                let difference = estimate.value - true_value;
                parameter_errors.insert(
                    format!("{}.{parameter}", effect.id),
                    [difference / true_value, difference / estimate.std],
                );
            }
        }
    }
    let ladder = &diagnosis.error_ladder;
    let last = ladder.last().expect("the ladder has its first rung");
    BlindCase {
        campaign: name.to_owned(),
        hidden,
        named,
        verdict: diagnosis.verdict,
        probability: diagnosis.verdict_probability.unwrap_or(f64::NAN),
        right,
        holdout_nrmse: [
            ladder[1.min(ladder.len() - 1)].holdout_nrmse,
            last.holdout_nrmse,
        ],
        over_noise: last.holdout_over_noise,
        parameter_errors,
        seconds,
        provenance,
    }
}

fn line(case: &BlindCase) -> String {
    let list = |names: &[String]| {
        if names.is_empty() {
            "none".to_owned()
        } else {
            names.join(" + ")
        }
    };
    let answer = match case.verdict {
        Verdict::EffectFound => list(&case.named),
        Verdict::NoMissingEffect => "none".into(),
        Verdict::UnknownEffect => "unknown".into(),
    };
    let errors: Vec<String> = case
        .parameter_errors
        .iter()
        .map(|(n, e)| {
            format!(
                "{} {:+.1} % ({:+.1} s)",
                n.rsplit('.').next().unwrap_or(n),
                100.0 * e[0],
                e[1]
            )
        })
        .collect();
    format!(
        "{} {} {} -> {answer} ({:.0} %); held out {:.3} % -> {:.3} % ({:.2} x noise); {}; {:.0} s",
        case.campaign,
        if case.right { "ok   " } else { "WRONG" },
        list(&case.hidden),
        100.0 * case.probability,
        100.0 * case.holdout_nrmse[0],
        100.0 * case.holdout_nrmse[1],
        case.over_noise,
        errors.join(", "),
        case.seconds
    )
}

/// Classes of probability in which verdicts are counted, the last with 1 in it.
const RELIABILITY: [(f64, f64); 3] = [(0.0, 0.5), (0.5, 0.9), (0.9, 1.1)];

fn summary(cases: &[BlindCase]) -> String {
    let mut groups: BTreeMap<&str, Vec<&BlindCase>> = BTreeMap::new();
    for case in cases {
        let kind = match case.hidden.len() {
            0 => "nothing hidden: nothing claimed",
            1 if case.hidden[0].starts_with("outside:") => {
                "outside the catalogue: reported as unknown"
            }
            1 => "one hidden effect: named",
            _ => "two hidden effects: both named",
        };
        groups.entry(kind).or_default().push(case);
    }
    let mut out = String::new();
    for (kind, members) in groups {
        let right = members.iter().filter(|c| c.right).count();
        out += &format!(
            "{kind}: {right} of {} ({:.0} %)\n",
            members.len(),
            100.0 * right as f64 / members.len() as f64
        );
    }
    for (low, high) in RELIABILITY {
        let within = |c: &&BlindCase| c.probability >= low && c.probability < high;
        let members: Vec<&BlindCase> = cases.iter().filter(within).collect();
        if !members.is_empty() {
            let right = members.iter().filter(|c| c.right).count();
            out += &format!(
                "verdicts given with {:.0} % to {:.0} %: {right} of {} right\n",
                100.0 * low,
                100.0 * high.min(1.0),
                members.len()
            );
        }
    }
    let errors: Vec<[f64; 2]> = cases
        .iter()
        .filter(|c| c.right)
        .flat_map(|c| c.parameter_errors.values().copied())
        .collect();
    if !errors.is_empty() {
        let close = errors.iter().filter(|e| e[0].abs() < 0.1).count();
        let inside = errors
            .iter()
            .filter(|e| e[1].abs() < half_width(1.0))
            .count();
        out += &format!(
            "parameters within 10 %: {close} of {}; inside the stated 95 % interval: {inside} of {}\n",
            errors.len(),
            errors.len()
        );
    }
    out
}

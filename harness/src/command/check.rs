//! `stickslip check`: the quality of a campaign's data, as a page of text.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::data_quality::of_further;
use super::given_campaign::{questionable, tell_how};
use crate::check::{Finding, Quality, RunQuality, Severity, check};
use crate::error::Error;
use crate::measurement::Campaign;
use crate::output::{print, print_line};
use crate::provenance::Provenance;

/// Options of `check`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder with campaign.toml and the CSV files, or the path of campaign.toml
    #[arg(value_name = "CAMPAIGN")]
    campaign: PathBuf,
    /// Print the page as JSON
    #[arg(long)]
    json: bool,
}

/// What was looked at and found.
#[derive(Debug)]
pub struct Checked {
    /// The page as JSON.
    pub json: String,
    /// The page.
    pub text: String,
    campaign: Campaign,
    /// The error of data that can't be meant.
    questionable: Option<Error>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let found = perform(arguments)?;
    if arguments.json {
        print_line(&found.json)?;
    } else {
        found.campaign.runs.iter().for_each(tell_how);
        print(&found.text)?;
    }
    found.questionable.map_or(Ok(()), Err)
}

/// Looks at the data; what can't be meant is among the findings and no error.
///
/// # Errors
/// A campaign that can't be read.
pub fn perform(arguments: &Arguments) -> Result<Checked, Error> {
    let campaign = Campaign::load(&arguments.campaign)?;
    let quality = check(&campaign);
    let provenance = Provenance::of_campaign(&campaign, None)?;
    Ok(Checked {
        json: provenance.json(&quality),
        text: page(&quality),
        questionable: questionable(&quality, &arguments.campaign),
        campaign,
    })
}

/// The page.
fn page(quality: &Quality) -> String {
    let runs = quality.runs.len();
    let mut out = format!("Campaign '{}', {runs} runs\n\n", quality.campaign);
    let wide = quality.runs.iter().map(|run| run.name.len()).max();
    let wide = wide.unwrap_or(0).max(3);
    let _ = writeln!(
        out,
        "{:<wide$} {:>8} {:>9} {:>9} {:>9} {:>10} {:>10} {:>6} {:>9}",
        "run", "samples", "rate", "range", "noise", "belt", "in stick", "stick", "friction"
    );
    let _ = writeln!(
        out,
        "{:<wide$} {:>8} {:>9} {:>9} {:>9} {:>10} {:>10} {:>6} {:>9}",
        "",
        "",
        "Hz",
        "m",
        quality.measurand.unit(),
        "m/s",
        "m/s",
        "%",
        "mean"
    );
    for run in &quality.runs {
        out += &row(run, wide);
    }
    out.push('\n');
    for line in quality.runs.iter().flat_map(of_further) {
        out += &format!("{line}\n");
    }
    for finding in &quality.findings {
        out += &paragraph(finding);
    }
    if quality.findings.is_empty() {
        out += "Nothing contradicts what campaign.toml states.\n";
    }
    let elsewhere = quality.elsewhere();
    if !elsewhere.is_empty() {
        out += &format!("{}\n", elsewhere.trim_end());
    }
    out
}

fn row(run: &RunQuality, wide: usize) -> String {
    let or_dash = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.3}"));
    let stick = run
        .stick_speed_m_per_s
        .map_or("-".to_owned(), |v| format!("{v:.4}"));
    format!(
        "{:<wide$} {:>8} {:>9.0} {:>9.2e} {:>9.1e} {:>10} {:>10} {:>6.0} {:>9}\n",
        run.name,
        run.samples,
        run.sample_rate_hz,
        run.range_m,
        run.noise_std.value(),
        run.belt_velocity_m_per_s,
        stick,
        100.0 * run.stick_share,
        or_dash(run.mean_friction),
    )
}

fn paragraph(finding: &Finding) -> String {
    let severity = match finding.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    format!(
        "{severity} ({}) in {}\n  measured: {}\n  stated:   {}\n  remedy:   {}\n",
        finding.id,
        finding.runs.join(", "),
        finding.measured,
        finding.stated,
        finding.remedy
    )
}

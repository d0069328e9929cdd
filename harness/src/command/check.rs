//! `stickslip check`: the quality of a campaign's data, as a page of text.

use std::path::PathBuf;

use clap::Args;

use super::data_quality::of_further;
use super::given_campaign::questionable;
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
    /// The error of data that can't be meant.
    questionable: Option<Error>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let found = perform(arguments)?;
    if arguments.json {
        print_line(&found.json)?;
    } else {
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
    })
}

/// The page.
fn page(quality: &Quality) -> String {
    let runs = quality.runs.len();
    let mut out = format!("Campaign '{}', {runs} runs\n\n", quality.campaign);
    let wide = quality.runs.iter().map(|run| run.name.len()).max();
    let wide = wide.unwrap_or(0).max(3);
    let columns = columns(quality);
    let line = |first: &str, cells: &dyn Fn(&Column) -> String| {
        let rest = columns.iter().map(|c| format!(" {:>1$}", cells(c), c.wide));
        format!("{first:<wide$}{}\n", rest.collect::<String>())
    };
    out += &line("run", &|column| column.title.to_owned());
    out += &line("", &|column| column.unit.to_owned());
    for run in &quality.runs {
        out += &line(&run.name, &|column| (column.cell)(run));
    }
    out.push('\n');
    for run in &quality.runs {
        if let Some(understood) = &run.understood {
            out += &format!("{}: {understood}\n", run.name);
        }
    }
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

/// A column of the table of runs.
struct Column {
    title: &'static str,
    unit: &'static str,
    wide: usize,
    cell: fn(&RunQuality) -> String,
}

/// The columns: those on contact where there is any.
fn columns(quality: &Quality) -> Vec<Column> {
    let column = |title, unit, wide, cell| Column {
        title,
        unit,
        wide,
        cell,
    };
    let noise = quality.measurand.unit();
    let mut columns = vec![
        column("samples", "", 8, |run| run.samples.to_string()),
        column("rate", "Hz", 9, |run| format!("{:.0}", run.sample_rate_hz)),
        column("range", "m", 9, |run| format!("{:.2e}", run.range_m)),
        column("noise", noise, 9, |run| {
            format!("{:.1e}", run.noise_std.value())
        }),
    ];
    if quality.is_pressed {
        columns.extend([
            column("belt", "m/s", 10, |run| {
                run.belt_velocity_m_per_s.to_string()
            }),
            column("in stick", "m/s", 10, |run| {
                or_dash(run.stick_speed_m_per_s, 4)
            }),
            column("stick", "%", 6, |run| {
                let seen = run.stick_speed_m_per_s;
                or_dash(seen.map(|_| 100.0 * run.stick_share), 0)
            }),
            column("friction", "mean", 9, |run| or_dash(run.mean_friction, 3)),
        ]);
    }
    columns
}

/// A value, or a dash for what these data do not show.
fn or_dash(value: Option<f64>, places: usize) -> String {
    value.map_or("-".to_owned(), |v| format!("{v:.places$}"))
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

//! A line of sweep.csv and back.

use beam_physics::sweep::{Motion, Status};

use super::plan::{Plan, Row};

/// The columns after the parameters' values and the start.
const RESULTS: [&str; 6] = [
    "period",
    "main_frequency_hz",
    "amplitude_m",
    "stick_fraction",
    "lyapunov_per_s",
    "status",
];

/// What a row says.
#[derive(Debug, Clone, PartialEq)]
pub struct Result {
    /// Section points after which the motion repeats, 0 where it does not; none without motion.
    pub period: Option<usize>,
    /// Frequency of the strongest spectral line, Hz.
    pub main_frequency: Option<f64>,
    /// Half the distance from the lowest trough to the highest peak, m.
    pub amplitude: Option<f64>,
    /// Share of time in stick.
    pub stick_fraction: Option<f64>,
    /// Largest Lyapunov exponent, 1/s.
    pub lyapunov: Option<f64>,
    /// `ok`, `settling`, `unresolved`, `dies_out`, `rest`, `no_section` or `failed: ` and the reason.
    pub status: String,
}

impl Result {
    /// Of a motion found.
    pub fn of(motion: &Motion) -> Result {
        let moves = motion.status != Status::Rest;
        Result {
            period: motion.period,
            main_frequency: motion.main_frequency,
            amplitude: Some(motion.amplitude),
            stick_fraction: Some(motion.stick_fraction),
            lyapunov: motion.lyapunov.filter(|_| moves),
            status: motion.status.word().into(),
        }
    }

    /// Of a point that could not be computed.
    pub fn failed(reason: &str) -> Result {
        Result {
            period: None,
            main_frequency: None,
            amplitude: None,
            stick_fraction: None,
            lyapunov: None,
            status: format!("failed: {reason}"),
        }
    }

    /// Whether the point could not be computed.
    pub fn is_failed(&self) -> bool {
        self.status.starts_with("failed")
    }

    /// Whether the tip vibrates by itself.
    pub fn vibrates(&self) -> bool {
        let moving = ["ok", "settling", "unresolved", "no_section"];
        moving.contains(&self.status.as_str())
    }

    /// The result's fields as they stand in the file.
    fn fields(&self) -> Vec<String> {
        let number = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
        vec![
            self.period.map_or(String::new(), |p| p.to_string()),
            number(self.main_frequency),
            number(self.amplitude),
            number(self.stick_fraction),
            number(self.lyapunov),
            self.status.clone(),
        ]
    }

    /// Reads the fields after the key.
    fn parse(fields: &[&str]) -> Option<Result> {
        let number = |text: &str| match text {
            "" => Some(None),
            text => text.parse::<f64>().ok().map(Some),
        };
        Some(Result {
            period: match fields[0] {
                "" => None,
                text => Some(text.parse().ok()?),
            },
            main_frequency: number(fields[1])?,
            amplitude: number(fields[2])?,
            stick_fraction: number(fields[3])?,
            lyapunov: number(fields[4])?,
            status: fields[5].to_owned(),
        })
    }
}

/// The header of sweep.csv.
pub fn header(plan: &Plan) -> String {
    let names: Vec<&str> = plan.axes.iter().map(|a| a.name.as_str()).collect();
    format!("{},start,{}\n", names.join(","), RESULTS.join(","))
}

/// The header of section.csv.
pub fn section_header(plan: &Plan) -> String {
    let names: Vec<&str> = plan.axes.iter().map(|a| a.name.as_str()).collect();
    format!(
        "{},start,point,time_s,displacement_m,velocity_m_per_s\n",
        names.join(",")
    )
}

/// A whole line, with its end.
pub fn line(row: &Row, result: &Result) -> String {
    let mut fields: Vec<String> = row.at.iter().map(f64::to_string).collect();
    fields.push(row.start.clone());
    fields.extend(result.fields());
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer
        .write_record(&fields)
        .expect("a list in memory takes every line");
    let bytes = writer.into_inner().expect("a list in memory");
    String::from_utf8(bytes).expect("made of texts")
}

/// The lines of section.csv that belong to a row.
pub fn section_lines(row: &Row, motion: &Motion) -> String {
    use std::fmt::Write as _;
    let key = row.key();
    let mut text = String::new();
    for (k, point) in motion.section.iter().enumerate() {
        let _ = writeln!(
            text,
            "{key},{k},{},{},{}",
            point.time, point.displacement, point.velocity
        );
    }
    text
}

/// Key and result of a line; `None` for a line cut off.
pub fn parse(plan: &Plan, line: &str) -> Option<(String, Result)> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .from_reader(line.as_bytes());
    let record = reader.records().next()?.ok()?;
    let keys = plan.axes.len() + 1;
    let fields: Vec<&str> = record.iter().collect();
    if fields.len() != keys + RESULTS.len() {
        return None;
    }
    Some((fields[..keys].join(","), Result::parse(&fields[keys..])?))
}

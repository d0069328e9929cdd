//! `stickslip observe`: friction force and friction characteristic from one measured run.

mod analysis;
mod characteristic;
mod files;
mod friction;
mod observation;
mod page;
mod pictures;
mod remarks;
mod terminal;

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, ValueEnum};

pub use observation::Observation;

use crate::command::given_campaign;
use crate::command::operating_options::{OperatingOptions, Said};
use crate::error::Error;
use crate::measurement::{BeamKnowledge, Campaign, Measurand, Run, SingleRun};
use crate::observer::{PoleRule, Structure};
use crate::output::{make_folder, print, print_line, write_file};
use crate::provenance::Provenance;

/// Ways to estimate the force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// The paper's observer with placed poles: causal, late, smears jumps
    Pole,
    /// Kalman filter and smoother, random-walk force
    Kalman,
    /// Smoother that knows stick and slip; the sharpest
    StickSlip,
}

impl Method {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Method::Pole => "pole-placed observer",
            Method::Kalman => "Kalman smoother, random-walk force",
            Method::StickSlip => "stick/slip-aware smoother",
        }
    }
}

/// Options of `observe`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("knowledge").required(true))]
pub struct Arguments {
    /// CSV file with time and tip displacement, velocity or acceleration
    #[arg(value_name = "RUN.csv")]
    run: PathBuf,
    /// Campaign that lists this run: gives beam, belt velocity, normal force and columns
    #[arg(long, value_name = "DIR", group = "knowledge")]
    campaign: Option<PathBuf>,
    /// TOML file with [beam] (as in campaign.toml) for a run outside a campaign; with --belt-velocity and --normal-force
    #[arg(long, value_name = "FILE", group = "knowledge")]
    beam: Option<PathBuf>,
    #[command(flatten)]
    at: OperatingOptions,
    /// Name of the time column; with --beam [default: time_s]
    #[arg(long, value_name = "NAME", requires = "beam")]
    time_column: Option<String>,
    /// Name of the displacement column; with --beam [default: tip_displacement_m]
    #[arg(long, value_name = "NAME", requires = "beam")]
    displacement_column: Option<String>,
    /// How the force is estimated
    #[arg(long, value_enum, default_value = "stick-slip")]
    method: Method,
    /// Speed of the observer's poles in Hz, for --method pole [default: from the data]
    #[arg(long, value_name = "HZ")]
    pole_frequency: Option<f64>,
    /// The observer's poles one by one in 1/s, for --method pole: 2 per mode and 1, as "-900 -400+700i -400-700i ..."
    #[arg(
        long,
        value_name = "POLES",
        allow_hyphen_values = true,
        conflicts_with = "pole_frequency"
    )]
    poles: Option<String>,
    /// Estimate the natural frequencies too, within this share of those given (0.01 is 1 %)
    #[arg(long, value_name = "SHARE")]
    estimate_frequencies: Option<f64>,
    /// Sensor offset to subtract, in m (m/s of a velocity; an acceleration shows its own in stick)
    #[arg(long, value_name = "M", default_value_t = 0.0)]
    offset: f64,
    /// Friction coefficient in slip (median), which sets the level of the force where a velocity or an acceleration was measured
    #[arg(long, value_name = "MU")]
    friction_coefficient: Option<f64>,
    /// Folder for force.csv, friction.csv, friction_table.set and observer.html
    #[arg(short, long, value_name = "DIR", default_value = "observer")]
    output: PathBuf,
    /// Print the results as JSON instead of the summary
    #[arg(long)]
    json: bool,
}

/// What the observer finds.
#[derive(Debug)]
pub struct Observed {
    /// The whole.
    pub observation: Observation,
    /// The results without the columns.
    pub json: String,
    /// The summary.
    pub text: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let found = perform(arguments)?;
    if arguments.json {
        print_line(&found.json)
    } else {
        print(&found.text)?;
        let report = arguments.output.join("observer.html");
        print_line(format_args!("Report: {}", report.display()))
    }
}

/// Observes and writes the files.
///
/// # Errors
/// Options or a run that can't be used, a beam of which too little is known, a folder that can't be
/// written.
pub fn perform(arguments: &Arguments) -> Result<Observed, Error> {
    let said = arguments.at.read()?;
    let campaign = load(arguments, &said)?;
    let run = find(&campaign, arguments)?;
    given_campaign::tell_how(run);
    agree(run, &said)?;
    make_folder(&arguments.output)?;
    let mut remarks = Vec::new();
    let source = arguments.campaign.as_ref().or(arguments.beam.as_ref());
    let beam_file = source.map_or(Path::new(""), PathBuf::as_path);
    let structure = structure(&campaign.beam, beam_file, &mut remarks)?;
    require_method(arguments, run, &structure)?;
    let rule = pole_rule(arguments)?;
    let observation =
        analysis::observe(run, structure, arguments, &rule, remarks).map_err(|source| {
            Error::Observe {
                path: run.file.clone(),
                source,
            }
        })?;
    let toml = match (&arguments.campaign, &arguments.beam) {
        (Some(campaign), _) if campaign.is_dir() => campaign.join("campaign.toml"),
        (campaign, beam) => campaign
            .as_ref()
            .or(beam.as_ref())
            .cloned()
            .unwrap_or_default(),
    };
    let mut provenance = Provenance::of(&[&run.file, &toml])?;
    provenance.inputs[0].understood.clone_from(&run.understood);
    let into = |name: &str| arguments.output.join(name);
    write_file(&into("force.csv"), files::force(&observation).as_bytes())?;
    write_file(
        &into("friction.csv"),
        files::friction(&observation).as_bytes(),
    )?;
    if let Some(table) = files::table(&observation) {
        write_file(&into("friction_table.set"), table.as_bytes())?;
    }
    let page = page::html(&observation, &provenance);
    write_file(&into("observer.html"), page.as_bytes())?;
    Ok(Observed {
        json: files::json(&observation, &provenance),
        text: terminal::summary(&observation),
        observation,
    })
}

/// What is known of the run: from `--campaign`, or from `--beam` with belt velocity and normal force.
fn load(arguments: &Arguments, said: &Said) -> Result<Campaign, Error> {
    if let Some((name, value)) = said.settings.first() {
        return Err(Error::Option {
            option: "--set",
            value: format!("{name}={value}"),
            rule: "can't be set here: observe takes belt_velocity and normal_force, and the beam from --campaign or --beam".into(),
        });
    }
    let Some(beam) = &arguments.beam else {
        return Campaign::load(arguments.campaign.as_deref().unwrap_or(Path::new(".")));
    };
    let missing = |option: &'static str| Error::Usage {
        problem: format!("{option} is missing: --beam says nothing of the operating point"),
    };
    let single = SingleRun {
        file: arguments.run.clone(),
        belt_velocity: said
            .belt_velocity
            .ok_or_else(|| missing("--belt-velocity"))?,
        normal_force: said.normal_force.ok_or_else(|| missing("--normal-force"))?,
        time_column: arguments.time_column.clone(),
        displacement_column: arguments.displacement_column.clone(),
    };
    Campaign::of_single_run(&single, beam)
}

/// Refuses an operating point on the command line that is not the one the campaign gives for the run.
fn agree(run: &Run, said: &Said) -> Result<(), Error> {
    let pairs = [
        (
            "--belt-velocity",
            said.belt_velocity,
            run.belt_velocity,
            "m/s",
        ),
        ("--normal-force", said.normal_force, run.normal_force, "N"),
    ];
    for (option, said, given, unit) in pairs {
        if let Some(said) = said.filter(|said| *said != given) {
            return Err(Error::Option {
                option,
                value: said.to_string(),
                rule: format!(
                    "{unit} contradicts the campaign, which gives {given} {unit} for {}; leave it out, or mend campaign.toml",
                    run.name
                ),
            });
        }
    }
    Ok(())
}

/// Refuses a method or a level that the run can't have, and asks for the level that it lacks.
fn require_method(arguments: &Arguments, run: &Run, structure: &Structure) -> Result<(), Error> {
    if arguments.method == Method::Pole && !analysis::poles_apply(run, structure) {
        return Err(Error::Option {
            option: "--method",
            value: "pole".into(),
            rule: "is made for a displacement of a structure on springs that nothing but friction moves; take stick-slip or kalman".into(),
        });
    }
    let leaves_open = run.measurand != Measurand::Displacement && !structure.is_free();
    match arguments.friction_coefficient {
        None if leaves_open => Err(Error::Usage {
            problem: format!(
                "--friction-coefficient is missing: run '{}' holds a tip {} in {}, which does not show the level of the friction force; \
                 state the coefficient in slip, for example --friction-coefficient 0.3",
                run.name,
                run.measurand.name(),
                run.measurand.unit()
            ),
        }),
        Some(value) if !(value >= 0.0 && value.is_finite()) => Err(Error::Option {
            option: "--friction-coefficient",
            value: value.to_string(),
            rule: "must be 0 or more".into(),
        }),
        Some(value) if !leaves_open => Err(Error::Option {
            option: "--friction-coefficient",
            value: value.to_string(),
            rule: format!(
                "is for velocities and accelerations: run '{}' shows the level of the friction force itself; leave the option out",
                run.name
            ),
        }),
        _ => Ok(()),
    }
}

/// The rule for the poles that the options say.
fn pole_rule(arguments: &Arguments) -> Result<PoleRule, Error> {
    let Some(text) = &arguments.poles else {
        return Ok(match arguments.pole_frequency {
            Some(frequency_hz) => PoleRule::AtZeros { frequency_hz },
            None => PoleRule::FromData,
        });
    };
    let parse = |pole: &str| pole.parse().ok();
    let poles = text.split([' ', ',']).filter(|p| !p.is_empty()).map(parse);
    match poles.collect::<Option<Vec<_>>>() {
        Some(poles) => Ok(PoleRule::Given(poles)),
        None => Err(Error::Option {
            option: "--poles",
            value: text.clone(),
            rule: "is not a list of complex numbers in 1/s; for example --poles \"-900 -400+700i -400-700i\"".into(),
        }),
    }
}

/// The campaign's run with the file asked for.
fn find<'a>(campaign: &'a Campaign, arguments: &Arguments) -> Result<&'a Run, Error> {
    let asked = arguments
        .run
        .canonicalize()
        .map_err(Error::read(&arguments.run))?;
    let same = |run: &&Run| run.file.canonicalize().is_ok_and(|file| file == asked);
    campaign
        .runs
        .iter()
        .find(same)
        .ok_or_else(|| Error::RunNotInCampaign {
            campaign: campaign.folder.clone(),
            run: arguments.run.clone(),
            known: campaign
                .runs
                .iter()
                .map(|r| r.file.display().to_string())
                .collect(),
        })
}

/// Damping ratio taken where none is given: it hardly matters (twice as much adds 2 % to the error of the force).
const USUAL_DAMPING: f64 = 1e-3;

fn structure(
    beam: &BeamKnowledge,
    file: &Path,
    remarks: &mut Vec<String>,
) -> Result<Structure, Error> {
    let unknown = |key, purpose| Error::BeamUnknown {
        path: file.to_owned(),
        key,
        purpose,
    };
    let frequencies = &beam.natural_frequencies_hz;
    if frequencies.is_empty() {
        return Err(unknown(
            "natural_frequencies_hz",
            "know how the beam vibrates",
        ));
    }
    if beam.masses_kg.is_empty() {
        return Err(unknown("mass_kg", "turn motion into force"));
    }
    let damping = if beam.damping_ratios.is_empty() {
        remarks.push(format!(
            "No damping ratios given; {USUAL_DAMPING} taken for every mode."
        ));
        vec![USUAL_DAMPING; frequencies.len()]
    } else {
        beam.damping_ratios.clone()
    };
    let made = if beam.tip_values.is_empty() {
        let tips: Vec<f64> = (0..frequencies.len())
            .map(|j| if j % 2 == 0 { 2.0 } else { -2.0 })
            .collect();
        Structure::from_lists(frequencies, &damping, &beam.masses_kg, &tips)
    } else {
        Structure::from_lists(frequencies, &damping, &beam.masses_kg, &beam.tip_values)
    };
    let made = made
        .and_then(|structure| structure.with_damping_rates(&beam.damping_rates_per_s))
        .and_then(|structure| structure.with_sensor(&beam.sensor.ratios));
    made.map_err(|source| Error::Observe {
        path: file.to_owned(),
        source,
    })
}

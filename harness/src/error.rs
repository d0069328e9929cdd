//! The one error type of the harness. Every message says where, which value in which unit, and what to do.

use std::path::{Path, PathBuf};

use crate::exit::Exit;
use crate::wording::{at_line, of_channel, or_silent, quoted, suggestion, with_unit};

/// What a command can fail with; [`Error::exit_code`] groups these for scripts.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    // ---- files
    /// A file or folder could not be read.
    #[error("cannot read {}: {source}; check that it exists and may be read", path.display())]
    Read {
        /// What was to be read.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file or folder could not be written.
    #[error("cannot write {}: {source}; nothing was left half-written there, choose another place with -o", path.display())]
    Write {
        /// What was to be written.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Standard output could not be written: its disk is full, or its reader has gone.
    #[error("cannot write standard output: {source}; redirect it to a file with enough space")]
    Print {
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file or folder of another kind than was asked for.
    #[error("{}: {expected} is expected here, but this is {found}; {remedy}", path.display())]
    WrongKind {
        /// What was given.
        path: PathBuf,
        /// What was expected.
        expected: &'static str,
        /// What it is.
        found: &'static str,
        /// What to do.
        remedy: &'static str,
    },

    // ---- users' effects
    /// A user's effect that can't be used.
    #[error("{}{}: {problem}", path.display(), at_line(*line))]
    EffectFile {
        /// The effect's file.
        path: PathBuf,
        /// Line, counted from 1, where one is to blame.
        line: Option<usize>,
        /// What is wrong, and what to do.
        problem: String,
    },

    /// An FMU of another make, without what would explain it.
    #[error(
        "{}: no variable '{name}', and no {} beside it; that file names inputs, states, constants and effects of an FMU of another make (docs/other-fmus.md)",
        path.display(), side.display()
    )]
    NoSideFile {
        /// The FMU.
        path: PathBuf,
        /// The variable that it lacks.
        name: &'static str,
        /// Where the file is looked for.
        side: PathBuf,
    },

    // ---- packing
    /// A folder of binaries that can't be packed.
    #[error("{} {problem}; fill the folder with fmu-src/platforms.sh", path.display())]
    Binaries {
        /// The folder, or the library in it.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },

    // ---- repaired model
    /// The calibrated values do not fit the FMU that was diagnosed.
    #[error(
        "the repaired FMU can't be written: {problem}; diagnosis.json, model.toml and the .ssv are complete"
    )]
    StartValues {
        /// What does not fit.
        problem: String,
    },

    // ---- blind test
    /// truth.json can't be read.
    #[error("{}: {problem}; give a list of objects with campaign, effects and parameters", path.display())]
    Truth {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },

    // ---- observer
    /// The observer refuses a record.
    #[error("{run}: {source}")]
    Observer {
        /// Name of the run.
        run: String,
        /// What the observer says.
        source: crate::observer::ObserverError,
    },

    // ---- measurement campaign
    /// campaign.toml is not valid TOML, or has an unknown key or a value of the wrong type.
    #[error("{}:{line}: {problem}", path.display())]
    CampaignFile {
        /// The campaign file.
        path: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// What is wrong, and which keys or values exist.
        problem: String,
    },
    /// A number in campaign.toml that no rig can have.
    #[error("{}{}: {key} = {} is not possible; {rule}", path.display(), at_line(*line), with_unit(*value, unit))]
    CampaignValue {
        /// The campaign file.
        path: PathBuf,
        /// Line, counted from 1, where known.
        line: Option<usize>,
        /// The key, with its table.
        key: String,
        /// The value found.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// What is allowed.
        rule: &'static str,
    },
    /// Lists in `[beam]` that must have the same length have not.
    #[error("{}: [beam] {key} has {found} entries but natural_frequencies_hz has {expected}; give one per mode or leave the list out", path.display())]
    CampaignModes {
        /// The campaign file.
        path: PathBuf,
        /// The list that does not fit.
        key: String,
        /// Its length.
        found: usize,
        /// The number of natural frequencies.
        expected: usize,
    },
    /// A campaign without a run.
    #[error("{}: no [[run]] in this campaign; add one with file, belt_velocity_m_per_s and normal_force_n", path.display())]
    NoRuns {
        /// The campaign file.
        path: PathBuf,
    },
    /// Nearly all samples are missing.
    #[error("{}: {samples} samples over {span} s, but {interval} s from one to the next mostly: nearly all are missing; is one of the times wrong?", path.display())]
    MostlyMissing {
        /// The CSV file.
        path: PathBuf,
        /// Samples found.
        samples: usize,
        /// Last time less the first, s.
        span: f64,
        /// Usual interval, s.
        interval: f64,
    },
    /// A run that lasts longer than any.
    #[error("{}: a run of {span} s is not possible, {longest:e} s is the most; is the time in s? time_scale in campaign.toml turns other units into s", path.display())]
    RunTooLong {
        /// The CSV file.
        path: PathBuf,
        /// Last time less the first, s.
        span: f64,
        /// The most, s.
        longest: f64,
    },
    /// No run has stretches enough for predictions.
    #[error("{}: no run to {of} is long enough: {segments} stretch(es) without gaps or clipped samples are needed, {needed:.3} s in all; measure longer, some ten cycles of the motion in each run", campaign.display())]
    RunsTooShort {
        /// The campaign.
        campaign: PathBuf,
        /// What the runs are for.
        of: &'static str,
        /// Stretches needed in one run at least.
        segments: usize,
        /// What they take together, s.
        needed: f64,
    },
    /// Every run is held out.
    #[error("{}: every run has the role \"holdout\", so none is left to learn from; give one or more the role \"fit\"", campaign.display())]
    NothingToFit {
        /// The campaign.
        campaign: PathBuf,
    },
    /// A CSV file lacks a column.
    #[error("{}:{line}: no column '{column}'; the header has {}{}; name the right one with {key} in campaign.toml",
        path.display(), quoted(present), suggestion(nearest.as_slice()))]
    MissingColumn {
        /// The CSV file.
        path: PathBuf,
        /// Line of the header, counted from 1.
        line: u64,
        /// The column looked for.
        column: String,
        /// The key of campaign.toml that chooses this column.
        key: &'static str,
        /// The columns there are.
        present: Vec<String>,
        /// The one most like it.
        nearest: Vec<String>,
    },
    /// A CSV file's line is not a record of its table (wrong number of fields, a missing value of an input, ...).
    #[error("{}:{line}: {problem}", path.display())]
    CsvRecord {
        /// The CSV file.
        path: PathBuf,
        /// Line, counted from 1.
        line: u64,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A sample that is not a finite number.
    #[error("{}:{line}: '{value}' in column '{column}' is not a finite number; {remedy}", path.display())]
    NotANumber {
        /// The CSV file.
        path: PathBuf,
        /// Line, counted from 1.
        line: u64,
        /// The column.
        column: String,
        /// The text found.
        value: String,
        /// What to do.
        remedy: String,
    },
    /// A file without a row of numbers.
    #[error("{}:{line}: no row of numbers in this file, this line reads '{text}'; export the samples as plain numbers, columns separated by commas, semicolons, tabs or spaces", path.display())]
    NoTable {
        /// The file.
        path: PathBuf,
        /// Line of the first text below the header, counted from 1.
        line: u64,
        /// That text.
        text: String,
    },
    /// A column without a single sample.
    #[error("{}:{line}: column '{column}' has no number in any of its {rows} rows; name another column in campaign.toml, or export it again", path.display())]
    EmptyColumn {
        /// The file.
        path: PathBuf,
        /// Line of the header, counted from 1.
        line: u64,
        /// The column.
        column: String,
        /// Rows of the table.
        rows: usize,
    },
    /// More than one column that may be meant.
    #[error("{}:{line}: {} are all {quantity}, and one is needed; name it with {key} in campaign.toml, each name once", path.display(), quoted(found))]
    SeveralColumns {
        /// The file.
        path: PathBuf,
        /// Line of the header, counted from 1.
        line: u64,
        /// What they measure.
        quantity: &'static str,
        /// Their names.
        found: Vec<String>,
        /// The key of campaign.toml that chooses.
        key: &'static str,
    },
    /// A column in a unit of something else.
    #[error("{}:{line}: column '{column}' is in {problem}; name another with {key} in campaign.toml, or state {scale_key} if the unit is wrong", path.display())]
    ColumnQuantity {
        /// The file.
        path: PathBuf,
        /// Line of the header, counted from 1.
        line: u64,
        /// The column.
        column: String,
        /// Its unit, and what is needed.
        problem: String,
        /// The key of campaign.toml that chooses a column.
        key: &'static str,
        /// The key of campaign.toml for its factor.
        scale_key: &'static str,
    },
    /// Time repeats or runs backwards.
    #[error("{}:{line}: time {value} s does not come after {previous} s of the line before; sort the file by time and remove repeated lines", path.display())]
    TimeNotIncreasing {
        /// The CSV file.
        path: PathBuf,
        /// Line, counted from 1.
        line: u64,
        /// The time before, in s.
        previous: f64,
        /// The time found, in s.
        value: f64,
    },
    /// Too little data.
    #[error("{}: {samples} samples, at least {needed} are needed; is the file empty or cut off?", path.display())]
    TooFewSamples {
        /// The CSV file.
        path: PathBuf,
        /// Samples found.
        samples: usize,
        /// Samples needed.
        needed: usize,
    },

    /// A channel that stands still, or nearly so.
    #[error("{}: {usable} of {samples} samples can be used, at least {needed} are needed: the others are clipped or held, most of them at {value} {unit}; check the sensor, and which column is its, or leave this run out", path.display())]
    NothingMeasured {
        /// The CSV file.
        path: PathBuf,
        /// Samples that are neither clipped nor held.
        usable: usize,
        /// Samples found.
        samples: usize,
        /// The value of the longest stretch of equal samples, in `unit`.
        value: f64,
        /// SI unit of what was measured.
        unit: &'static str,
        /// Samples needed.
        needed: usize,
    },
    /// Runs of one campaign that hold different quantities.
    #[error("{}: run '{}' measures the tip's {} and run '{}' its {}; the runs of a campaign hold one quantity: make a campaign of each", campaign.display(), first.0, first.1, other.0, other.1)]
    MixedQuantities {
        /// The campaign's folder.
        campaign: PathBuf,
        /// The first run, and what it holds.
        first: (String, &'static str),
        /// One that differs, and what it holds.
        other: (String, &'static str),
    },
    /// A further sensor whose readings do not follow the motion that the first one measured.
    #[error("{}: in {runs} [[further_sensor]] '{sensor}' changes by {slope:.3} times what the first sensor's motion asks for (correlation {correlation:.2}); {remedy}", campaign.display())]
    FurtherSensorContradicts {
        /// The campaign's folder.
        campaign: PathBuf,
        /// In which runs.
        runs: String,
        /// The sensor.
        sensor: String,
        /// Slope of the readings over what the motion asks for, 1.
        slope: f64,
        /// Their correlation, 1.
        correlation: f64,
        /// What is likely wrong.
        remedy: String,
    },
    /// A further sensor whose readings can't be taken between its samples.
    #[error("{}: the readings of [[further_sensor]] '{sensor}' can't be taken at the times of the first sensor: their intervals scatter by {jitter:.2} % and have {gaps} gaps; give evenly sampled readings, or ones in the rows of the run's file without delay_s", path.display())]
    UnevenFurtherSensor {
        /// The file.
        path: PathBuf,
        /// The sensor.
        sensor: String,
        /// Scatter of the intervals, %.
        jitter: f64,
        /// Number of gaps.
        gaps: usize,
    },
    /// A column that two sensors are said to have written.
    #[error("{}:{line}: column '{column}' is that of [[further_sensor]] '{sensor}' and of another sensor; the same readings count once, so leave one of the two out or name its own column", path.display())]
    ColumnTwice {
        /// The run's file.
        path: PathBuf,
        /// Line of the header, counted from 1.
        line: u64,
        /// The column.
        column: String,
        /// The sensor that names it again.
        sensor: String,
    },
    /// A further sensor whose noise can't be found.
    #[error("{}: [[further_sensor]] '{sensor}' has {samples} readings in {rows} rows, and between its gaps too few stand side by side to estimate its noise; state noise_std in campaign.toml", path.display())]
    FurtherSensorNoise {
        /// The run's file.
        path: PathBuf,
        /// The sensor.
        sensor: String,
        /// Its readings.
        samples: usize,
        /// Rows of the run.
        rows: usize,
    },
    /// An accelerometer away from the tip.
    #[error("{}: run '{run}' holds an acceleration, and [sensor] states another place than the tip; accelerations are read by the rest of the tip in stick, which is not seen elsewhere: measure a displacement or a velocity there, or put the accelerometer at the tip and leave [sensor] out", campaign.display())]
    AccelerometerAway {
        /// The campaign's folder.
        campaign: PathBuf,
        /// The run.
        run: String,
    },
    /// A campaign in which nothing moves.
    #[error("{}: the {quantity} varies by {spread:.1e} {unit} (standard deviation) at most, in a run with a noise of {noise:.1e} {unit}: nothing moves that a model could be compared with; measure at least one run in which the tip vibrates", campaign.display())]
    NothingMoves {
        /// The campaign.
        campaign: PathBuf,
        /// What was measured.
        quantity: &'static str,
        /// Its unit.
        unit: &'static str,
        /// Largest standard deviation of a run, in that unit.
        spread: f64,
        /// That of its noise.
        noise: f64,
    },

    /// A column to analyse that is not there, or is not named where there are several.
    #[error("{}: {}; the header has {}{}; name one with --column", path.display(),
        wanted.as_ref().map_or("several columns".to_owned(), |w| format!("no column '{w}'")), quoted(present), suggestion(nearest))]
    ColumnChoice {
        /// The CSV file.
        path: PathBuf,
        /// The column asked for.
        wanted: Option<String>,
        /// The columns there are.
        present: Vec<String>,
        /// The ones most like it.
        nearest: Vec<String>,
    },
    /// Times that are not even, nor even with gaps.
    #[error("{}:{line}: this sample lies {share:.2} sample intervals off an even grid of {interval} s; resample the series at even times", path.display())]
    UnevenTimes {
        /// The CSV file.
        path: PathBuf,
        /// Line, counted from 1.
        line: u64,
        /// Distance from the grid, as share of the interval.
        share: f64,
        /// The grid's interval, s.
        interval: f64,
    },

    // ---- loggers' files, new campaigns
    /// A file that can't be imported.
    #[error("{}: {}{problem}; {remedy}", path.display(), of_channel(channel.as_deref()))]
    LoggerFile {
        /// The file.
        path: PathBuf,
        /// The channel, where one is to blame.
        channel: Option<String>,
        /// What was read.
        problem: String,
        /// What to do.
        remedy: String,
    },
    /// A folder to write a campaign to that has something in it.
    #[error("{}: there is {found} already; give a folder that is new or empty, nothing is overwritten", path.display())]
    NotEmpty {
        /// The folder.
        path: PathBuf,
        /// What is there.
        found: String,
    },

    // ---- FMU file
    /// Not a zip archive, or a damaged one.
    #[error("{}: not a readable .fmu (zip) file: {reason}; it may be cut off, copy or export it again", path.display())]
    FmuArchive {
        /// The FMU file.
        path: PathBuf,
        /// The archive reader's reason.
        reason: String,
    },
    /// modelDescription.xml is missing or cannot be understood.
    #[error("{}: modelDescription.xml: {problem}", path.display())]
    FmuDescription {
        /// The FMU file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// The FMU is for model exchange only.
    #[error("{}: offers no co-simulation; export it as FMI 2.0 co-simulation", path.display())]
    NotCoSimulation {
        /// The FMU file.
        path: PathBuf,
    },
    /// No binary for this computer.
    #[error("{}: no binary for {platform} (binaries/{platform}/{library} is missing; present: {}); get an FMU built for this platform", path.display(), quoted(present))]
    FmuPlatform {
        /// The FMU file.
        path: PathBuf,
        /// FMI's name of this platform.
        platform: &'static str,
        /// The file that should be there.
        library: String,
        /// Platforms that the FMU has.
        present: Vec<String>,
    },
    /// The FMU's library could not be loaded, or the FMU refused to be instantiated.
    #[error("{}: cannot be instantiated: {reason}", path.display())]
    FmuInstantiate {
        /// The FMU file.
        path: PathBuf,
        /// The loader's or the FMU's reason.
        reason: String,
    },
    /// A variable that the FMU does not have.
    #[error("{}: no variable '{name}'{}; `stickslip simulate --list` shows all", path.display(), suggestion(nearest))]
    UnknownVariable {
        /// The FMU file.
        path: PathBuf,
        /// The name asked for.
        name: String,
        /// Names most like it.
        nearest: Vec<String>,
    },
    /// An effect that the FMU does not declare.
    #[error("{}: no effect '{id}'{}; `stickslip effects` lists all", path.display(), suggestion(nearest))]
    UnknownEffect {
        /// The FMU file.
        path: PathBuf,
        /// The identifier asked for.
        id: String,
        /// Identifiers most like it.
        nearest: Vec<String>,
    },
    /// A value that does not fit the type of its variable.
    #[error("variable '{name}' is {kind}: {value} cannot be given to it; {rule}")]
    VariableValue {
        /// The variable.
        name: String,
        /// Its type.
        kind: &'static str,
        /// The value.
        value: String,
        /// What fits.
        rule: &'static str,
    },
    /// An FMI call did not succeed.
    #[error(
        "{call} of instance '{instance}' returned {status}: {}",
        or_silent(messages)
    )]
    FmiCall {
        /// The FMI function.
        call: &'static str,
        /// The instance's name.
        instance: String,
        /// The FMI status.
        status: &'static str,
        /// What the FMU logged about it.
        messages: String,
    },
    /// A saved FMU state used with another instance, or after its release.
    #[error(
        "this FMU state does not belong to instance '{instance}'; serialise it to move it between instances"
    )]
    ForeignState {
        /// The instance it was given to.
        instance: String,
    },

    // ---- commands
    /// A command line that is no command of this program.
    #[error("{problem}; --help lists what there is")]
    Usage {
        /// What is wrong with it.
        problem: String,
    },
    /// An option's value that cannot be used.
    #[error("{option} {value} {rule}")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: String,
        /// What is allowed.
        rule: String,
    },
    /// A series without a correlation dimension.
    #[error("{series}: {source}")]
    Dimension {
        /// The series.
        series: String,
        /// Why not, and what to do.
        source: crate::dimension::DimensionError,
    },
    /// The observer cannot work with a run.
    #[error("{}: {source}", path.display())]
    Observe {
        /// The run's file.
        path: PathBuf,
        /// Why not, and what to do.
        source: crate::observer::ObserverError,
    },
    /// Inputs of an uneven record can't be interpolated band-limited.
    #[error("{}: input column '{column}' can't be taken as band-limited: the sample intervals scatter by {jitter:.2} % and there are {gaps} gaps; state input_interpolation = \"linear\" or \"held\"", path.display())]
    UnevenInput {
        /// The CSV file.
        path: PathBuf,
        /// The column.
        column: String,
        /// Scatter of the intervals, %.
        jitter: f64,
        /// Number of gaps.
        gaps: usize,
    },
    /// A filter that can't be undone: what happened in a gap is lost.
    #[error("{}: [sensor] high_pass_hz = {corner_hz} Hz can't be undone across {gaps} gap(s) of the record; split the file there, or leave the key out", path.display())]
    FilteredGaps {
        /// The CSV file.
        path: PathBuf,
        /// Corner frequency, Hz.
        corner_hz: f64,
        /// Number of gaps.
        gaps: usize,
    },
    /// A measured normal force below zero.
    #[error("{}: column '{column}', sample {sample}: normal force {value} N is below zero, which means no contact; turn its sign with normal_force_scale, or leave these samples out", path.display())]
    NegativeLoad {
        /// The CSV file.
        path: PathBuf,
        /// The column.
        column: String,
        /// The sample, counted from 1.
        sample: usize,
        /// N.
        value: f64,
    },
    /// A command that needs constant inputs was given a run with others.
    #[error(
        "run '{run}' is driven by {input}, and `{command}` reads runs at constant belt velocity and normal force without other forces; leave the run out, or state the constant value where it varies too little to matter (`compare`, `diagnose` and `simulate` follow it)"
    )]
    DrivenRun {
        /// The run.
        run: String,
        /// The input, with its column or value.
        input: String,
        /// The command.
        command: &'static str,
    },
    /// A command that needs a structure with springs was given a mass that slides freely.
    #[error("{}: natural_frequencies_hz[{mode}] = 0 Hz is a mass without a spring, and `{command}` needs the stiffness of every mode; give its frequency, or leave the mode out (`compare`, `diagnose` and `simulate` take such masses)", path.display())]
    FreeMode {
        /// The campaign's folder or file.
        path: PathBuf,
        /// The mode, counted from 1.
        mode: usize,
        /// The command.
        command: &'static str,
    },
    /// What the observer must know of the beam and campaign.toml or the model file does not say.
    #[error("{}: [beam] {key} is not given; the observer needs it to {purpose}, add it", path.display())]
    BeamUnknown {
        /// The file.
        path: PathBuf,
        /// The missing key.
        key: &'static str,
        /// What for.
        purpose: &'static str,
    },
    /// A value given on the studio's page that its parameter can't have.
    #[error("{name} = {value} {unit} lies outside {min} to {max} {unit}; give a value within")]
    StudioValue {
        /// The parameter.
        name: String,
        /// The value.
        value: f64,
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
        /// Unit of all three.
        unit: String,
    },
    /// A history of tries that can't be read.
    #[error("{}: not a history that this version reads: {problem}; move it away, or give another folder with -o", path.display())]
    StudioState {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A rung of the ladder that is not there.
    #[error(
        "the ladder has no rung {id} that this can be done with; reload the page to see those there are"
    )]
    NoRung {
        /// Its number.
        id: u64,
    },
    /// Work asked for while other work runs.
    #[error("{running} is at work; wait for it, or cancel it")]
    StudioBusy {
        /// What runs.
        running: String,
    },
    /// Something asked of the studio while no campaign is open.
    #[error("no campaign is open: {why}; mend it and reload, or drop a file on the page")]
    StudioClosed {
        /// Why.
        why: String,
    },
    /// A part of the program that gave up.
    #[error("internal error: {problem}; the page goes on, please report what was done")]
    Internal {
        /// What it said.
        problem: String,
    },
    /// A port of this computer that can't be listened on.
    #[error(
        "cannot listen on 127.0.0.1:{port}: {source}; give another --port, or 0 for any that is free"
    )]
    Port {
        /// The port.
        port: u16,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A run that the campaign does not list.
    #[error("{}: no run of this campaign has the file {}; it has {}", campaign.display(), run.display(), known.join(", "))]
    RunNotInCampaign {
        /// The campaign.
        campaign: PathBuf,
        /// The file asked for.
        run: PathBuf,
        /// Its runs' files.
        known: Vec<String>,
    },
    /// The FMU's binary, needed for packing, was not found.
    #[error("{library} is not beside {}; build all with `cargo build --release` in the repository, then pack again", searched.display())]
    NoBinaryToPack {
        /// The library looked for.
        library: String,
        /// The running program, beside which it should lie.
        searched: PathBuf,
    },
    // ---- parameter studies
    /// A variable that a study can't vary.
    #[error("'{name}' can't be varied or set: {problem}")]
    SweepVariable {
        /// The variable.
        name: String,
        /// Why not, and what to do.
        problem: String,
    },
    /// A folder that holds the results of another study.
    #[error("{}: holds another sweep ({difference}); give another folder with -o, or remove this one", folder.display())]
    OtherSweep {
        /// The folder.
        folder: PathBuf,
        /// What differs.
        difference: String,
    },
    /// A folder in which another process works.
    #[error("{}: another sweep is writing there; wait for it, or give another folder with -o", folder.display())]
    FolderInUse {
        /// The folder.
        folder: PathBuf,
    },
    /// Stopped by the user.
    #[error("stopped after {done} of {of} {what}; they are kept in {}, the same command goes on from there", folder.display())]
    Stopped {
        /// What is counted.
        what: &'static str,
        /// How many are finished.
        done: usize,
        /// How many were asked for.
        of: usize,
        /// Where they are.
        folder: PathBuf,
    },
    /// A search that was stopped by someone who does not want what it has found.
    #[error(
        "the search was stopped; its fits are kept in the folder of results, the same call goes on from there"
    )]
    Discarded,
    /// Stopped by the user, and nothing of it is kept.
    #[error("stopped after {done} of {of} {what}; nothing was written, begin anew")]
    Interrupted {
        /// What is counted.
        what: &'static str,
        /// How many are finished.
        done: usize,
        /// How many were asked for.
        of: usize,
    },
    /// A campaign with values that can't be meant.
    #[error("{}: {errors} finding(s) that can't be meant; {runs}: {finding}. `stickslip check` shows all, --force begins all the same", campaign.display())]
    Questionable {
        /// The campaign.
        campaign: PathBuf,
        /// How many there are.
        errors: usize,
        /// Runs that the first concerns.
        runs: String,
        /// The first: what was measured, what was stated, what to do.
        finding: String,
    },
    /// A gate of `--fail-above` is not met.
    #[error("run '{run}': NRMSE {value:.4} is above the limit {limit} set by --fail-above")]
    GateFailed {
        /// The worst run.
        run: String,
        /// Its NRMSE.
        value: f64,
        /// The limit.
        limit: f64,
    },
}

impl Error {
    /// How the command ends that fails with this.
    pub fn exit(&self) -> Exit {
        match self {
            Error::GateFailed { .. } => Exit::GateFailed,
            Error::FmiCall { .. } | Error::ForeignState { .. } => Exit::FmuFailed,
            Error::Print { source } if source.kind() == std::io::ErrorKind::BrokenPipe => {
                Exit::ReaderGone
            }
            Error::Write { .. } | Error::Print { .. } => Exit::NotWritten,
            Error::Stopped { .. } | Error::Interrupted { .. } | Error::Discarded => Exit::Stopped,
            _ => Exit::BadInput,
        }
    }

    /// The message in one line.
    pub fn line(&self) -> String {
        let text = self.to_string();
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        lines.join("; ")
    }

    /// The process's exit code.
    pub fn exit_code(&self) -> u8 {
        self.exit().code()
    }

    /// For `map_err` after a failed read of `path`.
    pub fn read(path: &Path) -> impl FnOnce(std::io::Error) -> Error + '_ {
        |source| Error::Read {
            path: path.to_owned(),
            source,
        }
    }

    /// For `map_err` after a failed write of `path`.
    pub fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Error + '_ {
        |source| Error::Write {
            path: path.to_owned(),
            source,
        }
    }
}

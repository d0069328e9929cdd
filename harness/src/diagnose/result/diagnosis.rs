//! What a diagnosis finds, in the form of diagnosis.json.

use crate::diagnose::explanation::proposed_term::ProposedTerm;
use crate::diagnose::model::work::Counts;
use crate::diagnose::result::further_sensors::FoundSensor;
use crate::diagnose::result::unknown::Unknown;
use crate::diagnose::selection::next_measurement::NextMeasurement;
use crate::diagnose::validation::estimate::Estimate;
use crate::diagnose::validation::forecast::Forecast;
use crate::diagnose::validation::identifiability::Undetermined;
use crate::measurement::{Measurand, NoiseStd};
use crate::metric::half_width;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// One or more effects of the catalogue explain the data.
    EffectFound,
    /// The calibrated model explains the data already.
    NoMissingEffect,
    /// Significant misfit remains that no effect of the catalogue removes, or none of those tried by hand.
    UnknownEffect,
}

impl Estimate {
    /// Half the width of the 95 % interval, which people are shown after "+-" or "±" everywhere; `None` for a value that was
    /// not fitted or whose spread is unknown.
    pub fn half_width(&self) -> Option<f64> {
        let half = half_width(self.std);
        (half > 0.0 && half.is_finite()).then_some(half)
    }
}

/// Why an effect is believed.
#[derive(Debug, Clone, Serialize)]
pub struct Evidence {
    /// Error kept out of the fit before the effect was added.
    pub holdout_nrmse_before: f64,
    /// The same after.
    pub holdout_nrmse_after: f64,
    /// Fall of the objective (natural logarithm of the likelihood) through the effect.
    pub gain: f64,
    /// Fall below which a gain counts as chance.
    pub threshold: f64,
    /// Probability of such a gain by chance, where campaigns without the effect were simulated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_value: Option<f64>,
    /// Root of the median mean square error over the noise after the effect: 1 is the floor.
    pub floor_ratio: f64,
    /// Where the effect is believed for what the break-aways tell, though the errors do not come down to the noise: for each
    /// run the fall of the error of predicting each break-away from the others by its place (NaN where they are too few).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub break_away_falls: Vec<f64>,
}

/// An effect that was found.
#[derive(Debug, Clone, Serialize)]
pub struct FoundEffect {
    /// Identifier.
    pub id: String,
    /// Parameters common to all runs.
    pub parameters: BTreeMap<String, Estimate>,
    /// Values that differ from run to run, run by run.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub own_parameters: BTreeMap<String, Vec<f64>>,
    /// Why it is believed.
    pub evidence: Evidence,
    /// Effects that these data can't tell from it.
    pub confounded_with: Vec<String>,
    /// Parameters in other forms of the same effect that explain the data as well.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub other_forms: Vec<BTreeMap<String, f64>>,
}

/// One rung of the error ladder.
#[derive(Debug, Clone, Serialize)]
pub struct Rung {
    /// `as given`, `calibrated`, `+ <id>`.
    pub step: String,
    /// Error on the runs fitted.
    pub fit_nrmse: f64,
    /// Error on the runs kept out.
    pub holdout_nrmse: f64,
    /// Median error on the runs kept out over the noise.
    pub holdout_over_noise: f64,
    /// Error of one-cycle forecasts of the runs kept out (see [`Forecast`]); `None` where none is kept out.
    pub forecast_nrmse: Option<f64>,
    /// Mean time in s for which the free motion predicted stays near the measured one; likewise.
    pub valid_time_s: Option<f64>,
    /// The forecasts that these come from.
    #[serde(skip)]
    pub forecasts: Vec<Forecast>,
    /// Error of each run, held-out error where it is kept out.
    pub by_run: Vec<f64>,
    /// Median error of each further sensor over its noise, on the runs kept out; NaN where it read nothing there.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub further_over_noise: Vec<f64>,
}

/// A candidate's standing.
#[derive(Debug, Clone, Serialize)]
pub struct Standing {
    /// Identifier (with its form, where it has several).
    pub id: String,
    /// Error kept out of the fit, where it was worked out.
    pub holdout_nrmse: f64,
    /// Posterior probability, among all hypotheses compared.
    pub probability: f64,
    /// Gain in evidence over the calibrated model on the data compared, nats.
    pub score: f64,
    /// Logarithm of the evidence on the data compared, nats, up to what is the same for all.
    pub log_evidence: f64,
    /// Fall of the negative logarithm of likelihood and prior below the calibrated model's, nats, without a price on
    /// parameters. Never negative for an effect that an amplitude switches off.
    pub misfit_fall: f64,
    /// Median error over the noise on the runs fitted.
    pub fit_over_noise: f64,
    /// Number of values that were free in it, those of the runs included, start states not.
    pub free_values: usize,
    /// Found parameter values.
    pub parameters: BTreeMap<String, f64>,
    /// Whether it was fitted; a score test beside an adequate hypothesis tells of the others that no fit could change the verdict.
    pub fitted: bool,
    /// Whether the search passed it over after a few steps, since others had come nearer to the data: it might come somewhat nearer too.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub passed_over: bool,
    /// Whether all segments of the runs fitted showed it to be wrong, however much it gains on those compared: a run is not met, more segments
    /// are lost than by chance, what remains is far from white, or the structure is bent.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub refuted: bool,
    /// Strength at which it would be named with even odds, in the unit of the parameter that switches it on; where a score test tells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detection_limit: Option<f64>,
}

/// An effect beside those named, by a score test.
#[derive(Debug, Clone, Serialize)]
pub struct FurtherEffect {
    /// Identifier.
    pub id: String,
    /// Posterior probability that it is at work beside those named.
    pub probability: f64,
    /// Expected gain in evidence on all data, nats.
    pub score: f64,
    /// Strength at which it would be named with even odds, in the unit of the parameter that switches it on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detection_limit: Option<f64>,
}

/// The whole diagnosis.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// Posterior probability of the verdict: of the effects named, in whatever form, or of nothing missing; where the verdict
    /// is that something unknown is, of that. `None` where effects were named by hand and nothing was compared.
    pub verdict_probability: Option<f64>,
    /// The effects in the order in which they were added.
    pub effects: Vec<FoundEffect>,
    /// Forecasts of the runs kept out by the model that the diagnosis ends with.
    pub forecast: Vec<Forecast>,
    /// The falling error.
    pub error_ladder: Vec<Rung>,
    /// Sensor noise.
    #[serde(flatten)]
    pub noise_std: NoiseStd,
    /// What was measured, where it is not the displacement.
    #[serde(skip_serializing_if = "is_displacement")]
    pub measured_quantity: Measurand,
    /// All candidates, best first.
    pub candidates: Vec<Standing>,
    /// Effects beside those named of which a score test says that no fit could change the verdict.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub further_effects: Vec<FurtherEffect>,
    /// Pairs of effects that were compared to first order and not fitted, the one that explains most first; none where something explains
    /// the data.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub untried_pairs: Vec<String>,
    /// Where the calibrated model fails.
    pub residual: serde_json::Value,
    /// Terms proposed where something outside the catalogue is missing; they stand in `residual`.
    #[serde(skip)]
    pub proposed_terms: Vec<ProposedTerm>,
    /// Where something unknown acts, what it depends on, and the curve; where the verdict is that something unknown is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unknown: Option<Unknown>,
    /// Values of the effects that the calibrated model has though none of them is named, by FMU variable.
    #[serde(skip)]
    pub unnamed_effects: Vec<(String, f64)>,
    /// What to measure next.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_measurement: Option<NextMeasurement>,
    /// What was found and how sure it is, in plain words.
    pub summary: String,
    /// Remarks on the data: what can't be told, and why.
    pub remarks: Vec<String>,
    /// Calibrated parameters of the model.
    pub calibrated: BTreeMap<String, Estimate>,
    /// By which factors belt velocities and normal forces are off from what the campaign states.
    pub inputs: BTreeMap<String, Estimate>,
    /// What the data cannot separate.
    pub identifiability: Vec<Undetermined>,
    /// For the calibrated model and each effect added: power of the residuals at low frequencies over that at high ones.
    /// Noise alone gives somewhat less than 1.
    #[serde(rename = "residual_colour")]
    pub residual_spectral_ratio: Vec<f64>,
    /// Largest gains of all candidates in simulated campaigns without the effect, for each step; empty unless asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gains_by_chance: Vec<Vec<f64>>,
    /// The structure as far as it was taken as known, by FMU variable: number of modes, tip values, and the modal masses
    /// that follow from the calibrated one.
    pub structure: BTreeMap<String, f64>,
    /// What was computed for it, without the pictures of the report.
    pub counters: Counts,
    /// Friction level and sensor offset of each run.
    pub runs: Vec<RunValues>,
    /// Sensors beside the first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub further_sensors: Vec<FoundSensor>,
}

/// Campaigns held displacements alone once, and their diagnoses stay as they were.
fn is_displacement(measurand: &Measurand) -> bool {
    *measurand == Measurand::Displacement
}

/// What belongs to one run.
#[derive(Debug, Clone, Serialize)]
pub struct RunValues {
    /// File name.
    pub name: String,
    /// Belt velocity in m/s.
    pub belt_velocity_m_per_s: f64,
    /// Normal force in N.
    pub normal_force_n: f64,
    /// Whether it was kept out of the fit.
    pub held_out: bool,
    /// Values of its own, by name.
    #[serde(rename = "own")]
    pub per_run: BTreeMap<String, f64>,
}

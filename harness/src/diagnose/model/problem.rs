//! What every stage of a diagnosis shares: the FMU, the campaign, its segments, and what is held out.

use crate::diagnose::data::belt_speed::{BeltScale, belt_scale};
use crate::diagnose::data::break_away::{BreakAways, place_is_told, predict};
use crate::diagnose::data::break_away_events::{Event, events};
use crate::diagnose::data::coarse_excitation::coarsen;
use crate::diagnose::data::further_readings::{
    agree_on_noise, follow_the_motion, silent_sensors, unread_sensors,
};
use crate::diagnose::data::hold_out::HoldOut;
use crate::diagnose::data::place_map::PlaceMap;
use crate::diagnose::data::segment::{Segment, cut, further_parts, thin};
use crate::diagnose::data::usable_run::UsableRun;
use crate::diagnose::model::belt_profile::Track;
use crate::diagnose::model::finished_work::FinishedWork;
use crate::diagnose::model::friction_prior::{FrictionPrior, StartFriction};
use crate::diagnose::model::further_sensors::delay_beliefs;
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::known_structure::structure;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::periodic::Spectra;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::references::References;
use crate::diagnose::model::scales::Scales;
use crate::diagnose::model::sensor_zero::SensorZero;
use crate::diagnose::model::similarity::on_machine;
use crate::diagnose::model::unknown_function::UnknownFunction;
use crate::diagnose::model::work::Work;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::fmu::effect_card::{EffectCard, candidates};
use crate::measurement::{Campaign, DelayBelief, Run, of_one_sensor};
use crate::metric::standard_deviation;
use crate::observer::Structure;
use crate::smoothing::Smoothing;

/// Shortest horizon of a prediction in s.
pub const HORIZON: f64 = 0.02;

/// Segments of a run that are used at most: a second of the default case.
const MOST_SEGMENTS: usize = 40;

/// The same of a run with measured inputs: each of their samples ends a step of the integrator, so that a segment costs some twenty
/// times as much.
const MOST_DRIVEN_SEGMENTS: usize = 12;

/// Neighbouring segments that are taken together where not all are.
const GROUP: usize = 4;

/// Samples of a segment for each component of its start state: a tenth of what is measured then goes into the start.
pub(crate) const SAMPLES_OF_A_STATE: usize = 10;

/// Samples of a segment where no mode has a spring, by whose period it could be measured: as many as [`HORIZON`] has at 10 kHz.
const FREE_SAMPLES: f64 = 200.0;

/// Samples in a row that err alike where friction scatters: counted one by one, single slips would pull all that is fitted.
const ALIKE: f64 = 100.0;

/// The error of a campaign in which no run moves, with the one that varies most.
fn nothing_moves(campaign: &Campaign) -> Error {
    let of_runs = campaign.runs.iter();
    let spreads = of_runs.map(|r| (standard_deviation(&r.measured), r.noise.std));
    let (spread, noise) = spreads.fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
    Error::NothingMoves {
        campaign: campaign.folder.clone(),
        quantity: campaign.measurand().name(),
        unit: campaign.measurand().unit(),
        spread,
        noise,
    }
}

/// Effects that the model offers, with values as they are met on a machine whose scales have these ratios to those of the FMU's.
fn cards(fmu: &Fmu, ratios: Scales) -> Result<Vec<EffectCard>, Error> {
    let cards = candidates(fmu)?;
    Ok(cards.into_iter().map(|c| on_machine(c, ratios)).collect())
}

/// Horizon of a prediction in s: a cycle and a half of the lowest mode, most of the shortest stick-slip cycle, and enough samples
/// to fit the start state from. Where an external force or the clamp moves the tip, stick begins and ends as they have it: the time
/// between break-aways is then no cycle.
fn horizon(runs: &[Run], structure: &Structure, smoothings: &[Smoothing]) -> f64 {
    let shortest = runs
        .iter()
        .zip(smoothings)
        .filter(|(run, _)| !run.inputs.is_shaken())
        .map(|(_, s)| s.cycle)
        .filter(|c| c.is_finite())
        .fold(f64::INFINITY, f64::min);
    let shortest = if shortest.is_finite() { shortest } else { 0.0 };
    let sprung = structure.modes().iter().filter(|m| !m.is_free());
    let lowest = sprung.map(|m| m.frequency_hz).fold(f64::INFINITY, f64::min);
    let coarsest = runs.iter().map(Run::sample_interval).fold(0.0, f64::max);
    let of_structure = if lowest.is_finite() {
        1.6 / lowest
    } else {
        FREE_SAMPLES * coarsest
    };
    let states = 2 * structure.modes().len();
    HORIZON
        .max(of_structure)
        .max(0.6 * shortest)
        .max((SAMPLES_OF_A_STATE * states) as f64 * coarsest)
}

/// A diagnosis in progress.
pub struct Problem<'a> {
    /// The model.
    pub fmu: &'a Fmu,
    /// The measurements, with the belt speeds that their stick phases show.
    pub campaign: Campaign,
    /// Factor from the stated belt speeds to these, common to all runs.
    pub belt_scale: BeltScale,
    /// Belt speeds in m/s as the campaign states them.
    stated_belt_velocities: Vec<f64>,
    /// Length, velocity and force of the machine measured.
    scales: Scales,
    /// Their ratios to those of the machine that the FMU's values hold for.
    ratios: Scales,
    /// Effects that the model offers, with values as they are met on this machine.
    pub catalogue: Vec<EffectCard>,
    /// Whether each of them can act in this campaign; all, before it was asked.
    pub acts: Vec<bool>,
    /// Names looked up.
    pub references: References,
    /// Each run's motion and force, estimated without a friction law.
    pub smoothings: Vec<Smoothing>,
    /// What predicts the break-aways of each run.
    pub break_aways: Vec<BreakAways>,
    /// All segments, run after run.
    pub segments: Vec<Segment>,
    /// Sensor noise of each run in m, or m/s where a velocity was measured, as all that is compared with what was measured.
    pub noise: Vec<f64>,
    /// Noise of each run that fits count with: the sensor's, or more where friction scatters.
    fit_noise: Vec<f64>,
    /// Standard deviation of what each run measured.
    pub spread: Vec<f64>,
    /// What each run passes of the belt.
    pub tracks: Vec<Track>,
    /// Whether a run is kept out of the fit.
    pub held_out: Vec<bool>,
    /// Horizon of a prediction in s.
    pub horizon: f64,
    /// What is believed of the friction constants before any fit.
    pub friction: FrictionPrior,
    /// Spectra of the smoothed force that were asked for.
    pub spectra: Spectra,
    /// What must be said of the runs.
    pub remarks: Vec<String>,
    /// Fits that were finished before, where a stopped diagnosis goes on.
    pub finished: FinishedWork,
    /// What is believed of the first sensor's zero.
    pub zero: SensorZero,
    /// How far the clocks of further sensors may be off.
    pub delays: Vec<DelayBelief>,
    /// Counts of what was computed.
    pub work: Work,
    /// Unknown functions that the model offers as effects.
    pub unknown_functions: Vec<UnknownFunction>,
    /// Files of the formulas that were found for one of them.
    pub formula_files: Vec<String>,
}

impl<'a> Problem<'a> {
    /// Smooths the runs, cuts them into segments and decides what is held out.
    ///
    /// # Errors
    /// A campaign that the observer refuses, or an FMU without the variables needed.
    pub fn new(fmu: &'a Fmu, campaign: &Campaign) -> Result<Self, Error> {
        Self::holding_out(fmu, campaign, HoldOut::Middle)
    }

    /// The same, where the user says what is held out.
    ///
    /// # Errors
    /// See [`Self::new`].
    pub fn holding_out(fmu: &'a Fmu, campaign: &Campaign, rule: HoldOut) -> Result<Self, Error> {
        let structure = structure(fmu, &campaign.beam)?;
        let references = References::new(fmu, &structure, campaign)?;
        for run in &campaign.runs {
            for (name, _, excitation) in run.inputs.excitations() {
                if excitation.acts() {
                    fmu.variable(name)?;
                }
            }
        }
        let used = UsableRun::all(&campaign.runs);
        let moves: Vec<bool> = used.iter().map(|u| u.moves).collect();
        if !moves.contains(&true) {
            return Err(nothing_moves(campaign));
        }
        let mut remarks: Vec<String> = used.iter().flat_map(|u| u.remarks.clone()).collect();
        remarks.extend(silent_sensors(campaign));
        let mut campaign = Campaign {
            runs: used.into_iter().map(|u| u.run).collect(),
            ..campaign.clone()
        };
        let estimates: Vec<f64> = campaign.runs.iter().map(|r| r.noise.std).collect();
        let noise = of_one_sensor(&estimates);
        for (run, noise) in campaign.runs.iter_mut().zip(&noise) {
            run.noise.std = *noise;
        }
        let stated_belt_velocities = campaign.runs.iter().map(|r| r.belt_velocity).collect();
        let (belt_scale, of_runs) = belt_scale(&campaign, &structure)?;
        for (run, factor) in campaign.runs.iter_mut().zip(of_runs) {
            run.belt_velocity *= factor;
            if let Some(series) = &mut run.inputs.belt_velocity {
                series.values.iter_mut().for_each(|v| *v *= factor);
            }
        }
        let expected = StartFriction::of(fmu)?;
        let (zero, smoothings) = SensorZero::and_smoothings(
            &campaign.runs,
            &structure,
            expected,
            campaign.uncertainty.zero_std,
        )?;
        if zero.is_open {
            remarks.push(zero.remark(&campaign.runs));
        }
        agree_on_noise(&mut campaign.runs);
        let delays = delay_beliefs(fmu, &campaign);
        let of_clocks = follow_the_motion(&campaign, &structure, &smoothings, &delays)?;
        remarks.extend(of_clocks);
        let horizon = horizon(&campaign.runs, &structure, &smoothings);
        for (run, noise) in campaign.runs.iter_mut().zip(&noise) {
            // What a coarse force does to the readings of further sensors is not looked at.
            if run.further.is_empty() {
                coarsen(&structure, run, horizon, *noise);
            }
        }
        let mut segments = Vec::new();
        for (index, (run, smoothing)) in campaign.runs.iter().zip(&smoothings).enumerate() {
            let further = further_parts(run, smoothing, noise[index], &delays);
            let of_run = cut((index, run), smoothing, &further, horizon);
            let most = match run.inputs.series().next() {
                Some(_) => MOST_DRIVEN_SEGMENTS,
                None => MOST_SEGMENTS,
            };
            segments.extend(thin(of_run, smoothing, most, GROUP));
        }
        remarks.extend(unread_sensors(&campaign, &segments));
        let events: Vec<Vec<Event>> = campaign
            .runs
            .iter()
            .zip(&smoothings)
            .map(|(run, smoothing)| events(run, smoothing))
            .collect();
        let break_aways: Vec<BreakAways> = campaign
            .runs
            .iter()
            .zip(&events)
            .map(|(run, events)| predict(&run.name, events))
            .collect();
        let place_is_told = place_is_told(&break_aways);
        let tracks = (0..campaign.runs.len())
            .map(|r| {
                let of_run = || segments.iter().filter(|s| s.run == r);
                let low = of_run()
                    .map(|s| s.travel.min(s.travel_end))
                    .fold(f64::INFINITY, f64::min);
                let high = of_run()
                    .map(|s| s.travel.max(s.travel_end))
                    .fold(f64::NEG_INFINITY, f64::max);
                let (low, high) = if low.is_finite() {
                    (low, high)
                } else {
                    (0.0, 1.0)
                };
                Track {
                    low,
                    high,
                    map: PlaceMap::new(&events[r], &break_aways[r]),
                    place_is_told,
                }
            })
            .collect();
        let roughness = if place_is_told { ALIKE.sqrt() } else { 1.0 };
        let runs = campaign.runs.iter().zip(&smoothings).zip(&moves);
        let runs = runs.filter_map(|((run, s), m)| m.then_some((run, &s.stick_slip.smoothed)));
        let scales = Scales::of_runs(&structure, runs);
        let ratios =
            Scales::of_catalogue(fmu)?.map_or(Scales::ALIKE, |machine| scales.over(machine));
        let catalogue = cards(fmu, ratios)?;
        let is_other_machine = ratios != Scales::ALIKE;
        let problem = Self {
            acts: vec![true; catalogue.len()],
            catalogue,
            scales,
            ratios,
            references,
            fit_noise: noise.iter().map(|n| n * roughness).collect(),
            noise,
            spread: campaign
                .runs
                .iter()
                .map(|r| standard_deviation(&r.measured))
                .collect(),
            held_out: rule.of(&campaign),
            zero,
            delays,
            friction: FrictionPrior::new(expected, is_other_machine, &campaign.runs, &smoothings),
            spectra: Spectra::default(),
            remarks,
            finished: FinishedWork::default(),
            work: Work::default(),
            unknown_functions: Vec::new(),
            formula_files: Vec::new(),
            break_aways,
            smoothings,
            segments,
            tracks,
            horizon,
            fmu,
            campaign,
            belt_scale,
            stated_belt_velocities,
        };
        problem.has_segments()?;
        Ok(problem)
    }

    /// Whether there are segments to learn from and segments to judge on; no fit can do without.
    fn has_segments(&self) -> Result<(), Error> {
        let campaign = &self.campaign.folder;
        if self.held_out.iter().all(|h| *h) {
            return Err(Error::NothingToFit {
                campaign: campaign.clone(),
            });
        }
        let too_short = |of: &'static str, segments: usize| Error::RunsTooShort {
            campaign: campaign.clone(),
            of,
            segments,
            // A segment, its search for a place to begin, and the margin before the first.
            needed: 1.25 * self.horizon * segments as f64,
        };
        if self.fit_segments(1).is_empty() {
            return Err(too_short("learn from", 1));
        }
        // Of a run that is judged the first segment teaches what is its own, the second is judged; where none is held out,
        // all are.
        let is_judged = |run: &usize| self.held_out[*run] || !self.held_out.contains(&true);
        let segments_of = |run: usize| self.segments.iter().filter(|s| s.run == run).count();
        let mut judged = (0..self.held_out.len()).filter(is_judged);
        if !judged.any(|run| segments_of(run) > 1) {
            return Err(too_short("judge on", 2));
        }
        Ok(())
    }

    /// Number of runs that are fitted.
    pub fn fitted_runs(&self) -> usize {
        self.held_out.iter().filter(|out| !**out).count()
    }

    /// Belt speed of a run in m/s as the campaign states it.
    pub fn stated_belt_velocity(&self, run: usize) -> f64 {
        self.stated_belt_velocities[run]
    }

    /// Goes on with an FMU that offers more effects behind those of the one before, which keep their places and variables.
    ///
    /// # Errors
    /// An annotation of effects that can't be read.
    pub fn widen(&mut self, fmu: &'a Fmu, formula_files: Vec<String>) -> Result<(), Error> {
        self.catalogue = cards(fmu, self.ratios)?;
        // What is added was found in this campaign.
        self.acts.resize(self.catalogue.len(), true);
        self.fmu = fmu;
        self.formula_files = formula_files;
        Ok(())
    }

    /// Makes fits count with the sensor's noise, as they may where a model explains the data.
    pub fn trust_sensor(&mut self) {
        self.fit_noise.clone_from(&self.noise);
    }

    /// Makes fits count with these standard deviations of the first sensor, one for each run, and further ones `of_further` times as uncertain
    /// beside it, run by run.
    pub fn count_with(&mut self, noise: Vec<f64>, of_further: &[Vec<f64>]) {
        self.fit_noise = noise;
        for segment in &mut self.segments {
            for part in &mut segment.further {
                part.loosen(of_further[segment.run][part.sensor]);
            }
        }
    }

    /// Whether the break-aways tell that friction depends on the place.
    pub fn place_is_told(&self) -> bool {
        self.tracks.iter().any(|t| t.place_is_told)
    }

    /// The reference model with some effects.
    ///
    /// # Errors
    /// See [`Hypothesis::new`].
    pub fn hypothesis(&self, choices: &[Choice]) -> Result<Hypothesis, Error> {
        Hypothesis::new(
            self.fmu,
            &self.campaign,
            &self.catalogue,
            choices,
            &self.tracks,
            (&self.zero, &self.delays, self.belt_scale.std, self.scales),
            &self.friction,
        )
    }

    /// Segments with the noise of their runs, to be fitted.
    pub fn data<'b>(&'b self, segments: &'b [Segment]) -> Observations<'b> {
        Observations {
            segments,
            noise: &self.fit_noise,
            work: &self.work,
        }
    }

    /// A predictor of this campaign's runs.
    ///
    /// # Errors
    /// An FMU that can't be instantiated.
    pub fn predictor<'b>(&'b self, hypothesis: &'b Hypothesis) -> Result<Predictor<'b>, Error> {
        Predictor::new(
            self.fmu,
            &self.references,
            &self.campaign.runs,
            hypothesis,
            &self.work,
        )
    }

    /// Copies of the segments with these indices.
    pub fn copies(&self, indices: &[usize]) -> Vec<Segment> {
        indices.iter().map(|&k| self.segments[k].clone()).collect()
    }

    /// Segments of the runs that are fitted; with `every` > 1, groups of neighbours taken evenly,
    /// so that a start can be taken from the end of the segment before.
    pub fn fit_segments(&self, every: usize) -> Vec<usize> {
        (0..self.segments.len())
            .filter(|&k| !self.held_out[self.segments[k].run])
            .enumerate()
            .filter(|(i, _)| (i / GROUP).is_multiple_of(every))
            .map(|(_, k)| k)
            .collect()
    }
}

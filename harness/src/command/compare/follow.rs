//! The model's motions made to follow a record.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::model_motion::Motions;
use crate::error::Error;
use crate::measurement::Run;
use crate::metric::{
    AlignedResidual, ModelMotion, Period, align, amplitude, blocks, nrmse, period,
};
use crate::parallel::parallel;
use crate::watch::Watch;

/// The model at a record's sample times.
pub(super) struct Follower {
    /// What was measured, m or m/s.
    pub measured: Vec<f64>,
    /// The velocity, m/s, beside a displacement, or the displacement, m, beside a velocity; NaN where the model is switched from one motion or phase to another.
    pub other: Vec<f64>,
    /// What each further sensor reads, in its SI unit; NaN likewise.
    pub further: Vec<Vec<f64>>,
    /// Measured minus model, m or m/s.
    pub residual: Vec<f64>,
    /// Root mean square of the residual over the spread of the measurement, 1.
    pub nrmse: f64,
    /// Period of the one motion whose amplitude is nearest to the measured.
    pub own_period: Option<Period>,
}

/// Aligns the best piece of `motions` to each cycle of a run with this cycle `period` (s). Without a period there is nothing to
/// align: then the first piece, which starts from the measured state, is taken as it is.
pub(super) fn follow(
    time: &[f64],
    run: &Run,
    motions: &Motions,
    period_s: Option<f64>,
    watch: &dyn Watch,
) -> Result<Follower, Error> {
    let interval = run.sample_interval();
    let pieces = motions.pieces();
    let Some(period_s) = period_s else {
        let model = pieces[0].measured(run.measurand, interval).at_all(time);
        return Ok(Follower {
            other: pieces[0].other(run.measurand, interval).at_all(time),
            further: pieces[0]
                .further(interval)
                .iter()
                .map(|m| m.at_all(time))
                .collect(),
            residual: run
                .measured
                .iter()
                .zip(&model)
                .map(|(m, y)| m - y)
                .collect(),
            nrmse: nrmse(&run.measured, &model),
            own_period: period(pieces[0].samples(run.measurand, time.len()), interval),
            measured: model,
        });
    };
    let views: Vec<_> = pieces
        .iter()
        .map(|p| p.measured(run.measurand, interval))
        .collect();
    let measured = &run.measured;
    let blocks = blocks(time, measured, period_s, motions.block(interval));
    let done = AtomicUsize::new(0);
    let fits = parallel(&blocks, |block| {
        let aligned = align(time, measured, block, &views, period_s);
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        watch.step(&run.name, done, blocks.len());
        Ok(aligned.fits)
    })?;
    let aligned = AlignedResidual::of(time, measured, &views, fits.concat());
    let mut other = Vec::with_capacity(time.len());
    let mut further = vec![Vec::with_capacity(time.len()); pieces[0].further(interval).len()];
    for fit in &aligned.fits {
        let continued = |values: &mut Vec<f64>, motion: ModelMotion| {
            let times = time[fit.samples.clone()].iter();
            values.extend(times.map(|t| motion.at(t + fit.shift)));
            values[fit.samples.start] = f64::NAN;
        };
        let piece = pieces[fit.motion];
        continued(&mut other, piece.other(run.measurand, interval));
        for (readings, motion) in further.iter_mut().zip(piece.further(interval)) {
            continued(readings, motion);
        }
    }
    let target = amplitude(&run.measured);
    let samples = |k: usize| pieces[k].samples(run.measurand, time.len());
    let off = |k: &usize| (amplitude(samples(*k)) - target).abs();
    let mut used: Vec<usize> = aligned.fits.iter().map(|f| f.motion).collect();
    used.sort_unstable();
    used.dedup();
    let nearest = used
        .into_iter()
        .map(|k| (k, off(&k)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(k, _)| k);
    Ok(Follower {
        own_period: nearest.and_then(|k| period(samples(k), interval)),
        measured: aligned.model,
        other,
        further,
        residual: aligned.residual,
        nrmse: aligned.nrmse,
    })
}

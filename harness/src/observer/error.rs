//! What can be wrong with the input of the observer, and what to do about it.

use thiserror::Error;

/// A record, a structure or a setting that the observer cannot work with.
///
/// Every message names the value found, its unit, its place and an action.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ObserverError {
    /// No mode was given.
    #[error("the structure has no mode; give at least one natural frequency")]
    NoModes,
    /// More modes than the fixed-size filters are compiled for.
    #[error(
        "{count} modes given, at most {limit} can be observed; leave out the modes above the measured band"
    )]
    TooManyModes {
        /// Number of modes given.
        count: usize,
        /// Largest number of modes.
        limit: usize,
    },
    /// Lists of modal data of different length.
    #[error("{expected} natural frequencies but {found} values of {what}; give one value per mode")]
    ModeCountMismatch {
        /// Which list.
        what: &'static str,
        /// Number of frequencies.
        expected: usize,
        /// Number of values in the list.
        found: usize,
    },
    /// A modal quantity outside its range.
    #[error("mode {mode}: {what} = {value} {unit} is not usable ({rule}); correct the modal data")]
    BadModeValue {
        /// Mode number, from 1.
        mode: usize,
        /// Name of the quantity.
        what: &'static str,
        /// Value found.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// The rule it violates.
        rule: &'static str,
    },
    /// Two modes with the same frequency: only their sum is visible in one displacement.
    #[error(
        "modes {first} and {second} have the same natural frequency {frequency_hz} Hz; one displacement cannot separate them, merge them into one mode"
    )]
    EqualFrequencies {
        /// Mode number, from 1.
        first: usize,
        /// Mode number, from 1.
        second: usize,
        /// The common frequency in Hz.
        frequency_hz: f64,
    },
    /// The mode does not appear in the measured displacement.
    #[error(
        "mode {mode} ({frequency_hz} Hz) has tip value 0: it is not visible in the tip displacement (unobservable); leave it out or measure elsewhere"
    )]
    UnobservableMode {
        /// Mode number, from 1.
        mode: usize,
        /// Its natural frequency in Hz.
        frequency_hz: f64,
    },
    /// Poles for a sensor elsewhere than where the force acts.
    #[error(
        "the pole observer is placed by the transmission zeros of a sensor where the force acts, and the sensor looks elsewhere; use the smoother (--method kalman or stick-slip)"
    )]
    PolesElsewhere,
    /// A sensor that sees no mode.
    #[error(
        "where the sensor looks, none of the {count} modes moves (all its mode ratios are 0); measure elsewhere, away from the clamp"
    )]
    BlindSensor {
        /// Number of modes.
        count: usize,
    },
    /// The sampling frequency is too low for the highest mode.
    #[error(
        "sampling at {sample_rate_hz:.1} Hz is too slow for mode {mode} at {frequency_hz} Hz; sample at {needed_hz:.1} Hz or more, or leave the mode out"
    )]
    SamplingTooSlow {
        /// Sampling frequency in Hz.
        sample_rate_hz: f64,
        /// Mode number, from 1.
        mode: usize,
        /// Its natural frequency in Hz.
        frequency_hz: f64,
        /// Least usable sampling frequency in Hz.
        needed_hz: f64,
    },
    /// The sample interval is not a positive number.
    #[error("sample interval {value} s is not a positive number; check the time column")]
    BadSampleInterval {
        /// Value found in s.
        value: f64,
    },
    /// Too few samples.
    #[error(
        "the record has {found} usable samples, at least {needed} are needed; record longer or close the gaps"
    )]
    TooFewSamples {
        /// Number of finite samples.
        found: usize,
        /// Least number.
        needed: usize,
    },
    /// The displacement is infinite somewhere (missing samples are NaN).
    #[error(
        "displacement sample {index} (t = {time_s} s) is infinite; mark a missing sample as empty or NaN"
    )]
    InfiniteSample {
        /// Sample number, from 0.
        index: usize,
        /// Its time in s.
        time_s: f64,
    },
    /// Most of the record lies at an end of the sensor's range.
    #[error(
        "{clipped} of {count} samples are clipped at {low} or {high} {unit}: the signal is saturated, the force cannot be observed; enlarge the sensor's range or move the sensor"
    )]
    Saturated {
        /// Number of clipped samples.
        clipped: usize,
        /// Number of samples.
        count: usize,
        /// Smallest value.
        low: f64,
        /// Largest value.
        high: f64,
        /// Their unit.
        unit: &'static str,
    },
    /// What was measured does not move.
    #[error(
        "the signal is {value} in its SI unit in all {count} samples; there is nothing to observe, check the sensor channel"
    )]
    ConstantSignal {
        /// The constant value in m, m/s or m/s^2.
        value: f64,
        /// Number of samples.
        count: usize,
    },
    /// The time column does not rise.
    #[error(
        "time goes from {before_s} s to {after_s} s at sample {index}: it must rise; sort the record"
    )]
    TimeNotRising {
        /// Sample number, from 0.
        index: usize,
        /// Time before in s.
        before_s: f64,
        /// Time after in s.
        after_s: f64,
    },
    /// The sampling is not uniform, and not uniform with gaps either.
    #[error(
        "sample {index} at t = {time_s} s lies {share:.2} sample intervals off a uniform grid of {interval_s} s; resample the record uniformly before observing"
    )]
    UnevenSampling {
        /// Sample number, from 0.
        index: usize,
        /// Its time in s.
        time_s: f64,
        /// Distance from the grid as share of the interval.
        share: f64,
        /// Grid interval in s.
        interval_s: f64,
    },
    /// Two columns that belong together have different lengths.
    #[error(
        "{what} has {found} values but the record has {expected} samples; give one value per sample"
    )]
    LengthMismatch {
        /// Name of the column.
        what: &'static str,
        /// Length of the record.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// A setting outside its range.
    #[error("setting {name} = {value} {unit} is not usable ({rule})")]
    BadSetting {
        /// Name of the setting.
        name: &'static str,
        /// Value found.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// The rule it violates.
        rule: &'static str,
    },
    /// An observer pole in the right half plane or on its border.
    #[error(
        "observer pole {index} = {real_per_s} {imaginary_per_s:+}j 1/s is not in the open left half plane, the observer would not converge; give it a negative real part"
    )]
    UnstablePole {
        /// Number of the pole, from 1.
        index: usize,
        /// Real part in 1/s.
        real_per_s: f64,
        /// Imaginary part in 1/s.
        imaginary_per_s: f64,
    },
    /// Wrong number of poles.
    #[error(
        "{found} observer poles given, {needed} are needed (two per mode and one for the force)"
    )]
    PoleCount {
        /// Number needed.
        needed: usize,
        /// Number given.
        found: usize,
    },
    /// A complex pole without its conjugate.
    #[error(
        "observer pole {real_per_s} {imaginary_per_s:+}j 1/s has no complex conjugate among the poles; the gain would not be real, add the conjugate"
    )]
    UnpairedPole {
        /// Real part in 1/s.
        real_per_s: f64,
        /// Imaginary part in 1/s.
        imaginary_per_s: f64,
    },
    /// No part of the record is of the kind needed.
    #[error("{what} cannot be estimated: {found} {unit} found, {needed} needed; {action}")]
    TooFewEvents {
        /// What was asked for.
        what: &'static str,
        /// Number found.
        found: usize,
        /// Number needed.
        needed: usize,
        /// Of what.
        unit: &'static str,
        /// What to do.
        action: &'static str,
    },
}

//! What can be wrong with a series or a setting, and what to do about it.

use thiserror::Error;

/// A series or a setting that has no correlation dimension.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DimensionError {
    /// Too few samples for the embedding asked for.
    #[error(
        "{samples} samples are too few for embedding dimension {dimension} at delay {delay} and Theiler window {theiler}: at least {needed} are \
         needed; record longer, or choose a smaller dimension or delay"
    )]
    TooFewSamples {
        /// Samples there are.
        samples: usize,
        /// Largest embedding dimension.
        dimension: usize,
        /// Delay in samples.
        delay: usize,
        /// Theiler window in samples.
        theiler: usize,
        /// Samples needed.
        needed: usize,
    },
    /// All samples are equal.
    #[error(
        "all {samples} samples are {value}: a series that does not move has no dimension; check the column"
    )]
    Constant {
        /// Number of samples.
        samples: usize,
        /// Their value.
        value: f64,
    },
    /// An infinite sample.
    #[error("sample {index} is infinite; a missing sample is NaN, repair or delete this one")]
    Infinite {
        /// Number of the sample, from 0.
        index: usize,
    },
    /// Hardly any two neighbouring samples are there.
    #[error(
        "{missing} of {samples} samples are missing and the longest unbroken part has {longest}; at least {needed} in a row are needed, fill the gaps or \
         record again"
    )]
    TooManyGaps {
        /// Number of samples.
        samples: usize,
        /// Missing ones.
        missing: usize,
        /// Samples of the longest part without a gap.
        longest: usize,
        /// Samples needed.
        needed: usize,
    },
    /// A setting outside its range.
    #[error("{name} = {value} is not possible: {rule}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// The value found.
        value: String,
        /// What is allowed, and what to do.
        rule: String,
    },
    /// Stopped from outside before there was a result.
    #[error("stopped while {what}; nothing was written")]
    Stopped {
        /// What was being done.
        what: &'static str,
    },
}

//! The thresholds of a diagnosis, each with its reason.

/// A hypothesis explains the data if the median error is at most this many times the noise, ...
pub const FLOOR_MEDIAN: f64 = 1.12;

/// ... and so is the error of three segments in four.
pub const FLOOR_QUARTILE: f64 = 1.45;

/// ..., and no more segments are lost than by chance, of a run or of all, each with this probability: true models lost 1 of 920 segments
/// fitted and 1 of 239 kept out, on eleven campaigns (docs/adr/0066-what-acts-at-times.md). A run is an experiment of its own, and what acts
/// at times, such as a stop that the motion reaches at resonance, shows in a few segments.
pub const LOST_BY_CHANCE: f64 = 0.01;

/// Probability below which chance does not count as the reason.
pub const UNLIKELY: f64 = 1e-3;

/// A segment whose error is more than this many times the noise is lost, as no chance explains: of 30 samples noise alone makes 1.0 with a
/// standard deviation of 0.13.
pub const LOST: f64 = 3.0;

/// ...; and what is left is white, the power of its low frequencies at most this many times that of its high ones. True
/// models leave 0.85 to 1.0, a cubic stiffness fitted to a quadratic one down to 1.03 times the noise 1.44.
pub const MOST_SPECTRAL_RATIO: f64 = 1.2;

/// Hypotheses whose posterior on the segments compared is within this of the best, nats, are compared on all segments: the evidence
/// grows with the data, and all segments and samples are up to six times those compared.
pub const CLOSE: f64 = 10.0;

/// At most so many: each costs a fit to all segments.
pub const FINALISTS: usize = 4;

/// Each effect more is so many times less probable: of campaigns that need any, most need one.
pub const SECOND: f64 = 10.0;

/// Odds over a simpler hypothesis with which an effect is named: strong evidence (Jeffreys, Theory of Probability, 1961,
/// appendix B). A name that is wrong does more harm than one that is missing.
pub const CLAIMED: f64 = 10.0;

/// Hypotheses less than 20 times less probable than the best can't be told from it: the usual 5 %.
pub const TIE: f64 = 3.0;

/// Probability that nothing known is missing where no hypothesis is adequate: of 42 such verdicts of the blind test 33 were
/// right, the others a search that had missed a pair (docs/blind-test.md).
pub const SEARCHED: f64 = 0.79;

/// Scale of a start state in the evidence, in units of the sensor's noise; the same for every model, so that it cancels but
/// for what a model has more.
pub const STATE_SPREAD: f64 = 10.0;

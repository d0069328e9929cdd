//! Where a deviation becomes a finding. Rigs deviate: belt speeds by 2 %, forces by 5 %, natural
//! frequencies by 0.5 %, friction by tens of percent. An error is a value that can't be meant, far
//! beyond all of these.

/// A stick speed this many times the stated belt speed, or its inverse, is an error: no drive is
/// off by a factor of 2, and units err by 9.8, 25.4, 1000.
pub const SPEED_FACTOR: f64 = 2.0;
/// A stick speed off by this share of the stated belt speed is a warning: five times what belts
/// deviate.
pub const SPEED_OFF: f64 = 0.1;
/// A factor explains a deviation if it leaves less than this share of it: twice what a belt and a
/// sensor's gain err together.
pub const FACTOR_FITS: f64 = 0.2;
/// Two speeds are the same within this share: beyond what belts deviate from run to run, below what
/// operating points differ.
pub const SAME_SPEED: f64 = 0.04;
/// A stick speed below this share of the fastest speed, or a plateau whose band is wider than this
/// share of it, tells nothing: the tip creeps, or noise hides the speed.
pub const LEAST_SPEED: f64 = 0.02;
/// Widest half band of a stick speed as a share of it.
pub const WIDEST_BAND: f64 = 0.3;
/// Fastest speed over the belt's where no stick is seen: without stick the tip seldom overtakes the
/// belt, with modes of little mass it falls back up to 20 times as fast; a slow belt and long slips
/// reach 140.
pub const SPEEDS: std::ops::Range<f64> = 0.01..300.0;
/// The force that bends the tip over its range, over the normal force: friction turns from +mu to
/// -mu at most, rubber on dry asphalt reaches mu = 2, and a stiffness from stated modes may be off
/// by a factor of 2.
pub const LEAST_FRICTION: f64 = 8.0;
/// The same ratio is this small only if the force is stated far too large or the displacement far
/// too small.
pub const LEAST_RANGE: f64 = 2e-3;
/// A mean coefficient of friction below is that of no dry contact: PTFE on steel has 0.04 (Bowden and Tabor, The Friction and Lubrication
/// of Solids, 1950).
pub const LOWEST_FRICTION: f64 = 0.04;
/// Share of stick from which the motion in slip tells the frequency: with less, the second mode
/// rules the slips.
pub const STICK_FOR_FREQUENCY: f64 = 0.3;
/// That frequency over the lowest natural frequency on 110 campaigns with known ones: 0.76 to 0.90,
/// friction's dependence on speed lowers it.
pub const SLIP_FREQUENCY: f64 = 0.85;
/// The same for a single run: 0.53 to 0.96 there, with as much room as a confusion by a factor of
/// 1000 leaves.
pub const FREQUENCIES: std::ops::Range<f64> = 0.05..20.0;
/// Share of the samples at which a signal rests that is a velocity (at the belt's) or an
/// acceleration (at zero).
pub const REST_SHARE: f64 = 0.1;
/// A natural frequency from the motion off by this factor from the stated one can't be meant: it is
/// found to 15 %, and confusions err by 2 or `2 pi`.
pub const FREQUENCY_FACTOR: f64 = 1.5;
/// The frequency of a free swing is a confusion's if within this factor of it: the line of a record of [`FREE_SWINGS`] cycles is that narrow.
pub const FREE_FREQUENCY: f64 = 1.1;
/// Fewest cycles of a free swing for a frequency to a tenth.
pub const FREE_SWINGS: usize = 10;
/// A swing's line with its skirts lies within this factor, as far as a spring of a free swing hardens or softens.
pub const SWINGS_BAND: f64 = 1.2;
/// A stated frequency has a line of its own if that is this share of the highest: harmonics of a bent spring are smaller.
pub const OWN_LINE: f64 = 0.1;
/// Median amplitude of a line of white noise of standard deviation 1 over `sqrt(n)`: `4 sqrt(3/8)` of the Hann window, 0.83 of the
/// Rayleigh distribution.
pub const LINE_NOISE: f64 = 2.0;
/// A line this many times that of noise is a signal's: noise reaches it once in 10^30 lines.
pub const SEEN_LINE: f64 = 10.0;
/// A response to the recorded drive that is this many times what was expected, or a share of it, is a warning: masses are stated to tens of
/// percent, a stop or a strong spring changes a response by a factor of 2 to 3.
pub const RESPONSE_OFF: f64 = 6.0;
/// A response so many times too large is an error: only units err so far. One too small may be held by friction.
pub const RESPONSE_FACTOR: f64 = 50.0;
/// A line is driven from this share of the highest one on.
pub const DRIVEN_LINES: f64 = 0.1;
/// Fewest driven lines: the median of these feels no single resonance.
pub const FEWEST_LINES: usize = 5;
/// Least share of the drive that the window of a spectrum shows, over that of an even one: it hides a blow at the start and not what rings.
pub const WINDOWED: f64 = 0.5;
/// Fewest samples in a period of the lowest mode: below, not even its turning points are seen.
pub const SAMPLES_PER_PERIOD: f64 = 4.0;
/// Fewest samples in a period of any stated mode, for a warning: the sampling theorem asks for 2,
/// filters need more.
pub const SAMPLES_PER_FASTEST: f64 = 2.5;
/// Share of clipped samples that is an error: the motion's turning points are lost, with them
/// amplitude and balance.
pub const CLIPPED_ERROR: f64 = 0.1;
/// Share of clipped or held samples that is a warning; they are left out, which costs their share
/// of the data.
pub const FAULTY_WARNING: f64 = 0.01;
/// Jitter of the sample interval that is a warning: beyond, the noise is overestimated.
pub const JITTER: f64 = 0.05;
/// Share of missing samples that is a warning.
pub const MISSING: f64 = 0.1;
/// A trend over the run, as a share of the motion's range, that is a warning: friction that drifts
/// by a third moves the mean by less.
pub const DRIFT: f64 = 0.5;
/// A motion whose standard deviation is less than this many times the noise is a warning: no cycle
/// can be told.
pub const NO_MOTION: f64 = 3.0;

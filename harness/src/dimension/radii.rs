//! The radii of a correlation sum: four per octave, on values that need no logarithm.

/// Bits of the mantissa below the two that a radius keeps.
const MANTISSA: u32 = 50;

/// Rising radii `r = 2^e (1 + j/4)`, j = 0..3: nearly logarithmic, and exact.
///
/// A distance falls between two such radii by the leading bits of its own binary form, so that a bin costs a subtraction
/// and a shift. `spread` is 1 where the sums count distances, 2 where they count squares of distances: then two squares
/// per octave of the square give four radii per octave of the radius again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radii {
    lowest: u64,
    count: usize,
    squared: bool,
}

impl Radii {
    /// The largest number: a bin is one byte.
    pub const MOST: usize = 200;

    /// `count` radii, the largest the first of the grid that is not below `largest`.
    ///
    /// With `squared` the grid is one of squares of distances, for the Euclidean norm.
    pub fn up_to(largest: f64, count: usize, squared: bool) -> Radii {
        let count = count.clamp(2, Radii::MOST);
        let measure = if squared { largest * largest } else { largest };
        let step = Radii::step_of(squared);
        // The smallest positive normal number keeps the grid away from zero.
        let bits = measure.max(f64::MIN_POSITIVE).to_bits();
        let top = bits.div_ceil(step) * step;
        let top = top.max(count as u64 * step + f64::MIN_POSITIVE.to_bits());
        Radii {
            lowest: top - (count as u64 - 1) * step,
            count,
            squared,
        }
    }

    fn step_of(squared: bool) -> u64 {
        1 << (MANTISSA + u32::from(squared))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// What distances (or their squares) are compared with.
    pub fn thresholds(&self) -> Vec<f64> {
        let step = Radii::step_of(self.squared);
        let at = |k: usize| f64::from_bits(self.lowest + k as u64 * step);
        (0..self.count).map(at).collect()
    }

    /// The radii, in the unit of the series.
    pub fn values(&self) -> Vec<f64> {
        let root = |v: f64| if self.squared { v.sqrt() } else { v };
        self.thresholds().into_iter().map(root).collect()
    }

    /// The constants of the bins.
    pub(super) fn bins(&self) -> Bins {
        let step = Radii::step_of(self.squared);
        Bins {
            low: f64::from_bits(self.lowest),
            past: f64::from_bits(self.lowest + self.count as u64 * step),
            // One less than a step: a distance equal to a radius lies within it.
            key: self.lowest + 1 - step,
        }
    }
}

/// Turns a distance into the number of the first radius that holds it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bins {
    low: f64,
    past: f64,
    key: u64,
}

impl Bins {
    /// Bin of a distance (of its square with `SQUARED`); what is not a number lies past the last radius.
    #[inline(always)]
    pub fn of<const SQUARED: bool>(&self, distance: f64) -> u8 {
        // Comparisons this way round send NaN to `past`, and are one machine instruction each.
        let d = if distance < self.past {
            distance
        } else {
            self.past
        };
        let d = if d > self.low { d } else { self.low };
        (d.to_bits().wrapping_sub(self.key) >> (MANTISSA + SQUARED as u32)) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bin_is_the_first_radius_that_holds_the_distance() {
        for squared in [false, true] {
            let radii = Radii::up_to(3.7, 30, squared);
            let thresholds = radii.thresholds();
            assert!(*radii.values().last().unwrap() >= 3.7);
            let bins = radii.bins();
            let bin = |d: f64| match squared {
                true => bins.of::<true>(d),
                false => bins.of::<false>(d),
            };
            for (k, t) in thresholds.iter().enumerate() {
                assert_eq!(bin(*t), k as u8, "a radius holds itself");
                assert_eq!(bin(t.next_up()), k as u8 + 1);
                assert_eq!(bin(t.next_down()), k as u8);
            }
            assert_eq!(bin(0.0), 0);
            assert_eq!(bin(1e300), 30);
            assert_eq!(bin(f64::NAN), 30);
        }
    }

    #[test]
    fn four_radii_to_an_octave() {
        for squared in [false, true] {
            let r = Radii::up_to(1.0, 9, squared).values();
            let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
            assert!(
                near(r[8], 1.0) && near(r[4], 0.5) && near(r[0], 0.25),
                "{r:?}"
            );
        }
    }
}

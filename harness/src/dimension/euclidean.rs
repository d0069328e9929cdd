//! Pairs at one lag, Euclidean norm.
//!
//! Squares of differences are computed once per lag and added up dimension by dimension, in the order in which a plain double
//! loop adds them, so that the sums, and with them the counts, are the same to the last bit.

use multiversion::multiversion;

use super::radii::{Bins, Radii};

/// Pairs worked on together; their squares stay in the nearest cache.
const BLOCK: usize = 1024;
/// Histograms that take turns: the same bin twice in a row would have to wait for itself.
const TURNS: usize = 4;

/// Rooms that a thread uses for all its lags.
pub(super) struct SquareCounter {
    bins: Bins,
    radii: usize,
    delay: usize,
    dimensions: usize,
    squares: Vec<f64>,
    /// Per dimension, the histograms side by side.
    histograms: Vec<[[u64; 256]; TURNS]>,
}

impl SquareCounter {
    pub fn new(radii: &Radii, delay: usize, dimensions: usize) -> SquareCounter {
        SquareCounter {
            bins: radii.bins(),
            radii: radii.count(),
            delay,
            dimensions,
            squares: vec![0.0; BLOCK + (dimensions - 1) * delay],
            histograms: vec![[[0; 256]; TURNS]; dimensions],
        }
    }

    /// Adds the pairs (`a[i]`, `b[i]`), i < `anchors`. Both series have NaN behind their ends.
    pub fn add(&mut self, a: &[f64], b: &[f64], anchors: usize) {
        widest(self, a, b, anchors);
    }

    /// Pairs so far within radius `r` (from 0) at dimension `m` (from 1): entry `r dimensions + m - 1`.
    pub fn counts(&self) -> Vec<u64> {
        let mut out = vec![0; self.radii * self.dimensions];
        for (m, histograms) in self.histograms.iter().enumerate() {
            let mut sum = 0;
            for r in 0..self.radii {
                sum += histograms.iter().map(|h| h[r]).sum::<u64>();
                out[r * self.dimensions + m] = sum;
            }
        }
        out
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx512dq+avx2+bmi2+popcnt",
    "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
))]
fn widest(counter: &mut SquareCounter, a: &[f64], b: &[f64], anchors: usize) {
    let (delay, bins) = (counter.delay, counter.bins);
    let ahead = (counter.dimensions - 1) * delay;
    let mut sums = [0.0; BLOCK];
    let mut binned = [0; BLOCK];
    for from in (0..anchors).step_by(BLOCK) {
        let count = BLOCK.min(anchors - from);
        let wanted = (count + ahead).min(a.len() - from).min(b.len() - from);
        let squares = &mut counter.squares[..];
        for ((s, a), b) in squares
            .iter_mut()
            .zip(&a[from..from + wanted])
            .zip(&b[from..])
        {
            let d = a - b;
            *s = d * d;
        }
        squares[wanted..].fill(f64::NAN);
        sums[..count].copy_from_slice(&squares[..count]);
        for m in 0..counter.dimensions {
            if m > 0 {
                for (s, e) in sums[..count].iter_mut().zip(&squares[m * delay..]) {
                    *s += e;
                }
            }
            for (bin, s) in binned.iter_mut().zip(&sums[..count]) {
                *bin = bins.of::<true>(*s);
            }
            let histograms = &mut counter.histograms[m];
            let mut turns = binned[..count].chunks_exact(TURNS);
            for four in &mut turns {
                for (histogram, bin) in histograms.iter_mut().zip(four) {
                    histogram[usize::from(*bin)] += 1;
                }
            }
            for bin in turns.remainder() {
                histograms[0][usize::from(*bin)] += 1;
            }
        }
    }
}

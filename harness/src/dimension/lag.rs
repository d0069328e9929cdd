//! Pairs at one lag, maximum norm: how many of them lie within each radius, for every embedding dimension at once.
//!
//! The maximum norm commutes with the binning of distances: two delay vectors lie within r if every single difference
//! `|x_(i+l d) - x_(j+l d)|` does. So at one lag `k = j - i` each difference is binned once (one byte), each radius gets one bitmap
//! over i, and the count for dimension m is the number of ones in
//!
//! ```text
//! B_r(i) & B_r(i + d) & ... & B_r(i + (m-1) d)
//! ```
//!
//! The i of one lag are cut into eight planes, and bit c of byte w belongs to i = c P + w. A shift by the delay is then one by
//! whole bytes, for every delay, and the loops are plain enough for the compiler to put 64 bytes into one register. Ancestor:
//! Toledo, Toledo, Merino and Otero, Phys. Lett. A 229 (1997) 375, who vectorised over all pairs.

use multiversion::multiversion;

use super::radii::{Bins, Radii};

/// Bits of a byte: the planes that the indices of one lag are cut into.
const PLANES: usize = 8;
/// Bytes of one step: the width of the widest register.
const STEP: usize = 64;
/// Bytes of one block, whose bitmaps for all radii stay in the nearest cache.
const BLOCK: usize = 512;
/// Dimensions (bit m for m + 1) after which it is looked whether any pair is left: after each costs more than it saves.
const LOOK: u128 = 0b1000_1000_1000_1000_1000_1001_0001_0001;

type Word = [u64; STEP / 8];

/// Rooms that a thread uses for all its lags.
pub(super) struct LagCounter {
    bins: Bins,
    radii: usize,
    delay: usize,
    dimensions: usize,
    /// Bytes that the last dimension looks ahead.
    halo: usize,
    stride: usize,
    rows: Vec<u8>,
    counts: Vec<Word>,
}

/// Which machine instructions: the widest there are, or those of every machine, to compare with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instructions {
    /// AVX-512, AVX2 or those of the build, whatever the machine has.
    Widest,
    /// AVX2 at most.
    Avx2,
    /// Those the program was built for.
    Build,
}

impl LagCounter {
    /// Samples of NaN that have to follow the last one of a series.
    pub fn padding(delay: usize, dimensions: usize) -> usize {
        (dimensions - 1) * delay + (PLANES + 2) * STEP
    }

    pub fn new(radii: &Radii, delay: usize, dimensions: usize) -> LagCounter {
        let halo = (dimensions - 1) * delay;
        let stride = BLOCK + halo + 2 * STEP;
        LagCounter {
            bins: radii.bins(),
            radii: radii.count(),
            delay,
            dimensions,
            halo,
            stride,
            rows: vec![0; radii.count() * stride],
            counts: vec![[0; STEP / 8]; radii.count() * dimensions],
        }
    }

    /// Adds the pairs (`a[i]`, `b[i]`), i < `anchors`. Both series have NaN behind their ends.
    pub fn add(&mut self, a: &[f64], b: &[f64], anchors: usize, with: Instructions) {
        match with {
            Instructions::Widest => widest(self, a, b, anchors),
            Instructions::Avx2 => avx2(self, a, b, anchors),
            Instructions::Build => run(self, a, b, anchors),
        }
    }

    /// Pairs so far within radius `r` (from 0) at dimension `m` (from 1): entry `r dimensions + m - 1`.
    pub fn counts(&self) -> impl Iterator<Item = u64> + '_ {
        self.counts.iter().map(|lanes| lanes.iter().sum())
    }

    /// Forgets all pairs.
    pub fn clear(&mut self) {
        self.counts.fill([0; STEP / 8]);
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx512dq+avx512vpopcntdq+avx512bitalg+avx2+bmi2+popcnt",
    "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt",
    "aarch64+neon"
))]
fn widest(counter: &mut LagCounter, a: &[f64], b: &[f64], anchors: usize) {
    run(counter, a, b, anchors)
}

#[multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn avx2(counter: &mut LagCounter, a: &[f64], b: &[f64], anchors: usize) {
    run(counter, a, b, anchors)
}

// Everything below is inlined into the versions above: only so does it use their instructions.

#[inline(always)]
fn run(counter: &mut LagCounter, a: &[f64], b: &[f64], anchors: usize) {
    let (radii, dimensions, halo, stride) = (
        counter.radii,
        counter.dimensions,
        counter.halo,
        counter.stride,
    );
    let (delay, bins) = (counter.delay, counter.bins);
    let plane = anchors.div_ceil(PLANES);
    let rows = &mut counter.rows[..];
    let counts = &mut counter.counts[..];
    // `filled` bytes of every row are valid, from the plane's byte `done` on.
    let (mut done, mut filled) = (0, 0);
    while done < plane {
        let block = BLOCK.min(plane - done);
        while filled < block + halo {
            let mut binned = [[0; STEP]; PLANES];
            for c in 0..PLANES {
                let at = c * plane + done + filled;
                // Past the padding nothing is left to count.
                if at + STEP <= b.len() && at + STEP <= a.len() {
                    differences(&a[at..at + STEP], &b[at..at + STEP], &bins, &mut binned[c]);
                } else {
                    binned[c] = [u8::MAX; STEP];
                }
            }
            bitmaps(&binned, &mut rows[filled..], stride, radii);
            filled += STEP;
        }
        // Behind the last byte of a plane the next plane begins: those bytes are looked at, but not counted.
        let rest = first_bytes(block % STEP);
        // Nothing lies within a smaller radius that does not lie within a larger one: fewer and fewer dimensions are left.
        let mut alive = dimensions;
        for r in (0..radii).rev() {
            let row = &rows[r * stride..(r + 1) * stride];
            let counts = &mut counts[r * dimensions..(r + 1) * dimensions];
            let (mut most, mut at) = (0, 0);
            while at + 8 * STEP <= block {
                most = most.max(ones::<8>(&row[at..], &ALL, delay, alive, counts));
                at += 8 * STEP;
            }
            while at + 2 * STEP <= block {
                most = most.max(ones::<2>(&row[at..], &ALL, delay, alive, counts));
                at += 2 * STEP;
            }
            while at + STEP <= block {
                most = most.max(ones::<1>(&row[at..], &ALL, delay, alive, counts));
                at += STEP;
            }
            if at < block {
                most = most.max(ones::<1>(&row[at..], &rest, delay, alive, counts));
            }
            alive = most;
            if alive == 0 {
                break;
            }
        }
        done += block;
        if done < plane {
            for r in 0..radii {
                rows.copy_within(r * stride + block..r * stride + filled, r * stride);
            }
            filled -= block;
        }
    }
}

const ALL: Word = [u64::MAX; STEP / 8];

/// Ones in the first `count` bytes.
#[inline(always)]
fn first_bytes(count: usize) -> Word {
    std::array::from_fn(|lane| match count.saturating_sub(8 * lane) {
        0 => 0,
        bytes if bytes < 8 => (1 << (8 * bytes)) - 1,
        _ => u64::MAX,
    })
}

#[inline(always)]
fn differences(a: &[f64], b: &[f64], bins: &Bins, out: &mut [u8; STEP]) {
    let (a, b) = (&a[..STEP], &b[..STEP]);
    for i in 0..STEP {
        out[i] = bins.of::<false>((a[i] - b[i]).abs());
    }
}

/// For every radius, one step of its bitmap.
#[inline(always)]
fn bitmaps(binned: &[[u8; STEP]; PLANES], rows: &mut [u8], stride: usize, radii: usize) {
    for r in 0..radii {
        let limit = r as u8;
        let row = &mut rows[r * stride..r * stride + STEP];
        for i in 0..STEP {
            let mut bits = 0;
            for c in 0..PLANES {
                bits |= u8::from(binned[c][i] <= limit) << c;
            }
            row[i] = bits;
        }
    }
}

#[inline(always)]
fn word(bytes: &[u8]) -> Word {
    let bytes = &bytes[..STEP];
    std::array::from_fn(|i| u64::from_le_bytes(std::array::from_fn(|j| bytes[8 * i + j])))
}

/// Counts `G` steps of one bitmap; returns the number of dimensions up to which pairs were left.
#[inline(always)]
fn ones<const G: usize>(
    row: &[u8],
    counted: &Word,
    delay: usize,
    dimensions: usize,
    counts: &mut [Word],
) -> usize {
    let mut left: [Word; G] = std::array::from_fn(|g| {
        let bits = word(&row[STEP * g..]);
        std::array::from_fn(|lane| bits[lane] & counted[lane])
    });
    let mut m = 0;
    loop {
        let count = &mut counts[m];
        for bits in &left {
            for lane in 0..STEP / 8 {
                count[lane] += u64::from(bits[lane].count_ones());
            }
        }
        if LOOK >> (m % 128) & 1 == 1 {
            let mut any = [0; STEP / 8];
            for bits in &left {
                for lane in 0..STEP / 8 {
                    any[lane] |= bits[lane];
                }
            }
            if any.iter().fold(0, |all, lane| all | lane) == 0 {
                return m;
            }
        }
        m += 1;
        if m == dimensions {
            return m;
        }
        let later = &row[m * delay..m * delay + STEP * G];
        for (g, bits) in left.iter_mut().enumerate() {
            let next = word(&later[STEP * g..]);
            for lane in 0..STEP / 8 {
                bits[lane] &= next[lane];
            }
        }
    }
}

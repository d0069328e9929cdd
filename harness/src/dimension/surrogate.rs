//! Surrogate series: what noise with the same spectrum and the same values would show.

use realfft::RealFftPlanner;

/// Rounds of the iteration; it comes to rest long before in most cases.
const ROUNDS: usize = 100;
/// Share of the series that may be cut off at either end to make the ends fit.
const CUT: f64 = 0.02;

/// The part of a series without missing samples that is longest.
pub(super) fn longest_unbroken(series: &[f64]) -> std::ops::Range<usize> {
    let (mut best, mut start) = (0..0, 0);
    for i in 0..=series.len() {
        if i == series.len() || !series[i].is_finite() {
            if i - start > best.len() {
                best = start..i;
            }
            start = i + 1;
        }
    }
    best
}

/// A part whose ends fit together in value and slope: a Fourier transform takes the series for periodic, and a jump
/// would become noise in every surrogate.
///
/// Source: Schreiber and Schmitz, Physica D 142 (2000) 346, section 4.6.
pub(super) fn ends_that_fit(series: &[f64]) -> &[f64] {
    let n = series.len();
    let most = ((CUT * n as f64) as usize).min(200);
    if n < 16 {
        return series;
    }
    let mismatch = |from: usize, to: usize| {
        let jump = series[to - 1] - series[from];
        let bend = (series[to - 1] - series[to - 2]) - (series[from + 1] - series[from]);
        jump * jump + bend * bend
    };
    let mut best = (0, n, mismatch(0, n));
    for from in 0..=most {
        for to in n - most..=n {
            let m = mismatch(from, to);
            if m < best.2 {
                best = (from, to, m);
            }
        }
    }
    &series[best.0..best.1]
}

/// A surrogate by iterated amplitude-adjusted Fourier transform.
///
/// Two steps take turns: the amplitudes of the spectrum are set to those of the series; the values are set, by rank, to those
/// of the series. The result has exactly the values of the series and nearly its spectrum, and is else random. It stands for
/// a Gaussian linear process seen through a monotone function.
///
/// Source: Schreiber and Schmitz, Phys. Rev. Lett. 77 (1996) 635; Physica D 142 (2000) 346, section 4.3.
pub fn iaaft(series: &[f64], seed: u64) -> Vec<f64> {
    let n = series.len();
    let mut random = fastrand::Rng::with_seed(seed);
    let mut sorted = series.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, back) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
    let mut spectrum = forward.make_output_vec();
    let fits = "the buffers have the planned sizes";
    let mut room = series.to_vec();
    forward.process(&mut room, &mut spectrum).expect(fits);
    let amplitudes: Vec<f64> = spectrum.iter().map(|s| s.norm()).collect();
    let mut current = series.to_vec();
    random.shuffle(&mut current);
    let mut order: Vec<u32> = (0..n as u32).collect();
    for _ in 0..ROUNDS {
        room.copy_from_slice(&current);
        forward.process(&mut room, &mut spectrum).expect(fits);
        for (s, a) in spectrum.iter_mut().zip(&amplitudes) {
            let size = s.norm();
            *s = if size > 0.0 {
                *s * (a / size)
            } else {
                (*a).into()
            };
        }
        // A real signal has real first and (n even) last coefficients.
        spectrum[0].im = 0.0;
        if n.is_multiple_of(2) {
            spectrum[n / 2].im = 0.0;
        }
        back.process(&mut spectrum, &mut room).expect(fits);
        // The order of the round before is nearly right, which a merging sort makes use of.
        order.sort_by(|a, b| room[*a as usize].total_cmp(&room[*b as usize]));
        let mut moved = false;
        for (rank, i) in order.iter().enumerate() {
            let value = sorted[rank];
            moved |= current[*i as usize] != value;
            current[*i as usize] = value;
        }
        if !moved {
            break;
        }
    }
    current
}

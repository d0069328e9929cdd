//! Series of known dimension, for tests and benchmarks.
#![allow(dead_code)]

use std::f64::consts::TAU;

/// A flow sampled by the classic Runge-Kutta method.
pub fn flow<const S: usize>(
    rates: impl Fn(&[f64; S]) -> [f64; S],
    start: [f64; S],
    interval: f64,
    inner: usize,
    count: usize,
) -> Vec<[f64; S]> {
    let h = interval / inner as f64;
    let mut x = start;
    let mut out = Vec::with_capacity(count);
    let along = |x: &[f64; S], k: &[f64; S], h: f64| -> [f64; S] {
        std::array::from_fn(|i| x[i] + h * k[i])
    };
    let settle = 2000;
    for sample in 0..count + settle {
        if sample >= settle {
            out.push(x);
        }
        for _ in 0..inner {
            let k1 = rates(&x);
            let k2 = rates(&along(&x, &k1, h / 2.0));
            let k3 = rates(&along(&x, &k2, h / 2.0));
            let k4 = rates(&along(&x, &k3, h));
            x = std::array::from_fn(|i| {
                x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            });
        }
    }
    out
}

fn first<const S: usize>(states: Vec<[f64; S]>) -> Vec<f64> {
    states.iter().map(|s| s[0]).collect()
}

fn lorenz_rates(x: &[f64; 3]) -> [f64; 3] {
    [
        10.0 * (x[1] - x[0]),
        x[0] * (28.0 - x[2]) - x[1],
        x[0] * x[1] - 8.0 / 3.0 * x[2],
    ]
}

/// Lorenz 1963, x, sampled every `interval`; seeds give independent starts.
pub fn lorenz(seed: u64, interval: f64, count: usize) -> Vec<f64> {
    let start = [1.0 + 0.37 * seed as f64, 1.0, 20.0 + 0.11 * seed as f64];
    first(flow(lorenz_rates, start, interval, 4, count))
}

/// Roessler, x.
pub fn roessler(a: f64, b: f64, c: f64, interval: f64, count: usize) -> Vec<f64> {
    let rates = |x: &[f64; 3]| [-x[1] - x[2], x[0] + a * x[1], b + x[2] * (x[0] - c)];
    first(flow(rates, [1.0, 1.0, 0.0], interval, 10, count))
}

/// Henon 1976, x.
pub fn henon(seed: u64, count: usize) -> Vec<f64> {
    let (mut x, mut y) = (0.1 + 1e-3 * seed as f64, 0.1);
    map(count, || {
        (x, y) = (1.0 - 1.4 * x * x + y, 0.3 * x);
        x
    })
}

/// Ikeda's map (0.4, 6, 0.9), real part.
pub fn ikeda(count: usize) -> Vec<f64> {
    let (mut x, mut y) = (0.1_f64, 0.1_f64);
    map(count, || {
        let t: f64 = 0.4 - 6.0 / (1.0 + x * x + y * y);
        (x, y) = (
            1.0 + 0.9 * (x * t.cos() - y * t.sin()),
            0.9 * (x * t.sin() + y * t.cos()),
        );
        x
    })
}

/// The logistic map at r = 4, by its exact solution in an angle of 64 bits that never becomes periodic.
pub fn logistic(seed: u64, count: usize) -> Vec<f64> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut angle = random.u64(..);
    map(count, || {
        // Doubling shifts a bit out; a random one comes in.
        angle = angle << 1 | u64::from(random.bool());
        (0.5 * TAU * (angle as f64 / 2f64.powi(64))).sin().powi(2)
    })
}

fn map(count: usize, mut next: impl FnMut() -> f64) -> Vec<f64> {
    (0..500).for_each(|_| {
        next();
    });
    (0..count).map(|_| next()).collect()
}

/// Mackey-Glass (0.2, 0.1, 10), delay `tau`, sampled every `interval` by Runge-Kutta steps of 0.1.
pub fn mackey_glass(tau: f64, interval: f64, count: usize) -> Vec<f64> {
    let h = 0.1;
    let past = (tau / h).round() as usize;
    let every = (interval / h).round() as usize;
    let mut x = vec![1.2; past + 1];
    let rate = |x: f64, old: f64| 0.2 * old / (1.0 + old.powi(10)) - 0.1 * x;
    let steps = (count + 500) * every;
    for k in 0..steps {
        let (now, old, next) = (x[k + past], x[k], x[k + 1]);
        let middle = 0.5 * (old + next);
        let k1 = rate(now, old);
        let k2 = rate(now + 0.5 * h * k1, middle);
        let k3 = rate(now + 0.5 * h * k2, middle);
        let k4 = rate(now + h * k3, next);
        x.push(now + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4));
    }
    x[past + 500 * every..]
        .iter()
        .copied()
        .step_by(every)
        .take(count)
        .collect()
}

/// A sum of sines of incommensurable frequencies: a torus.
pub fn torus(frequencies: &[f64], count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| {
            let parts = frequencies.iter().enumerate();
            parts
                .map(|(j, f)| (TAU * f * i as f64 + 0.7 * j as f64).sin())
                .sum()
        })
        .collect()
}

/// Five incommensurable frequencies.
pub fn torus5(count: usize) -> Vec<f64> {
    let f = [2f64, 3.0, 5.0, 7.0, 11.0].map(|p| 0.012 * p.sqrt());
    torus(&f, count)
}

/// Two Lorenz systems and a sine: a flow of dimension 5.1.
pub fn five_dimensional(count: usize) -> Vec<f64> {
    let (a, b) = (lorenz(3, 0.02, count), lorenz(17, 0.0274, count));
    let wave = |i: usize| 8.0 * (0.1234567 * i as f64).sin();
    (0..count).map(|i| a[i] + b[i] + wave(i)).collect()
}

/// Gaussian numbers.
pub fn gaussian(seed: u64, count: usize) -> Vec<f64> {
    let mut random = fastrand::Rng::with_seed(seed);
    (0..count)
        .map(|_| (-2.0 * (1.0 - random.f64()).ln()).sqrt() * (TAU * random.f64()).cos())
        .collect()
}

/// Narrow-band noise: an autoregressive process of second order.
pub fn ar2(seed: u64, count: usize) -> Vec<f64> {
    let noise = gaussian(seed, count + 1000);
    let (r, w) = (0.98_f64, 0.15_f64);
    let (mut x, mut y) = (0.0, 0.0);
    let all: Vec<f64> = noise
        .iter()
        .map(|e| {
            (x, y) = (2.0 * r * w.cos() * x - r * r * y + e, x);
            x
        })
        .collect();
    all[1000..].to_vec()
}

/// `series` with Gaussian noise `decibel` below its standard deviation.
pub fn noisy(series: &[f64], decibel: f64, seed: u64) -> Vec<f64> {
    let n = series.len() as f64;
    let mean = series.iter().sum::<f64>() / n;
    let std = (series.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
    let size = std * 10f64.powf(-decibel / 20.0);
    let noise = gaussian(seed, series.len());
    series
        .iter()
        .zip(noise)
        .map(|(x, e)| x + size * e)
        .collect()
}

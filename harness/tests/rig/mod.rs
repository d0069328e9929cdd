//! A reference rig with known contact force, written only for the tests of the observer.
//!
//! Modal cantilever on a belt (Stelter 1992, eqs. 2-7, eq. 7 with the exponent read as |v_r|/c1),
//! classical Runge-Kutta steps with bisection on stick/slip transitions.
#![allow(dead_code)]

pub mod campaign;
pub mod runge_kutta;

/// Modal data, friction law and operating point.
#[derive(Clone)]
pub struct Rig {
    pub frequencies_hz: Vec<f64>,
    pub damping_ratios: Vec<f64>,
    pub mass_kg: f64,
    pub tip_values: Vec<f64>,
    pub normal_force: f64,
    pub belt_velocity: f64,
    pub mu_0: f64,
    pub a1: f64,
    pub v1: f64,
    pub a2: f64,
    pub c2: f64,
}

/// A simulated record, one value per sample.
pub struct Record {
    pub sample_interval: f64,
    pub displacement: Vec<f64>,
    pub velocity: Vec<f64>,
    pub acceleration: Vec<f64>,
    /// Modal displacements and velocities, mode by mode.
    pub q: Vec<Vec<f64>>,
    pub q_dot: Vec<Vec<f64>>,
    pub force: Vec<f64>,
    /// 0 stick, -1 or +1 slip of that sign.
    pub mode: Vec<i8>,
    /// Time and mode left.
    pub transitions: Vec<(f64, i8)>,
}

impl Rig {
    /// Two modes, nominal beam, 100 N, 0.10 m/s.
    pub fn default_case() -> Self {
        Self {
            frequencies_hz: vec![80.0, 510.0],
            damping_ratios: vec![0.00015, 0.00085],
            mass_kg: 0.427,
            tip_values: vec![2.0, -2.0],
            normal_force: 100.0,
            belt_velocity: 0.10,
            mu_0: 0.66,
            a1: 0.5,
            v1: 0.02,
            a2: 0.5,
            c2: 0.25,
        }
    }

    pub fn mu(&self, speed: f64) -> f64 {
        self.mu_0
            * (1.0 - self.a1 + self.a1 * (-speed / self.v1).exp())
            * (1.0 - self.a2 + self.a2 * (-self.c2 * speed).exp())
    }

    fn omega(&self, j: usize) -> f64 {
        2.0 * std::f64::consts::PI * self.frequencies_hz[j]
    }

    fn tip_velocity(&self, x: &[f64]) -> f64 {
        self.tip_values
            .iter()
            .enumerate()
            .map(|(j, phi)| phi * x[2 * j + 1])
            .sum()
    }

    fn holding_force(&self, x: &[f64]) -> f64 {
        let mut pull = 0.0;
        let mut inverse_mass = 0.0;
        for (j, phi) in self.tip_values.iter().enumerate() {
            let w = self.omega(j);
            pull += phi * (2.0 * self.damping_ratios[j] * w * x[2 * j + 1] + w * w * x[2 * j]);
            inverse_mass += phi * phi / self.mass_kg;
        }
        pull / inverse_mass
    }

    fn force(&self, x: &[f64], mode: i8) -> f64 {
        match mode {
            0 => self.holding_force(x),
            sign => {
                let along = (self.tip_velocity(x) - self.belt_velocity) * f64::from(sign);
                -self.mu(along.max(0.0)) * self.normal_force * f64::from(sign)
            }
        }
    }

    fn rates(&self, x: &[f64], mode: i8) -> Vec<f64> {
        let force = self.force(x, mode);
        let mut out = vec![0.0; x.len()];
        for (j, phi) in self.tip_values.iter().enumerate() {
            let w = self.omega(j);
            out[2 * j] = x[2 * j + 1];
            out[2 * j + 1] = phi * force / self.mass_kg
                - 2.0 * self.damping_ratios[j] * w * x[2 * j + 1]
                - w * w * x[2 * j];
        }
        out
    }

    fn step(&self, x: &[f64], mode: i8, h: f64) -> Vec<f64> {
        let along =
            |k: &[f64], f: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + f * k).collect() };
        let k1 = self.rates(x, mode);
        let k2 = self.rates(&along(&k1, 0.5 * h), mode);
        let k3 = self.rates(&along(&k2, 0.5 * h), mode);
        let k4 = self.rates(&along(&k3, h), mode);
        (0..x.len())
            .map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
            .collect()
    }

    /// Positive while the mode holds.
    fn margin(&self, x: &[f64], mode: i8) -> f64 {
        match mode {
            0 => self.mu_0 * self.normal_force - self.holding_force(x).abs(),
            sign => (self.tip_velocity(x) - self.belt_velocity) * f64::from(sign),
        }
    }

    /// Runs from rest in stick (tip moving with the belt through zero deflection); the first
    /// `skip` seconds are left out of the record.
    pub fn run(&self, skip: f64, duration: f64, rate: f64) -> Record {
        let mut x = vec![0.0; 2 * self.tip_values.len()];
        x[1] = self.belt_velocity / self.tip_values[0];
        self.run_from(x, skip, duration, rate)
    }

    /// The same from a state in stick.
    pub fn run_from(&self, x: Vec<f64>, skip: f64, duration: f64, rate: f64) -> Record {
        self.run_in(0, x, skip, duration, rate)
    }

    /// The same from a state in which the tip is slower than the belt.
    pub fn run_slipping(&self, x: Vec<f64>, duration: f64, rate: f64) -> Record {
        self.run_in(-1, x, 0.0, duration, rate)
    }

    fn run_in(&self, mut mode: i8, mut x: Vec<f64>, skip: f64, duration: f64, rate: f64) -> Record {
        let substeps = (2e5 / rate).ceil().max(1.0) as usize;
        let h = 1.0 / (rate * substeps as f64);
        let mut armed = true;
        let first = (skip * rate).round() as usize;
        let count = (duration * rate).round() as usize;
        let mut out = Record {
            sample_interval: 1.0 / rate,
            displacement: Vec::with_capacity(count),
            velocity: Vec::with_capacity(count),
            acceleration: Vec::with_capacity(count),
            q: vec![Vec::with_capacity(count); self.tip_values.len()],
            q_dot: vec![Vec::with_capacity(count); self.tip_values.len()],
            force: Vec::with_capacity(count),
            mode: Vec::with_capacity(count),
            transitions: Vec::new(),
        };
        for sample in 0..first + count {
            if sample >= first {
                let w = self
                    .tip_values
                    .iter()
                    .enumerate()
                    .map(|(j, phi)| phi * x[2 * j])
                    .sum();
                out.displacement.push(w);
                out.velocity.push(self.tip_velocity(&x));
                for j in 0..self.tip_values.len() {
                    out.q[j].push(x[2 * j]);
                    out.q_dot[j].push(x[2 * j + 1]);
                }
                let rates = self.rates(&x, mode);
                out.acceleration.push(self.tip_velocity(&rates));
                out.force.push(self.force(&x, mode));
                out.mode.push(mode);
            }
            for sub in 0..substeps {
                let mut left = h;
                for _ in 0..20 {
                    let end = self.step(&x, mode, left);
                    // Just after break-away the margin starts at zero; it counts once positive.
                    if !armed && self.margin(&end, mode) > 0.0 {
                        armed = true;
                    }
                    if !armed || self.margin(&end, mode) >= 0.0 {
                        x = end;
                        break;
                    }
                    let (mut low, mut high) = (0.0, left);
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        if self.margin(&self.step(&x, mode, middle), mode) >= 0.0 {
                            low = middle;
                        } else {
                            high = middle;
                        }
                    }
                    x = self.step(&x, mode, high);
                    left -= high;
                    let time = (sample as f64 - first as f64) / rate + (sub + 1) as f64 * h - left;
                    out.transitions.push((time, mode));
                    if mode == 0 {
                        // The force then pulls against the coming slip.
                        mode = if self.holding_force(&x) > 0.0 { -1 } else { 1 };
                        armed = false;
                    } else {
                        mode = if self.holding_force(&x).abs() <= self.mu_0 * self.normal_force {
                            0
                        } else {
                            -mode
                        };
                        armed = mode == 0;
                    }
                }
            }
        }
        out.transitions.retain(|(time, _)| *time >= 0.0);
        out
    }
}

/// Deterministic standard normal numbers (xorshift64*, Box and Muller).
pub struct Noise(u64, Option<f64>);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1, None)
    }

    pub fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        ((self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        if let Some(value) = self.1.take() {
            return value;
        }
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        let (sin, cos) = (2.0 * std::f64::consts::PI * self.uniform()).sin_cos();
        self.1 = Some(radius * sin);
        radius * cos
    }
}

/// Standard deviation.
pub fn std(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Adds white noise `decibel` below the signal's standard deviation.
pub fn noisy(signal: &[f64], decibel: f64, seed: u64) -> Vec<f64> {
    let level = std(signal) * 10_f64.powf(-decibel / 20.0);
    let mut noise = Noise::new(seed);
    signal.iter().map(|s| s + level * noise.normal()).collect()
}

/// RMS error over the standard deviation of the truth, middle 80 % of the record.
pub fn error(estimate: &[f64], truth: &[f64]) -> f64 {
    let n = truth.len();
    let middle = n / 10..n - n / 10;
    let rms = (middle
        .clone()
        .map(|k| (estimate[k] - truth[k]).powi(2))
        .sum::<f64>()
        / middle.len() as f64)
        .sqrt();
    rms / std(&truth[middle])
}

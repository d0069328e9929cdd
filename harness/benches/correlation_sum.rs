use std::time::Instant;
use stickslip::dimension::{CorrelationSum, Instructions, Norm, SumSettings};
fn lorenz(n: usize) -> Vec<f64> {
    let (mut x, mut y, mut z) = (1.0, 1.0, 20.0);
    let f = |x: f64, y: f64, z: f64| (10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z);
    let h = 0.005;
    let mut out = vec![];
    for k in 0..(n + 2000) * 4 {
        let k1 = f(x, y, z);
        let k2 = f(x + h / 2. * k1.0, y + h / 2. * k1.1, z + h / 2. * k1.2);
        let k3 = f(x + h / 2. * k2.0, y + h / 2. * k2.1, z + h / 2. * k2.2);
        let k4 = f(x + h * k3.0, y + h * k3.1, z + h * k3.2);
        x += h / 6. * (k1.0 + 2. * k2.0 + 2. * k3.0 + k4.0);
        y += h / 6. * (k1.1 + 2. * k2.1 + 2. * k3.1 + k4.1);
        z += h / 6. * (k1.2 + 2. * k2.2 + 2. * k3.2 + k4.2);
        if k % 4 == 0 && k >= 8000 {
            out.push(x);
        }
    }
    out
}
fn main() {
    for n in [15000, 50000] {
        let x = lorenz(n);
        for (instr, norm, thin, threads) in [
            (Instructions::Widest, Norm::Maximum, 1, 1),
            (Instructions::Widest, Norm::Maximum, 1, 2),
            (Instructions::Avx2, Norm::Maximum, 1, 1),
            (Instructions::Build, Norm::Maximum, 1, 1),
            (Instructions::Widest, Norm::Maximum, 8, 1),
            (Instructions::Widest, Norm::Euclidean, 1, 1),
        ] {
            let s = SumSettings {
                delay: 8,
                dimensions: 10,
                theiler: 100,
                thin,
                norm,
                radii: 40,
                threads,
                instructions: instr,
            };
            let best = (0..3)
                .map(|_| {
                    let t = Instant::now();
                    let c = CorrelationSum::count(&x, &s, &|_| true).unwrap();
                    std::hint::black_box(c);
                    t.elapsed().as_secs_f64()
                })
                .fold(f64::MAX, f64::min);
            println!("{n} {instr:?} {norm:?} thin {thin} threads {threads}: {best:.3}");
        }
    }
}

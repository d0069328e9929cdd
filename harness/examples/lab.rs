use std::path::Path;
use std::time::Instant;
use stickslip::diagnose::{candidate::candidates, fit::*, hypothesis::*, predictor::*, shot::*};
use stickslip::{fmu::Fmu, measurement::Campaign};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let fmu = Fmu::load(Path::new("/work/notes/StickSlipBeam.fmu")).unwrap();
    let catalogue = candidates(&fmu).unwrap();
    for folder in &args[1..] {
        let campaign = Campaign::load(Path::new(folder)).unwrap();
        let structure = structure(&fmu, &campaign.beam).unwrap();
        let refs = References::new(&fmu, structure.modes().len()).unwrap();
        let t0 = Instant::now();
        let smoothings: Vec<_> = campaign.runs.iter().map(|r| smooth_run(r, &structure).unwrap()).collect();
        println!("{folder} smoothing {:?}", t0.elapsed());
        let noise: Vec<f64> = campaign.runs.iter().map(|r| r.noise.std).collect();
        println!("noise {noise:?} cycles {:?}", smoothings.iter().map(|s| s.cycle).collect::<Vec<_>>());
        let mut shots = Vec::new();
        for (i, r) in campaign.runs.iter().enumerate() {
            shots.extend(cut(i, r, &smoothings[i], 0.02));
        }
        let travel: Vec<(f64, f64)> = (0..campaign.runs.len()).map(|r| shots.iter().filter(|s| s.run == r).fold((f64::MAX, f64::MIN), |a, s| (a.0.min(s.travel), a.1.max(s.travel_end)))).collect();
        println!("{} shots, {} stuck", shots.len(), shots.iter().filter(|s| s.stuck).count());
        let spread = campaign.runs.iter().map(|r| { let m = r.displacement.iter().sum::<f64>() / r.displacement.len() as f64; (r.displacement.iter().map(|d| (d - m).powi(2)).sum::<f64>() / r.displacement.len() as f64).sqrt() }).sum::<f64>() / campaign.runs.len() as f64;
        let h = Hypothesis::new(&fmu, &campaign, &catalogue, &[], &travel, spread).unwrap();
        let data = Data { shots: &shots, noise: &noise, weight: 1.0 };
        let mut p = Predictor::new(&fmu, &refs, &campaign.runs, &h).unwrap();
        let mut point = Point::centre(&h, &shots);
        for it in [0, 1, 2, 4, 8, 16] {
            let t0 = Instant::now();
            let effort = Effort { iterations: it, stride: 2, tolerance: 1e-4, knobs: true, shared: true };
            let fit = Fitter::new(&mut p, &h, &data, effort).run(point.clone());
            let mut ratio: Vec<f64> = fit.mean_square.iter().zip(&shots).map(|(m, s)| (m.sqrt() / noise[s.run])).collect();
            ratio.sort_by(f64::total_cmp);
            let q = |p: f64| ratio[((ratio.len() - 1) as f64 * p) as usize];
            println!("it {it}: Q {:.1} rms/noise quantiles 10% {:.2} 50% {:.2} 80% {:.2} 90% {:.2} max {:.2}  {:?} sims {}", fit.objective, q(0.1), q(0.5), q(0.8), q(0.9), q(1.0), t0.elapsed(), p.count);
            point = fit.point;
        }
        for (k, u) in h.shared.iter().zip(&point.shared) { print!("{} {:.6}; ", k.name, k.value(*u)); }
        println!();
        for r in 0..campaign.runs.len() { print!("level {:.4} offset {:.2e}; ", h.own[r][0].value(point.own[r][0]), point.own[r][1]); }
        println!();
    }
}

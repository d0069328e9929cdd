use std::path::Path;
use std::time::Instant;
use stickslip::diagnose::{fit::*, hypothesis::*, search::*, session::*};
use stickslip::{fmu::Fmu, measurement::Campaign};
fn quant(fit: &Fit, s: &Session, shots: &[stickslip::diagnose::shot::Shot]) -> String {
    let mut ratio: Vec<f64> = fit.mean_square.iter().zip(shots).map(|(m, sh)| m.sqrt() / s.noise[sh.run]).collect();
    ratio.sort_by(f64::total_cmp);
    let q = |p: f64| ratio[((ratio.len() - 1) as f64 * p) as usize];
    format!("Q {:8.0} [{:.2} {:.2} {:.2} {:.1}]", fit.trimmed, q(0.2), q(0.5), q(0.75), q(0.9))
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let fmu = Fmu::load(Path::new("/work/notes/StickSlipBeam.fmu")).unwrap();
    let truth: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(Path::new(&args[1]).join("truth.json")).unwrap()).unwrap();
    let all = std::env::var("ALL").is_ok();
    for n in &args[2..] {
        let campaign = Campaign::load(&Path::new(&args[1]).join(n)).unwrap();
        let s = Session::new(&fmu, &campaign).unwrap();
        let tr = truth.as_array().unwrap().iter().find(|t| t["campaign"] == n.as_str()).unwrap();
        let ids: Vec<String> = tr["effects"].as_array().unwrap().iter().map(|e| e.as_str().unwrap().to_owned()).collect();
        println!("=== {n} {ids:?} {:?} noise {:.2e}", tr["parameters"].to_string().chars().take(150).collect::<String>(), s.noise[0]);
        let shots: Vec<_> = s.fit_shots(3).iter().map(|&k| s.shots[k].clone()).collect();
        let t0 = Instant::now();
        let base = baseline(&s, &shots).unwrap();
        println!("  baseline {} {:?} {} shots", quant(&base.fit, &s, &shots), t0.elapsed(), shots.len());
        let mut list: Vec<Choice> = Vec::new();
        for (e, c) in s.catalogue.iter().enumerate() { if all || ids.contains(&c.id) { list.extend(variants(&s, e)); } }
        let t0 = Instant::now();
        let trials = parallel(&list, |c| { let t = Instant::now(); let r = search(&s, std::slice::from_ref(c), &shots, &base)?; Ok((r, t.elapsed())) }).unwrap();
        let mut order: Vec<usize> = (0..trials.len()).collect();
        order.sort_by(|&a, &b| trials[a].0.fit.trimmed.total_cmp(&trials[b].0.fit.trimmed));
        for i in order {
            let (t, time) = &trials[i];
            print!("  {:24} {} {:.1?}", s.catalogue[list[i].effect].id, quant(&t.fit, &s, &shots), time);
            for (k, u) in t.hypothesis.shared.iter().zip(&t.fit.point.shared) { if k.name.starts_with(&s.catalogue[list[i].effect].id) { print!(" {:.4e}", k.value(*u)); } }
            println!();
        }
        println!("  total {:?}", t0.elapsed());
    }
}

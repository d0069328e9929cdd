use std::path::Path;
use std::time::Instant;
use stickslip::diagnose::{judge, select::*, session::*};
use stickslip::{fmu::Fmu, measurement::Campaign};
struct Quiet(Instant);
impl Watch for Quiet { fn step(&self, w: &str, a: usize, b: usize) { if std::env::var("V").is_ok() { eprintln!("   {:.1?} {w} {a}/{b}", self.0.elapsed()); } } fn stop(&self) -> bool { false } }
fn show(s: &Session, c: &Contender, n: f64) -> String {
    let mut o = format!("{:45} score {:7.0} [{:.2} {:.2} {:.2}] nrmse {:.4}", name(s, &c.choices), c.score(n), c.fit.quantile(0.5), c.fit.quantile(0.75), c.fit.quantile(0.9), c.fit.nrmse);
    for (k, u) in c.trial.hypothesis.shared.iter().zip(&c.trial.fit.point.shared) { if c.choices.iter().any(|ch| k.name.starts_with(&s.catalogue[ch.effect].id)) { o += &format!(" {:.4e}", k.value(*u)); } }
    o
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let fmu = Fmu::load(Path::new("/work/notes/StickSlipBeam.fmu")).unwrap();
    let truth: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(Path::new(&args[1]).join("truth.json")).unwrap()).unwrap();
    let list: Vec<String> = if args.len() > 2 { args[2..].to_vec() } else { truth.as_array().unwrap().iter().map(|t| t["campaign"].as_str().unwrap().to_owned()).collect() };
    for n in &list {
        let campaign = Campaign::load(&Path::new(&args[1]).join(n)).unwrap();
        let t0 = Instant::now();
        let s = Session::new(&fmu, &campaign).unwrap();
        let tr = truth.as_array().unwrap().iter().find(|t| t["campaign"] == n.as_str()).unwrap();
        println!("=== {n} {} {}", tr["effects"], tr["parameters"].to_string().chars().take(150).collect::<String>());
        let sel = select(&s, &Quiet(t0)).unwrap();
        let t1 = t0.elapsed();
        println!("  {}", show(&s, &sel.calibrated, sel.samples));
        for c in sel.path.iter() { println!("  PATH {}", show(&s, c, sel.samples)); }
        for c in sel.singles.iter().take(3) { println!("       {}", show(&s, c, sel.samples)); }
        for c in sel.pairs.iter().take(3) { println!("       {}", show(&s, c, sel.samples)); }
        let hb = judge::held_out(&s, &sel.calibrated.trial).unwrap();
        print!("  VERDICT {} explained {} ; holdout as given {:.4} cal {:.4} [{:.2} {:.2}]", name(&s, &sel.path.last().map_or(vec![], |p| p.choices.clone())), sel.explained, sel.as_given_holdout.nrmse, hb.nrmse, hb.quantile(0.5), hb.quantile(0.75));
        if let Some(p) = sel.path.last() { let h = judge::held_out(&s, &p.trial).unwrap(); print!(" final {:.5} [{:.2} {:.2} {:.2}]", h.nrmse, h.quantile(0.5), h.quantile(0.75), h.quantile(0.9)); }
        println!(" {:.1?} {:.1?}", t1, t0.elapsed());
    }
}

use stickslip::diagnose::{conclude, judge, select, session::Session};
use stickslip::{fmu::Fmu, measurement::Campaign};
struct Quiet;
impl select::Watch for Quiet {
    fn step(&self, _: &str, _: usize, _: usize) {}
    fn stop(&self) -> bool { false }
}
fn dump(tag: &str, s: &Session, j: &judge::Judgement) {
    for (i, (&k, m)) in j.shots.iter().zip(&j.mean_square).enumerate() {
        let shot = &s.shots[k];
        println!("{tag} {} {:.4} {} {:.6} {:.3} {} {:?}", shot.run, shot.time[0], j.point.stuck[i], shot.dwell, (m / s.noise[shot.run].powi(2)).sqrt(), shot.stuck, j.point.states[i]);
    }
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let fmu = Fmu::load("/work/notes/x0.fmu".as_ref()).unwrap();
    let campaign = Campaign::load(a[1].as_ref()).unwrap();
    let s = Session::new(&fmu, &campaign).unwrap();
    let effects: Vec<usize> = a[2..].iter().map(|id| s.catalogue.iter().position(|c| c.id == *id).unwrap()).collect();
    let t = std::time::Instant::now();
    let sel = select::follow(&s, &effects, &Quiet).unwrap();
    println!("base {:.1} q {:?}", sel.calibrated.score(sel.samples), [0.5, 0.75, 0.8, 0.9, 0.95].map(|q| sel.calibrated.fit.quantile(q)));
    for p in &sel.path {
        println!("{} {:.1} q {:?} sims {}", select::name(&s, &p.choices), p.score(sel.samples), [0.5, 0.75, 0.8, 0.9, 0.95].map(|q| p.fit.quantile(q)), p.trial.simulations);
    }
    println!("search {:.1} s", t.elapsed().as_secs_f64());
    let t = std::time::Instant::now();
    let r = conclude::climb(&s, &sel).unwrap();
    println!("climb {:.1} s", t.elapsed().as_secs_f64());
    let l = r.fit.len() - 1;
    for i in 0..=l { println!("rung {i}: fit {:.5} q {:?}; holdout {:.5} q {:?}", r.fit[i].nrmse, [0.5, 0.75, 0.9, 0.95].map(|q| r.fit[i].quantile(q)), r.holdout[i].nrmse, [0.5, 0.75, 0.9, 0.95].map(|q| r.holdout[i].quantile(q))); }
    for (i, k) in r.trials[l].hypothesis.shared.iter().enumerate() {
        let e = conclude::estimate(&r.trials[l].hypothesis, &r.trials[l].fit, i);
        println!("knob {} {:e} {:e}", k.name, e.value, e.std);
    }
    dump("fit", &s, &r.fit[l]);
    dump("hold", &s, &r.holdout[l]);
}

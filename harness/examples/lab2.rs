use std::path::Path;
use stickslip::diagnose::{fit::*, hypothesis::*, predictor::*, search::*, session::*};
use stickslip::{fmu::Fmu, measurement::Campaign};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let fmu = Fmu::load(Path::new("/work/notes/StickSlipBeam.fmu")).unwrap();
    let campaign = Campaign::load(Path::new(&args[1])).unwrap();
    let s = Session::new(&fmu, &campaign).unwrap();
    println!("held out {:?}", s.held_out);
    let shots: Vec<_> = s.fit_shots(3).iter().map(|&k| s.shots[k].clone()).collect();
    let id = &args[2];
    let e = s.catalogue.iter().position(|c| &c.id == id).unwrap();
    let h = s.hypothesis(&[Choice { effect: e, settings: vec![] }]).unwrap();
    let data = Data { shots: &shots, noise: &s.noise, weight: 1.0 };
    let mut p = Predictor::new(&fmu, &s.references, &campaign.runs, &h).unwrap();
    let i = h.shared.iter().position(|k| k.name.starts_with(id.as_str())).unwrap();
    for v in args[3..].iter().map(|a| a.parse::<f64>().unwrap()) {
        let mut point = Point::centre(&h, &shots);
        point.shared[i] = h.shared[i].position(v);
        for it in [1, 2, 3, 8] {
            let f = Fitter::new(&mut p, &h, &data, effort(it)).run(point.clone());
            print!("start {v:e} it {it}: trimmed {:.0} ", f.trimmed);
            for (k, u) in h.shared.iter().zip(&f.point.shared) { print!("{} {:.4e}; ", k.name, k.value(*u)); }
            println!();
        }
    }
}

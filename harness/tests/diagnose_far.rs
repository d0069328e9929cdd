//! Fits that begin where the motion runs away from the measurement in every shot.

use std::path::Path;
use stickslip::command::open_fmu;
use stickslip::diagnose::fit::{Data, Effort, Fit, Fitter};
use stickslip::diagnose::predictor::Point;
use stickslip::diagnose::screen::Screen;
use stickslip::diagnose::search;
use stickslip::diagnose::session::Session;
use stickslip::measurement::Campaign;

/// Start states of the reference model, fitted from the smoothed ones, the first modal velocity `faster` in m/s.
fn fit(session: &Session, screen: &Screen, faster: f64) -> Fit {
    let h = session.hypothesis(&[]).unwrap();
    let mut predictor = session.predictor(&h).unwrap();
    let data: Data = session.data(&screen.shots);
    let mut start = Point::centre(&h, &screen.shots);
    for state in &mut start.states {
        state[1] += faster;
    }
    let effort = Effort {
        knobs: false,
        revive: false,
        ..search::effort(20)
    };
    Fitter::new(&mut predictor, &h, &data, effort).run(start)
}

#[test]
fn a_fit_descends_from_where_every_shot_runs_away() {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo");
    let fmu = open_fmu(None).unwrap();
    let campaign = Campaign::load(&demo).unwrap();
    let session = Session::new(&fmu, &campaign).unwrap();
    let screen = Screen::new(&session);
    let near = fit(&session, &screen, 0.0);
    // 4 m/s swing the tip by 16 mm, sixteen times as far as the measured motion.
    let far = fit(&session, &screen, 4.0);
    assert!(far.trimmed.is_finite(), "objective {}", far.trimmed);
    assert!(
        far.trimmed < 2.0 * near.trimmed,
        "{} from afar, {} from near by",
        far.trimmed,
        near.trimmed
    );
}

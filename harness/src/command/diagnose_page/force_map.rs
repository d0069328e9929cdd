//! The contact force that the measurement implies, and the part of it that the models do not explain.

use super::growth::quartiles;
use super::samples::Sample;
use super::statistics::{bins, median, thinned};
use super::views::COLOURS;
use super::{Material, side_by_side};
use crate::diagnose::data::contact_phase::ContactPhase;
use crate::observer::{Contact, NormalForce, break_away};
use crate::report::{Axis, Cell, Colour, Page, Plot, Table, number, with_unit};

/// Points of a cloud.
const POINTS: usize = 4000;

/// The section.
pub fn section(page: Page, material: &Material) -> Page {
    let page = page.section(super::SECTIONS[5]).paragraph(
        "The contact force is estimated from the measured displacement and the linear beam as given, without any friction law (Kalman smoother with unknown force). \
         The unexplained force is this force less the model's own along its predictions, over the normal force; samples within 0.5 ms of a transition are left out, where no estimate can follow the jump.",
    );
    let page = page.figures(&[&over_velocity(material), &dwell(material)]);
    let page = page.paragraph("Break-away force and dwell time go together even without ageing: while the tip sticks the force rises steadily, so a threshold that is high by chance, or by the place on the belt, makes a long stick. A slope in this picture alone is no proof of ageing; different belt speeds or holds of prescribed length are.");
    if !material
        .views
        .samples
        .iter()
        .any(|s| s.unexplained[1].is_finite())
    {
        return page.paragraph(
            "The FMU has no output friction_force, so the unexplained force can't be shown.",
        );
    }
    let page = page.subsection("Unexplained force").table(&by_contact_phase(material)).figures(&[
        &unexplained(material, "relative velocity", "m/s", "over the relative velocity: a trend here is a wrong friction characteristic", &|s| s.relative_velocity, &|s| s.contact_phase != ContactPhase::Stick),
        &unexplained(material, "tip displacement", "mm", "over the displacement: a trend here is a wrong stiffness, or a normal force that follows the tip", &|s| 1e3 * s.displacement, &|_| true),
        &loops(material, 0),
        &loops(material, 1),
    ]);
    let page = page.subsection("Unexplained force along the belt, run by run");
    let runs = material.problem.campaign.runs.len();
    let travel: Vec<Plot> = (0..runs).filter_map(|r| along(material, r)).collect();
    side_by_side(page, &travel)
}

/// Normal force, for force ratios; 1 N where a run has none.
fn load(material: &Material, run: usize) -> f64 {
    let force = material.problem.campaign.runs[run].normal_force;
    if force > 0.0 { force } else { 1.0 }
}

fn over_velocity(material: &Material) -> Plot {
    let slip = |contact_phase: ContactPhase| -> Vec<Sample> {
        let all: Vec<Sample> = material
            .views
            .samples
            .iter()
            .filter(|s| s.contact_phase == contact_phase)
            .copied()
            .collect();
        thinned(&all, POINTS / 2)
    };
    let mut plot = Plot::new(
        Axis::linear("relative velocity", "m/s"),
        Axis::linear("contact force over normal force", "1"),
    );
    for (contact_phase, colour, name) in [
        (
            ContactPhase::Accelerating,
            Colour::Red,
            "slip growing faster",
        ),
        (
            ContactPhase::Decelerating,
            Colour::Blue,
            "slip growing slower",
        ),
    ] {
        let (x, y) = coordinates(material, &slip(contact_phase));
        plot = plot.cloud(name, colour, &x, &y);
    }
    let model: Vec<(f64, f64)> = material
        .views
        .samples
        .iter()
        .filter(|s| s.contact_phase.is_steady() && s.contact_phase != ContactPhase::Stick)
        .map(|s| {
            (
                s.relative_velocity,
                (s.force - s.unexplained[0]) / load(material, s.run),
            )
        })
        .collect();
    let law = bins(&model, 60);
    if law.middle.iter().any(|m| m.is_finite()) {
        plot = plot.line(
            &format!("model, {} (median)", material.views.pair[0].name),
            Colour::Ink,
            &law.x,
            &law.middle,
        );
    }
    plot.caption("Contact force that the measurement implies, in slip, by whether slip grows faster or slower: two branches instead of one mean friction with memory or a wrong motion of the belt.")
}

fn coordinates(material: &Material, samples: &[Sample]) -> (Vec<f64>, Vec<f64>) {
    samples
        .iter()
        .map(|s| (s.relative_velocity, s.force / load(material, s.run)))
        .unzip()
}

fn dwell(material: &Material) -> Plot {
    let problem = material.problem;
    let mut plot = Plot::new(
        Axis::log("dwell time in stick", "ms"),
        Axis::linear("break-away force over normal force", "1"),
    );
    for (r, run) in problem.campaign.runs.iter().enumerate() {
        let motion = &problem.smoothings[r].stick_slip;
        let found = break_away(&Contact {
            relative_velocity: &motion.relative_velocity,
            force: &motion.smoothed.force,
            normal_force: NormalForce::Constant(load(material, r)),
            phases: &motion.phases,
        });
        let Ok(found) = found else { continue };
        let (x, y): (Vec<f64>, Vec<f64>) =
            found.events.iter().map(|e| (1e3 * e.dwell, e.mu)).unzip();
        let name = format!("{} ({} m/s)", run.name, number(run.belt_velocity, 3));
        plot = plot.cloud(&name, Colour::SERIES[r % Colour::SERIES.len()], &x, &y);
    }
    plot.caption("Break-away force against the time spent in stick before, one point per stick phase: shows 'ageing' even where there is none, see below.")
}

fn by_contact_phase(material: &Material) -> Table {
    let [before, after] = &material.views.pair;
    let header = [
        "moment of the cycle",
        "share of the samples",
        before.name.as_str(),
        after.name.as_str(),
    ];
    let all = &material.views.samples;
    let steady = [
        ContactPhase::Stick,
        ContactPhase::Accelerating,
        ContactPhase::Decelerating,
    ];
    steady
        .iter()
        .fold(Table::new(&header), |table, contact_phase| {
            let of = || all.iter().filter(|s| s.contact_phase == *contact_phase);
            let size = |view: usize| {
                Cell::Number(number(
                    median(of().map(|s| s.unexplained[view].abs() / load(material, s.run))),
                    3,
                ))
            };
            let share = 100.0 * of().count() as f64 / all.len().max(1) as f64;
            table.row(vec![
                Cell::Text(format!(
                    "{}: median of the unexplained force over normal force",
                    contact_phase.name()
                )),
                Cell::Number(format!("{share:.0} %")),
                size(0),
                size(1),
            ])
        })
}

fn unexplained(
    material: &Material,
    quantity: &str,
    unit: &str,
    reading: &str,
    x: &dyn Fn(&Sample) -> f64,
    which: &dyn Fn(&Sample) -> bool,
) -> Plot {
    let mut plot = Plot::new(
        Axis::linear(quantity, unit),
        Axis::linear("unexplained force over normal force", "1"),
    );
    for (view, colour) in COLOURS.iter().enumerate() {
        let points: Vec<(f64, f64)> = material
            .views
            .samples
            .iter()
            .filter(|s| s.contact_phase.is_steady() && which(s))
            .map(|s| (x(s), s.unexplained[view] / load(material, s.run)))
            .collect();
        plot = quartiles(
            plot,
            &material.views.pair[view].name,
            *colour,
            &bins(&points, 50),
        );
    }
    plot.level("", Colour::Grey, 0.0).caption(&format!(
        "Unexplained force {reading} (median and middle half)."
    ))
}

/// Unexplained force over v_r, accelerating and decelerating apart.
fn loops(material: &Material, view: usize) -> Plot {
    let mut plot = Plot::new(
        Axis::linear("relative velocity", "m/s"),
        Axis::linear("unexplained force over normal force", "1"),
    );
    for (contact_phase, colour, name) in [
        (
            ContactPhase::Accelerating,
            Colour::Red,
            "slip growing faster",
        ),
        (
            ContactPhase::Decelerating,
            Colour::Blue,
            "slip growing slower",
        ),
    ] {
        let points: Vec<(f64, f64)> = material
            .views
            .samples
            .iter()
            .filter(|s| s.contact_phase == contact_phase)
            .map(|s| {
                (
                    s.relative_velocity,
                    s.unexplained[view] / load(material, s.run),
                )
            })
            .collect();
        plot = quartiles(plot, name, colour, &bins(&points, 50));
    }
    plot.level("", Colour::Grey, 0.0)
        .caption(&format!("The same for the model {}, the two halves of slip apart: where they part, friction depends on more than the velocity.", material.views.pair[view].name))
}

fn along(material: &Material, r: usize) -> Option<Plot> {
    let run = &material.problem.campaign.runs[r];
    let mut plot = Plot::new(
        Axis::linear("belt travel", "mm"),
        Axis::linear("unexplained force over normal force", "1"),
    )
    .size(620.0, 260.0);
    let mut any = false;
    for (view, colour) in COLOURS.iter().enumerate() {
        let points: Vec<(f64, f64)> = material
            .views
            .samples
            .iter()
            .filter(|s| {
                s.run == r && s.contact_phase.is_steady() && s.contact_phase != ContactPhase::Stick
            })
            .map(|s| (1e3 * s.travel, s.unexplained[view] / load(material, r)))
            .collect();
        let found = bins(&points, 60);
        any |= found.middle.iter().any(|m| m.is_finite());
        plot = quartiles(plot, &material.views.pair[view].name, *colour, &found);
    }
    let held = if material.problem.held_out[r] {
        ", kept out of the fit"
    } else {
        ""
    };
    any.then(|| {
        plot.level("", Colour::Grey, 0.0).caption(&format!(
            "{} ({} m/s, {}{held}): unexplained friction in slip over belt travel, which at this speed is also time ({} mm in 1 s).",
            run.name,
            number(run.belt_velocity, 3),
            with_unit(run.normal_force, "N"),
            number(1e3 * run.belt_velocity, 3)
        ))
    })
}

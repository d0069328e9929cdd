//! Where the predictions fail: contact_phase of the cycle, time since the start of a prediction, frequency.

use super::Material;
use super::ladder::dumbbells;
use super::statistics::{Bins, bins, median, stretches};
use super::views::COLOURS;
use crate::diagnose::data::contact_phase::ContactPhase;
use crate::diagnose::explanation::residual::{NORMAL_MEDIAN, spectrum_over_noise};
use crate::report::{Axis, Colour, Page, Plot};

/// The first part of the section.
pub fn section(page: Page, material: &Material) -> Page {
    let page = page
        .section(super::SECTIONS[3])
        .paragraph("First the error of the predicted displacement, then the force that the model does not explain. In units of the noise 1 is the floor: nothing is left to be explained.")
        .figures(&[&by_contact_phase(material), &by_horizon(material)]);
    match residual_spectrum(material) {
        Some(plot) => page.figure(&plot),
        None => page,
    }
}

/// Absolute residual over noise of each sample, so scaled that its median is 1 for noise alone.
fn sizes<'a>(
    material: &'a Material,
    view: usize,
) -> impl Iterator<Item = (&'a super::samples::Sample, f64)> {
    let noise = &material.problem.noise;
    material
        .views
        .samples
        .iter()
        .map(move |s| (s, s.residual[view].abs() / noise[s.run] / NORMAL_MEDIAN))
}

fn by_contact_phase(material: &Material) -> Plot {
    let names: Vec<String> = ContactPhase::ALL
        .iter()
        .map(|m| m.name().to_owned())
        .collect();
    let values = [0, 1].map(|view| {
        ContactPhase::ALL
            .iter()
            .map(|m| {
                median(
                    sizes(material, view)
                        .filter(|(s, _)| s.contact_phase == *m)
                        .map(|(_, v)| v),
                )
            })
            .collect::<Vec<f64>>()
    });
    let [before, after] = &material.views.pair;
    dumbbells(Axis::log("median error over noise", "1"), &names, &values, [&before.name, &after.name])
        .upright("noise", Colour::Green, 1.0)
        .caption("The error of prediction by what the contact does at that moment: where it is largest, or first appears, the missing effect acts.")
}

fn by_horizon(material: &Material) -> Plot {
    let mut plot = Plot::new(
        Axis::linear("time since the prediction began", "ms"),
        Axis::log("error over noise", "1"),
    );
    for (view, colour) in COLOURS.iter().enumerate() {
        let points: Vec<(f64, f64)> = sizes(material, view)
            .map(|(s, v)| (1e3 * s.since_start, v))
            .collect();
        plot = quartiles(
            plot,
            &material.views.pair[view].name,
            *colour,
            &bins(&points, 40),
        );
    }
    plot.level("noise", Colour::Green, 1.0)
        .caption("How the error grows while a prediction runs on (median and middle half): a right model stays at the noise to the end.")
}

/// Median line with the middle half as a band.
pub fn quartiles(mut plot: Plot, name: &str, colour: Colour, bins: &Bins) -> Plot {
    for part in stretches(bins) {
        let part = |v: &[f64]| v[part.clone()].to_vec();
        plot = plot.band(
            "",
            colour,
            &part(&bins.x),
            &part(&bins.low),
            &part(&bins.high),
        );
    }
    plot.line(name, colour, &bins.x, &bins.middle)
}

/// Median over the segments of the residual's amplitude at each frequency, over the noise.
fn residual_spectrum(material: &Material) -> Option<Plot> {
    let problem = material.problem;
    let nyquist = problem
        .campaign
        .runs
        .iter()
        .map(|r| 0.5 / r.sample_interval())
        .fold(f64::INFINITY, f64::min);
    let modes: Vec<(String, f64)> = material
        .diagnosis
        .calibrated
        .iter()
        .filter(|(n, _)| n.ends_with("].frequency"))
        .map(|(n, e)| (n.clone(), e.value))
        .collect();
    let highest = modes.iter().map(|m| m.1).fold(0.0, f64::max);
    let shown = nyquist.min((4.0 * highest).max(1000.0));
    let mut plot = Plot::new(
        Axis::linear("frequency", "Hz").from_to(0.0, shown),
        Axis::log("residual over that of noise", "1"),
    )
    .size(1240.0, 340.0);
    let mut any = false;
    for (view, colour) in material.views.pair.iter().zip(COLOURS) {
        let (frequency, level): (Vec<f64>, Vec<f64>) = spectrum_over_noise(problem, &view.replays)
            .into_iter()
            .unzip();
        any |= !level.is_empty();
        plot = plot.line(&view.name, colour, &frequency, &level);
    }
    for (name, value) in &modes {
        plot = plot.upright(name, Colour::Grey, *value);
    }
    any.then(|| {
        plot.level("white noise", Colour::Green, 1.0).caption(
            "Spectrum of what the predictions miss (median over the pieces) over that of white noise: a peak away from the modes given speaks of another mode or an excitation, at the modes of friction and damping.",
        )
    })
}

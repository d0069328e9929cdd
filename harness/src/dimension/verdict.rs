//! The verdict in words.

use super::analysis::{Analysis, Settings};
use super::convergence::FEWEST_RETURNS;

/// What can be said of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// A correlation dimension.
    Dimension,
    /// The series repeats.
    Periodic,
    /// Its slopes agree nowhere over radii and embedding dimensions.
    NoScalingRegion,
    /// Its slopes agree over radii, but still change with the embedding dimension, or the motion came back too seldom to tell.
    NotConverged,
    /// Noise with the same spectrum and values looks the same.
    NotDistinguishableFromNoise,
}

impl Verdict {
    /// The word in dimension.json.
    pub fn id(self) -> &'static str {
        match self {
            Verdict::Dimension => "dimension",
            Verdict::Periodic => "periodic",
            Verdict::NoScalingRegion => "no_scaling_region",
            Verdict::NotConverged => "not_converged",
            Verdict::NotDistinguishableFromNoise => "not_distinguishable_from_noise",
        }
    }

    /// In a few words.
    pub fn title(self) -> &'static str {
        match self {
            Verdict::Dimension => "A correlation dimension",
            Verdict::Periodic => "Periodic",
            Verdict::NoScalingRegion => "No scaling region",
            Verdict::NotConverged => "No plateau over the embedding dimension",
            Verdict::NotDistinguishableFromNoise => "Not distinguishable from noise",
        }
    }

    /// What it means.
    pub fn meaning(self) -> &'static str {
        match self {
            Verdict::Dimension => {
                "The slopes agree over radii and embedding dimensions, and noise with the same spectrum and values has higher ones."
            }
            Verdict::Periodic => {
                "The series repeats: a closed curve, of dimension 1. Slopes of the correlation sum say nothing more."
            }
            Verdict::NoScalingRegion => {
                "The series is not noise with its spectrum, but at no radii do the slopes agree over two octaves and four embedding \
                 dimensions; a number would be arbitrary. Record longer, with less noise, or try another delay."
            }
            Verdict::NotConverged => {
                "The series is not noise with its spectrum, and its slopes agree over radii, but no limit over the embedding dimension is \
                 reached; a number would depend on where one stops. Record more returns, or with less noise."
            }
            Verdict::NotDistinguishableFromNoise => {
                "Linear noise with the same spectrum and the same values, or a sum of incommensurable oscillations, has slopes as low. No \
                 dimension is resolved; a high-dimensional motion may look like this as well."
            }
        }
    }
}

/// What the reader must know of an analysis.
pub(super) fn remarks(a: &Analysis, settings: &Settings) -> Vec<String> {
    let mut out = Vec::new();
    let bound = a.eckmann_ruelle_bound();
    if let Some(q) = a.quantisation {
        let action = match settings.dither {
            true => "noise of one step's width was added",
            false => {
                "radii of a few steps count steps, not distances; --dither adds noise of one step's width"
            }
        };
        out.push(format!(
            "The series is rounded to {} levels: {action}.",
            q.levels + 1
        ));
    }
    if a.missing > 0 {
        out.push(format!(
            "{} of {} samples are missing; delay vectors that contain one are in no pair.",
            a.missing, a.samples
        ));
    }
    if a.sum.settings.thin > 1 {
        out.push(format!(
            "Sampled: every {}th vector is the first of a pair, the second runs over all; the error stated holds for this sample.",
            a.sum.settings.thin
        ));
    }
    if let Some(region) = &a.region {
        if region.octaves() < 10f64.log2() {
            out.push(format!(
                "The scaling region is {:.1} octaves long, less than a decade.",
                region.octaves()
            ));
        }
        if a.verdict == Verdict::Dimension && region.slope > bound / 2.0 {
            out.push(format!(
                "The dimension is above half of the bound 2 log10 N = {bound:.1}: take it for a lower bound."
            ));
        }
    }
    if a.verdict == Verdict::NotConverged {
        if let (Some(r), Some(c)) = (&a.region, a.convergence.filter(|c| !c.is_plateau())) {
            out.push(format!(
                "The slope changes by {:+.3} (standard error {:.3}) from m = {} to {}: beyond three standard errors of that change, and \
                 more than the interval of one standard deviation, {:.3}, to either side of the slope holds.",
                c.change, c.std, r.dimensions.0, r.dimensions.1, c.stated
            ));
        }
        if a.returns < FEWEST_RETURNS {
            out.push(format!(
                "The motion came back {} times only; the errors of slopes need {FEWEST_RETURNS}, five in each of ten blocks of the record.",
                a.returns
            ));
        }
    }
    if let (Some((first, second)), Some(std), Verdict::Dimension) = (a.halves, a.std, a.verdict)
        && (first - second).abs() > 4.0 * std
    {
        out.push(format!(
            "The halves of the record have slopes {first:.2} and {second:.2}: it may not be stationary, or is too short."
        ));
    }
    out
}

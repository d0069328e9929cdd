//! dimension.json and correlation_sum.csv.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::series::Series;
use crate::dimension::Analysis;
use crate::provenance::Provenance;

/// One line per embedding dimension and radius.
pub fn sums(a: &Analysis) -> String {
    let mut csv = String::from("m,radius,pairs\n");
    for (m, counts) in a.sum.counts.iter().enumerate() {
        for (radius, pairs) in a.sum.radii.iter().zip(counts) {
            let _ = writeln!(csv, "{},{radius},{pairs}", m + 1);
        }
    }
    csv
}

/// NaN has no JSON form.
fn number(value: f64) -> Value {
    if value.is_finite() {
        json!(value)
    } else {
        Value::Null
    }
}

/// All results.
pub fn json(series: &Series, a: &Analysis, provenance: &Provenance) -> String {
    let per_dimension: Vec<Value> = (1..=a.sum.counts.len())
        .map(|m| {
            json!({
                "m": m,
                "pairs": a.sum.pairs(m),
                "slope_in_region": a.over_dimensions.get(m - 1).map(|s| number(*s)),
                "local_slopes": a.slopes[m - 1].iter().map(|s| number(*s)).collect::<Vec<_>>(),
            })
        })
        .collect();
    let interval = series.interval;
    let value = json!({
        "series": series.name,
        "quantity": series.quantity,
        "unit": series.unit,
        "sample_interval_s": interval,
        "samples": a.samples,
        "missing_samples": a.missing,
        "verdict": a.verdict.id(),
        "meaning": a.verdict.meaning(),
        "correlation_dimension": a.dimension(),
        "std": a.dimension().and(a.std),
        "norm": a.sum.settings.norm.name(),
        "thin": a.sum.settings.thin,
        "delay": a.delay,
        "delay_from_mutual_information": a.delay_choice.from_information,
        "theiler_window": a.theiler,
        "scaling_region": a.region.as_ref().map(|r| json!({
            "from": r.from, "to": r.to, "octaves": r.octaves(), "dimensions": [r.dimensions.0, r.dimensions.1],
            "slope": r.slope, "slopes": r.slopes, "window_std": r.window_std, "std": a.std,
        })),
        "convergence": a.convergence.map(|c| json!({
            "change": number(c.change), "std": number(c.std), "plateau": c.is_plateau(),
        })),
        "returns": a.returns,
        "takens_estimate": a.takens.map(number),
        "halves": a.halves.map(|h| json!([number(h.0), number(h.1)])),
        "radii": a.sum.radii,
        "dimensions": per_dimension,
        "surrogates": {
            "count": a.surrogates.surrogates.len(), "samples": a.surrogates.samples, "dimension": a.surrogates.dimension,
            "slope": number(a.surrogates.slope), "slopes": a.surrogates.surrogates, "z": number(a.surrogates.z),
            "p_value": a.surrogates.p_value, "distinct": a.surrogates.is_distinct(),
        },
        "eckmann_ruelle_bound": a.eckmann_ruelle_bound(),
        "lyapunov": a.divergence.as_ref().map(|d| json!({
            "per_sample": d.exponent, "std_per_sample": d.std,
            "per_second": interval.map(|dt| d.exponent / dt), "fitted_samples": [d.fitted.0, d.fitted.1],
        })),
        "period": a.period.map(|p| json!({
            "samples": p.period, "seconds": interval.map(|dt| p.period * dt), "misfit_after_one": p.after_one,
            "misfit_after_many": p.after_many, "repeats": p.repeats(),
        })),
        "quantisation": a.quantisation.map(|q| json!({ "step": q.step, "levels": q.levels + 1 })),
        "noise_radius": a.noise_radius,
        "remarks": a.remarks,
    });
    provenance.json(&value)
}

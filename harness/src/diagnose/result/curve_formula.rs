//! A short formula in place of the curve that a selection ends with, fitted to the data like any other effect.

use crate::diagnose::estimation::curve_estimate::curve_estimate;
use crate::diagnose::estimation::nesting::widen;
use crate::diagnose::explanation::short_formula::{Curve, short_formulas};
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::library::FORMULA_PREFIX;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::{FormulaConstant, UnknownFunction};
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::parallel::parallel;

/// A formula that may take the place of a curve.
#[derive(Debug, Clone)]
pub struct CurveFormula {
    /// Identifier of the effect.
    pub id: String,
    /// The effect's file.
    pub file: String,
    constants: Vec<FormulaConstant>,
    /// The constant of the curve, which friction level or modal data take up.
    level: f64,
    place: &'static str,
    mode: Option<usize>,
}

/// The unknown function that a selection ends with.
pub fn last_curve<'a>(
    problem: &'a Problem,
    selection: &'a Selection,
) -> Option<(&'a UnknownFunction, &'a FittedModel)> {
    let model = selection.path.last()?;
    Some((function_of(problem, model)?, model))
}

/// The unknown function that a model consists of; `None` for any other model.
pub fn function_of<'a>(problem: &'a Problem, model: &FittedModel) -> Option<&'a UnknownFunction> {
    let [choice] = &model.choices[..] else {
        return None;
    };
    let id = &problem.catalogue[choice.effect].id;
    problem.unknown_functions.iter().find(|f| f.id == *id)
}

/// Formulas for the curve that a selection ends with; none where it ends with something else.
pub fn formulas(problem: &Problem, selection: &Selection) -> Vec<CurveFormula> {
    let Some((function, model)) = last_curve(problem, selection) else {
        return Vec::new();
    };
    let Some(estimate) = curve_estimate(problem, function, &model.fitted) else {
        return Vec::new();
    };
    let h = &model.fitted.hypothesis;
    let memory_s = h
        .shared_index(&format!("{}.tau", function.id))
        .map(|i| h.shared[i].value(model.fitted.fit.point.shared[i]));
    let curve = Curve {
        at: &function.at,
        values: &estimate.values,
        covariance: &estimate.covariance,
        samples: model.samples,
        variable: (function.variable(), function.argument_unit),
        unit: function.value_unit(),
    };
    let formulas = short_formulas(&curve).into_iter().enumerate();
    formulas
        .map(|(i, formula)| {
            let id = format!("{FORMULA_PREFIX}{}", i + 1);
            CurveFormula {
                file: function.formula_file(&id, &formula.curve, &formula.constants, memory_s),
                id,
                constants: formula.constants,
                level: formula.level,
                place: function.place,
                mode: function.mode,
            }
        })
        .collect()
}

/// Fits the formulas, which `problem` has as effects by now, from the curve that the selection ends with. The best becomes its last
/// step if it explains the data, or more than the curve does.
///
/// # Errors
/// An FMU that can't be run.
pub fn fit(
    problem: &Problem,
    selection: &mut Selection,
    formulas: &[CurveFormula],
) -> Result<(), Error> {
    let Some((_, curve)) = last_curve(problem, selection) else {
        return Ok(());
    };
    let screen = Screen::new(problem);
    let fitted = parallel(formulas, |formula| {
        let Some(effect) = problem.catalogue.iter().position(|c| c.id == formula.id) else {
            return Ok(None);
        };
        let choices = [Choice::of(effect)];
        let h = problem.hypothesis(&choices)?;
        let start = widen(&curve.fitted, &h, &Point::centre(&h, &screen.segments));
        let there = screen.fitted_from(&choices, formula.put(&h, start))?;
        let mut model = screen.to_its_end(&there)?;
        full_refit::stands(problem, &mut model)?;
        Ok(Some(model))
    })?;
    let best = fitted.into_iter().flatten().min_by(FittedModel::compare);
    if let Some(best) = best.filter(|b| b.reaches_floor() || b.is_before(curve)) {
        selection.go_on_with(problem, best);
    }
    Ok(())
}

impl CurveFormula {
    /// The point with the constants of the formula at their values, and what the formula leaves out of the curve where the
    /// reference model has it.
    fn put(&self, h: &Hypothesis, mut point: Point) -> Point {
        for constant in &self.constants {
            if let Some(i) = h.shared_index(&format!("{}.{}", self.id, constant.name)) {
                let parameter = &h.shared[i];
                point.shared[i] = parameter.clamp(parameter.position(constant.value));
            }
        }
        let shift = self.level.ln_1p();
        if !shift.is_finite() {
            return point;
        }
        let of_modes = self
            .mode
            .map_or("mode[".to_owned(), |m| format!("mode[{m}]"));
        let is_taken_up = |name: &str| match self.place {
            "frequency" => name.starts_with(&of_modes) && name.ends_with(".frequency"),
            "damping" => {
                let is_damping =
                    name.ends_with(".damping_ratio") || name.ends_with(".damping_rate");
                name.starts_with(&of_modes) && is_damping
            }
            "friction" => name == "friction.level",
            _ => false,
        };
        let shared = h.shared.iter().zip(&mut point.shared);
        let per_run = h.per_run.iter().flatten();
        let per_run = per_run.zip(point.per_run.iter_mut().flatten());
        for (parameter, position) in shared.chain(per_run) {
            if is_taken_up(&parameter.name) {
                *position = parameter.clamp(*position + shift);
            }
        }
        point
    }
}

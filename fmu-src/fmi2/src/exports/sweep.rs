//! One function beyond the standard: a point of a parameter study, evaluated inside the FMU.
//!
//! A cluster ships the .fmu, sets its variables by `fmi2SetReal` and `fmi2SetInteger` as ever, and calls
//! `stickslipEvaluate` in place of steps: the same compiled code as `stickslip sweep`, so the same digits, users'
//! effects included. Masters that do not know the function never see it. Decision: docs/adr/0010-sweep.md.
//!
//! # Safety
//! As in [`super`].
#![allow(non_snake_case, clippy::missing_safety_doc)]

use crate::guard::{slice, slice_mut, with_instance};
use crate::instance::Content;
use crate::lifecycle::Function;
use crate::setup::{self, INPUTS, PLACES};
use crate::status::Fault;
use crate::types::Component;
use beam_model_description::UserCard;
use beam_physics::error::PhysicsError;
use beam_physics::integrate::MAX_STATES;
use beam_physics::sweep::{Carry, Motion, Rule, Section, StartRule, Subject, evaluate};
use std::ffi::{c_char, c_int};

/// Numbers of a request.
const REQUEST: usize = CARRY + 4 + MAX_STATES;
/// Where a carried state begins in it.
const CARRY: usize = 9;
/// Numbers of an answer before the section's points, three each.
const HEAD: usize = 11 + MAX_STATES;

/// A request read from its numbers: settle, cycles, patience, section (0 peak, 1 release, 2 stroboscopic), period of
/// the latter in s, start (0 fixed, 1 grid, 2 carried), bend, velocity, whether the start state is given; then whether
/// something is carried, its modes, dimension, travel in m and state.
fn request(numbers: &[f64]) -> (Rule, StartRule, bool, Option<Carry>) {
    let n = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
    let section = match n(3) as i32 {
        1 => Section::Release,
        2 => Section::Stroboscopic { period: n(4) },
        _ => Section::Peak,
    };
    let rule = Rule {
        settle: n(0) as usize,
        cycles: n(1) as usize,
        patience: n(2) as usize,
        section,
        ..Rule::default()
    };
    let start = match n(5) as i32 {
        1 => StartRule::Grid {
            bend: n(6),
            velocity: n(7),
        },
        2 => StartRule::Carried,
        _ => StartRule::Fixed,
    };
    let carried = (n(CARRY) == 1.0).then(|| {
        let mut carry = Carry {
            modes: n(CARRY + 1) as usize,
            dimension: n(CARRY + 2) as usize,
            travel: n(CARRY + 3),
            ..Carry::default()
        };
        for (i, x) in carry.state.iter_mut().enumerate() {
            *x = n(CARRY + 4 + i);
        }
        carry.dimension = carry.dimension.min(carry.state.len());
        carry
    });
    (rule, start, n(8) == 1.0, carried)
}

/// The answer as numbers: status, period (-1: none), main frequency in Hz, amplitude in m, stick fraction, exponent in
/// 1/s (not a number where there is none), number of section points, whether something is carried, its modes,
/// dimension, travel in m and state; then time in s, displacement in m and velocity in m/s of each point.
fn answer(motion: &Motion) -> Vec<f64> {
    let mut out = vec![0.0; HEAD];
    out[0] = motion.status as u8 as f64;
    out[1] = motion.period.map_or(-1.0, |p| p as f64);
    out[2] = motion.main_frequency.unwrap_or(f64::NAN);
    out[3] = motion.amplitude;
    out[4] = motion.stick_fraction;
    out[5] = motion.lyapunov.unwrap_or(f64::NAN);
    out[6] = motion.section.len() as f64;
    if let Some(end) = &motion.end {
        out[7] = 1.0;
        out[8] = end.modes as f64;
        out[9] = end.dimension as f64;
        out[10] = end.travel;
        out[11..11 + end.state.len()].copy_from_slice(&end.state);
    }
    for point in &motion.section {
        out.extend([point.time, point.displacement, point.velocity]);
    }
    out
}

fn motion(content: &Content, numbers: &[f64]) -> Result<Motion, PhysicsError> {
    let (rule, from, given, carried) = request(numbers);
    let inputs = PLACES.inputs(&content.values, [0.0; INPUTS], 0.0);
    let model = setup::model(content.layout, &content.values, inputs, UserCard::effect)?;
    let subject = Subject {
        given: given.then(|| PLACES.start(content.layout, &content.values, &model, 0.0)),
        tolerance: content.values[PLACES.tolerance],
        model,
    };
    evaluate(&subject, &rule, &from, carried.as_ref())
}

/// Evaluates one point with the values set so far; legal wherever `fmi2SetReal` is. Writes the answer's numbers (cut
/// at `capacity`; `written` tells how many there are) or, with `written` 0, the reason for failing as text.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslipEvaluate(
    component: Component,
    request: *const f64,
    request_count: usize,
    answers: *mut f64,
    capacity: usize,
    written: *mut usize,
    reason: *mut c_char,
    reason_capacity: usize,
) -> c_int {
    let function = Function::SetReal;
    // SAFETY: contract of this module: lists have the announced lengths.
    unsafe {
        with_instance(component, function, |instance| {
            let request = slice(request, request_count.min(REQUEST), function, "request")?;
            let answers = slice_mut(answers, capacity, function, "answers")?;
            let written = slice_mut(written, 1, function, "written")?;
            let reason = slice_mut(reason.cast::<u8>(), reason_capacity, function, "reason")?;
            reason.fill(0);
            let content = instance.model.content().ok_or_else(|| Fault::Unsupported {
                function,
                what: "a point of a parameter study".into(),
            })?;
            match motion(content, request) {
                Ok(motion) => {
                    let numbers = answer(&motion);
                    let fitting = numbers.len().min(capacity);
                    answers[..fitting].copy_from_slice(&numbers[..fitting]);
                    written[0] = numbers.len();
                }
                Err(error) => {
                    let text = error.to_string();
                    let fitting = text.len().min(reason_capacity.saturating_sub(1));
                    reason[..fitting].copy_from_slice(&text.as_bytes()[..fitting]);
                    written[0] = 0;
                }
            }
            Ok(())
        })
    }
}

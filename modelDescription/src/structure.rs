//! `<ModelStructure>`: outputs, derivatives and initial unknowns, and what they depend on (FMI 2.0.5,
//! section 2.2.8).
//!
//! Which unknown depends on which state and input, over all parameters, stands in `dependencies.txt`. It
//! was found by looking at the model itself: `tests/dependencies.rs` does so again and compares.

use crate::layout::Layout;
use crate::user_effect::UserCard;
use crate::variable::{Causality, Initial, Quantity};
use beam_physics::effects::user_expression::Target;
use quick_xml::Writer;
use std::io;

/// Lines `unknown: known known ...`.
const DEPENDENCIES: &str = include_str!("../dependencies.txt");

/// Writes the element.
pub fn write(w: &mut Writer<Vec<u8>>, layout: &Layout) -> io::Result<()> {
    let variables = layout.variables();
    let outputs: Vec<usize> = (0..variables.len())
        .filter(|&i| variables[i].causality == Causality::Output)
        .collect();
    let rates: Vec<usize> = layout.states().iter().map(|(_, rate)| *rate).collect();
    let calculated = |i: &usize| variables[*i].initial == Some(Initial::Calculated);
    let states = layout.states().iter().map(|(state, _)| *state);
    let mut initial: Vec<usize> = outputs.iter().copied().chain(states).collect();
    initial.extend(&rates);
    initial.retain(calculated);
    initial.sort_unstable();
    w.create_element("ModelStructure")
        .write_inner_content(|w| {
            list(w, layout, "Outputs", &outputs, true)?;
            list(w, layout, "Derivatives", &rates, true)?;
            // These depend on start values and parameters as well, in principle on all of them: no list.
            list(w, layout, "InitialUnknowns", &initial, false)
        })?;
    Ok(())
}

fn list(
    w: &mut Writer<Vec<u8>>,
    layout: &Layout,
    name: &str,
    unknowns: &[usize],
    depends: bool,
) -> io::Result<()> {
    w.create_element(name).write_inner_content(|w| {
        for &index in unknowns {
            // Indices count from 1 (FMI 2.0.5, section 2.2.8).
            let mut attributes = vec![("index", (index + 1).to_string())];
            if let Some(knowns) = depends.then(|| knowns(layout, index)).flatten() {
                let numbers: Vec<_> = knowns.iter().map(|k| (k + 1).to_string()).collect();
                attributes.push(("dependencies", numbers.join(" ")));
            }
            w.create_element("Unknown")
                .with_attributes(attributes.iter().map(|(k, v)| (*k, v.as_str())))
                .write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}

/// States and inputs on which a variable depends, sorted.
fn knowns(layout: &Layout, unknown: usize) -> Option<Vec<usize>> {
    let variables = layout.variables();
    let place = |name: &str| layout.index_of_name(name);
    let user_states = || {
        let of_users = |v: &Quantity| matches!(v, Quantity::UserState(..));
        (0..variables.len()).filter(move |&i| of_users(&variables[i].quantity))
    };
    if let Quantity::Rate(state) = variables[unknown].quantity
        && let Some(of) = layout.index_of_reference(state)
        && let Quantity::UserState(e, i) = variables[of].quantity
    {
        // What a formula looks at besides the belt's velocity is not told apart: everything.
        let of_belt = i == layout.effects()[e].states.len();
        let inputs = ["belt_velocity", "normal_force"];
        return of_belt.then(|| inputs.iter().filter_map(|n| place(n)).collect());
    }
    let name = &variables[unknown].name;
    let (_, list) = DEPENDENCIES
        .lines()
        .filter_map(|line| line.split_once(':'))
        .find(|(of, _)| of == name)?;
    let mut knowns: Vec<usize> = list.split_whitespace().filter_map(place).collect();
    // A user's formula for the belt's velocity may look at the normal force; those for forces look at
    // nothing that the catalogue's effects on forces do not look at.
    let has = |knowns: &[usize], name: &str| place(name).is_some_and(|i| knowns.contains(&i));
    let moves_belt = |card: &UserCard| card.target == Target::BeltVelocity;
    if layout.effects().iter().any(moves_belt) {
        // The distance goes by the velocity as given.
        if has(&knowns, "belt_velocity") && name != "der(belt_distance)" {
            knowns.extend(place("normal_force"));
        }
        if has(&knowns, "belt_distance") {
            knowns.extend(user_states());
        }
    }
    let measures = |card: &UserCard| card.target == Target::Measurement;
    if name == "measured_displacement" && layout.effects().iter().any(measures) {
        return None;
    }
    let remembers = |card: &UserCard| !card.states.is_empty();
    if layout.effects().iter().any(remembers) && !knowns.is_empty() {
        knowns.extend(user_states());
    }
    knowns.sort_unstable();
    knowns.dedup();
    Some(knowns)
}

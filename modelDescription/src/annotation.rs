//! The catalogue of effects as a vendor annotation, so that a reader of the FMU knows them without
//! knowing this project.

use crate::layout::Layout;
use beam_physics::effects::{CATALOGUE, MACHINE, Role};
use quick_xml::Writer;
use std::io;

fn role(role: Role) -> &'static str {
    match role {
        Role::Amplitude => "amplitude",
        Role::Shape => "shape",
        Role::Phase => "phase",
        Role::Node => "node",
        Role::Setting => "setting",
    }
}

/// Writes `<Tool name="StickSlip">` with one `<Effect>` per card, those of the catalogue first.
pub fn write(writer: &mut Writer<Vec<u8>>, layout: &Layout) -> io::Result<()> {
    writer
        .create_element("Tool")
        .with_attribute(("name", "StickSlip"))
        .write_inner_content(|tool| {
            tool.create_element("EffectCatalogue")
                .with_attributes([
                    ("version", "1"),
                    ("length", &format!("{:?}", MACHINE.length)),
                    ("velocity", &format!("{:?}", MACHINE.velocity)),
                    ("force", &format!("{:?}", MACHINE.force)),
                ])
                .write_inner_content(|list| {
                    catalogue(list)?;
                    users(list, layout)
                })?;
            Ok(())
        })?;
    Ok(())
}

fn catalogue(list: &mut Writer<Vec<u8>>) -> io::Result<()> {
    for card in CATALOGUE {
        list.create_element("Effect")
            .with_attributes([
                ("id", card.id),
                ("title", card.title),
                ("equation", card.equation),
                ("description", card.description),
                ("source", card.source),
                ("signature", card.signature),
                ("confounders", card.confounders),
            ])
            .write_inner_content(|effect| {
                for p in card.parameters {
                    let texts = [p.name, p.description, p.unit.symbol];
                    parameter(effect, texts, [p.start, p.typical, p.min, p.max], p.role)?;
                }
                for s in card.states {
                    state(effect, [s.name, s.description, s.unit.symbol], s.nominal)?;
                }
                Ok(())
            })?;
    }
    Ok(())
}

fn users(list: &mut Writer<Vec<u8>>, layout: &Layout) -> io::Result<()> {
    for own in layout.effects() {
        list.create_element("Effect")
            .with_attributes([
                ("id", own.id.as_str()),
                ("title", &own.title),
                ("equation", &own.equation()),
                ("description", &own.description),
                ("source", &own.source),
                ("signature", &own.signature),
                ("confounders", &own.confounders),
                ("own", "true"),
            ])
            .write_inner_content(|effect| {
                for p in &own.parameters {
                    let texts = [p.name.as_str(), &p.description, &p.unit];
                    parameter(effect, texts, [p.start(), p.typical, p.min, p.max], p.role)?;
                }
                for (name, unit, nominal, description) in own.all_states() {
                    state(effect, [name, description, unit], nominal)?;
                }
                Ok(())
            })?;
    }
    Ok(())
}

/// One `<State>`: name, description, unit; typical magnitude.
fn state(
    effect: &mut Writer<Vec<u8>>,
    [name, description, unit]: [&str; 3],
    nominal: f64,
) -> io::Result<()> {
    effect
        .create_element("State")
        .with_attributes([
            ("name", name),
            ("description", description),
            ("unit", unit),
            ("nominal", &format!("{nominal:?}")),
        ])
        .write_empty()?;
    Ok(())
}

/// One `<Parameter>`: name, description, unit; start, typical, min, max; role.
fn parameter(
    effect: &mut Writer<Vec<u8>>,
    [name, description, unit]: [&str; 3],
    [start, typical, min, max]: [f64; 4],
    role_of_it: Role,
) -> io::Result<()> {
    effect
        .create_element("Parameter")
        .with_attributes([
            ("name", name),
            ("description", description),
            ("unit", unit),
            ("start", &format!("{start:?}")),
            ("typical", &format!("{typical:?}")),
            ("min", &format!("{min:?}")),
            ("max", &format!("{max:?}")),
            ("role", role(role_of_it)),
        ])
        .write_empty()?;
    Ok(())
}

//! The catalogue of effects as a vendor annotation, so that a reader of the FMU knows them without
//! knowing this project.

use beam_physics::effects::{CATALOGUE, Role};
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

/// Writes `<Tool name="StickSlip">` with one `<Effect>` per card.
pub fn write(writer: &mut Writer<Vec<u8>>) -> io::Result<()> {
    writer
        .create_element("Tool")
        .with_attribute(("name", "StickSlip"))
        .write_inner_content(|tool| {
            tool.create_element("EffectCatalogue")
                .with_attribute(("version", "1"))
                .write_inner_content(|list| {
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
                                    effect
                                        .create_element("Parameter")
                                        .with_attributes([
                                            ("name", p.name),
                                            ("description", p.description),
                                            ("unit", p.unit.symbol),
                                            ("start", &format!("{:?}", p.start)),
                                            ("typical", &format!("{:?}", p.typical)),
                                            ("min", &format!("{:?}", p.min)),
                                            ("max", &format!("{:?}", p.max)),
                                            ("role", role(p.role)),
                                        ])
                                        .write_empty()?;
                                }
                                for s in card.states {
                                    effect
                                        .create_element("State")
                                        .with_attributes([
                                            ("name", s.name),
                                            ("description", s.description),
                                            ("unit", s.unit.symbol),
                                            ("nominal", &format!("{:?}", s.nominal)),
                                        ])
                                        .write_empty()?;
                                }
                                Ok(())
                            })?;
                    }
                    Ok(())
                })?;
            Ok(())
        })?;
    Ok(())
}

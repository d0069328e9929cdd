//! Serialised states: versioned, checksummed, readable in another process.
//!
//! Layout: magic (8 bytes), version (u32), length of the payload (u64), payload, FNV-1a of all before
//! (u64); numbers little-endian, floating point by its bits.

use crate::experiment::Experiment;
use crate::instance::Content;
use crate::lifecycle::{Interface, Phase};
use crate::setup::{self, INPUTS, PLACES};
use crate::status::{Fault, Status};
use beam_model_description::{Layout, UserCard};
use beam_physics::hybrid::Hybrid;
use beam_physics::simulate::Simulation;
use beam_physics::simulate::snapshot::{Codec, Reader, Writer};

const MAGIC: [u8; 8] = *b"SSBEAM\r\n";
const VERSION: u32 = 4;
const HEADER: usize = 8 + 4 + 8;
const CHECKSUM: usize = 8;

/// Bytes of a state.
pub fn serialize(content: &Content) -> Vec<u8> {
    let mut writer = Writer::default();
    // The enumeration of fields wants to be able to write; a copy serves it.
    exchange(&mut content.clone(), &mut writer).expect("writing does not fail");
    seal(MAGIC, VERSION, &writer.bytes)
}

/// The state in `bytes`, of an FMU with these variables.
///
/// # Errors
/// [`Fault::BrokenState`] for anything that [`serialize`] did not write.
pub fn deserialize(layout: &'static Layout, bytes: &[u8]) -> Result<Content, Fault> {
    let mut reader = Reader::new(open(MAGIC, VERSION, bytes)?);
    // The interface is read with the rest.
    let mut content = Content::blank(layout, Interface::CoSimulation);
    exchange(&mut content, &mut reader)
        .filter(|()| reader.is_empty())
        .ok_or_else(misfit)?;
    Ok(content)
}

/// A payload with its head and checksum.
pub fn seal(magic: [u8; 8], version: u32, payload: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(HEADER + payload.len() + CHECKSUM);
    out.extend(magic);
    out.extend(version.to_le_bytes());
    out.extend((payload.len() as u64).to_le_bytes());
    out.extend(payload);
    let sum = checksum(&out);
    out.extend(sum.to_le_bytes());
    out
}

/// The payload that [`seal`] has closed.
///
/// # Errors
/// [`Fault::BrokenState`].
pub fn open(magic: [u8; 8], version: u32, bytes: &[u8]) -> Result<&[u8], Fault> {
    let broken = |problem: &str| Fault::BrokenState {
        problem: problem.to_owned(),
    };
    if bytes.len() < HEADER + CHECKSUM || bytes[..8] != magic {
        return Err(broken("it is not a state of this model"));
    }
    let found = u32::from_le_bytes(bytes[8..12].try_into().expect("4 bytes"));
    if found != version {
        return Err(broken(&format!(
            "it has version {found}, this FMU reads version {version}"
        )));
    }
    let length = u64::from_le_bytes(bytes[12..20].try_into().expect("8 bytes"));
    let end = usize::try_from(length)
        .ok()
        .and_then(|n| n.checked_add(HEADER));
    let Some(end) = end.filter(|end| end.checked_add(CHECKSUM) == Some(bytes.len())) else {
        return Err(broken("it is truncated or has bytes too many"));
    };
    let sum = u64::from_le_bytes(bytes[end..].try_into().expect("8 bytes"));
    if sum != checksum(&bytes[..end]) {
        return Err(broken("its checksum does not match"));
    }
    Ok(&bytes[HEADER..end])
}

/// A payload that is not what this version of the model writes.
pub fn misfit() -> Fault {
    Fault::BrokenState {
        problem: "its content does not fit this version of the model".into(),
    }
}

/// FNV-1a.
fn checksum<'a>(bytes: impl IntoIterator<Item = &'a u8>) -> u64 {
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// Names every field once, for writing and for reading.
fn exchange(content: &mut Content, codec: &mut impl Codec) -> Option<()> {
    let mut interface = content.interface as u8;
    codec.byte(&mut interface)?;
    content.interface = Interface::from_number(i32::from(interface))?;
    let mut phase = content.phase as u8;
    codec.byte(&mut phase)?;
    content.phase = Phase::from_number(phase)?;
    // With other effects of users the same values would mean another model.
    let texts = content.layout.effects().iter();
    let own = checksum(texts.flat_map(|effect| effect.text.as_bytes()));
    let mut effects = own;
    codec.count(&mut effects)?;
    if effects != own {
        return None;
    }
    let mut count = content.values.len() as u64;
    codec.count(&mut count)?;
    if count != content.values.len() as u64 {
        return None;
    }
    for value in &mut content.values {
        codec.number(value)?;
    }
    codec.number(&mut content.experiment.start)?;
    optional(&mut content.experiment.stop, codec)?;
    optional(&mut content.experiment.tolerance, codec)?;
    codec.number(&mut content.time)?;
    for rate in &mut content.input_rates {
        codec.number(rate)?;
    }
    codec.flag(&mut content.inputs_touched)?;
    codec.flag(&mut content.retuned)?;
    codec.flag(&mut content.stale)?;
    let mut status = content.last_step.code() as u8;
    codec.byte(&mut status)?;
    content.last_step = match status {
        0 => Status::Ok,
        2 => Status::Discard,
        3 => Status::Error,
        _ => return None,
    };
    let (mut running, mut integrated) = (content.run.is_some(), content.hybrid.is_some());
    codec.flag(&mut running)?;
    codec.flag(&mut integrated)?;
    if !running && !integrated {
        return Some(());
    }
    if content.built.is_empty() {
        content.built = content.values.clone();
    }
    for value in &mut content.built {
        codec.number(value)?;
    }
    let (layout, experiment) = (content.layout, content.experiment);
    let make = |built: &[f64]| rebuilt(layout, built, &experiment);
    if running {
        if content.run.is_none() {
            content.run = Some(make(&content.built)?);
        }
        content.run.as_mut()?.exchange(codec)?;
    }
    if integrated {
        if content.hybrid.is_none() {
            content.hybrid = Some(Hybrid::start(&make(&content.built)?));
        }
        content.hybrid.as_mut()?.exchange(codec)?;
    }
    Some(())
}

impl Content {
    /// Refuses a state of another FMU or of the other interface.
    ///
    /// # Errors
    /// [`Fault::BrokenState`].
    pub fn accepts(&self, state: &Self) -> Result<(), Fault> {
        let problem = if !std::ptr::eq(state.layout, self.layout) {
            "it belongs to an FMU with other effects of users".to_owned()
        } else if state.interface != self.interface {
            format!(
                "it belongs to {}, this instance to {}",
                state.interface, self.interface
            )
        } else {
            return Ok(());
        };
        Err(Fault::BrokenState { problem })
    }
}

/// A run with the model of `values`, to be filled.
fn rebuilt(layout: &'static Layout, values: &[f64], experiment: &Experiment) -> Option<Simulation> {
    let inputs = PLACES.inputs(values, [0.0; INPUTS], experiment.start);
    let model = setup::model(layout, values, inputs, UserCard::effect).ok()?;
    let start = PLACES.start(layout, values, &model, experiment.start);
    Simulation::from_model(model, inputs, &start, values[PLACES.tolerance]).ok()
}

/// A number that may be missing.
pub fn optional(value: &mut Option<f64>, codec: &mut impl Codec) -> Option<()> {
    let mut present = value.is_some();
    let mut number = value.unwrap_or(0.0);
    codec.flag(&mut present)?;
    codec.number(&mut number)?;
    *value = present.then_some(number);
    Some(())
}

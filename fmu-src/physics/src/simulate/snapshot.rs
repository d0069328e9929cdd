//! The changing part of a run as bytes, bit by bit, so that it goes on exactly where it was.

use super::stick::StickSystem;
use super::{End, Simulation};
use crate::contact::{ContactMode, Transition};
use crate::energy::Energy;
use crate::integrate::{MAX_DEGREE, State};
use std::sync::Arc;

/// Passes over fields one after the other, to write or to read them; `None` ends a failed reading.
pub trait Codec {
    /// Raw bytes.
    fn bytes<const N: usize>(&mut self, value: [u8; N]) -> Option<[u8; N]>;

    /// A number, by its bits.
    fn number(&mut self, value: &mut f64) -> Option<()> {
        *value = f64::from_le_bytes(self.bytes(value.to_le_bytes())?);
        Some(())
    }
    /// A count.
    fn count(&mut self, value: &mut u64) -> Option<()> {
        *value = u64::from_le_bytes(self.bytes(value.to_le_bytes())?);
        Some(())
    }
    /// A byte.
    fn byte(&mut self, value: &mut u8) -> Option<()> {
        [*value] = self.bytes([*value])?;
        Some(())
    }
    /// Yes or no.
    fn flag(&mut self, value: &mut bool) -> Option<()> {
        let mut byte = u8::from(*value);
        self.byte(&mut byte)?;
        *value = match byte {
            0 => false,
            1 => true,
            _ => return None,
        };
        Some(())
    }
}

/// Collects bytes.
#[derive(Default)]
pub struct Writer {
    /// What has been written.
    pub bytes: Vec<u8>,
}

impl Codec for Writer {
    fn bytes<const N: usize>(&mut self, value: [u8; N]) -> Option<[u8; N]> {
        self.bytes.extend(value);
        Some(value)
    }
}

/// Takes bytes from a slice.
pub struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Reads from `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }
    /// Whether everything has been read.
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }
}

impl Codec for Reader<'_> {
    fn bytes<const N: usize>(&mut self, _: [u8; N]) -> Option<[u8; N]> {
        let (head, rest) = self.rest.split_first_chunk::<N>()?;
        self.rest = rest;
        Some(*head)
    }
}

pub(crate) fn mode(value: &mut ContactMode, codec: &mut impl Codec) -> Option<()> {
    const MODES: [ContactMode; 3] = [
        ContactMode::Backward,
        ContactMode::Stuck,
        ContactMode::Forward,
    ];
    let mut byte = MODES.iter().position(|m| m == value)? as u8;
    codec.byte(&mut byte)?;
    *value = *MODES.get(byte as usize)?;
    Some(())
}

fn state(value: &mut State, codec: &mut impl Codec) -> Option<()> {
    value.iter_mut().try_for_each(|x| codec.number(x))
}

fn end(value: &mut End, codec: &mut impl Codec) -> Option<()> {
    let (mut event, mut transition) = match *value {
        End::Event(transition) => (true, transition),
        End::Smooth => (
            false,
            Transition {
                time: 0.0,
                from: ContactMode::Stuck,
                to: ContactMode::Stuck,
            },
        ),
    };
    codec.flag(&mut event)?;
    codec.number(&mut transition.time)?;
    mode(&mut transition.from, codec)?;
    mode(&mut transition.to, codec)?;
    *value = if event {
        End::Event(transition)
    } else {
        End::Smooth
    };
    Some(())
}

fn energy(value: &mut Option<Energy>, codec: &mut impl Codec) -> Option<()> {
    let mut present = value.is_some();
    let mut e = value.unwrap_or_default();
    codec.flag(&mut present)?;
    codec.number(&mut e.stored)?;
    codec.number(&mut e.belt_work)?;
    codec.number(&mut e.external_work)?;
    codec.number(&mut e.contact_dissipation)?;
    codec.number(&mut e.structural_dissipation)?;
    *value = present.then_some(e);
    Some(())
}

impl Simulation {
    /// Writes or reads everything of a run that changes; the model's constants must be the same on
    /// both sides, and recorded transitions stay behind. `None` where what is read does not fit.
    pub fn exchange(&mut self, codec: &mut impl Codec) -> Option<()> {
        let inputs = &mut self.model.inputs;
        codec.number(&mut inputs.since)?;
        codec.number(&mut inputs.belt_velocity)?;
        codec.number(&mut inputs.belt_acceleration)?;
        codec.number(&mut inputs.normal_force)?;
        codec.number(&mut inputs.normal_force_rate)?;
        codec.number(&mut inputs.external_force)?;
        codec.number(&mut inputs.external_force_rate)?;
        codec.number(&mut inputs.clamp_acceleration)?;
        codec.number(&mut inputs.clamp_acceleration_rate)?;
        codec.number(&mut self.model.travel_offset)?;
        codec.number(&mut self.model.stick_since)?;
        codec.number(&mut self.tolerance)?;
        state(&mut self.scales, codec)?;
        codec.number(&mut self.time)?;
        codec.number(&mut self.front)?;
        state(&mut self.front_state, codec)?;
        mode(&mut self.front_mode, codec)?;
        self.exchange_segment(codec)?;
        end(&mut self.end, codec)?;
        self.stepper
            .numbers_mut()
            .try_for_each(|value| codec.number(value))?;
        codec.count(&mut self.stepper.evaluations)?;
        self.exchange_stick_system(codec)?;
        codec.number(&mut self.first_slip_step)?;
        codec.flag(&mut self.departed)?;
        codec.count(&mut self.transition_count)?;
        codec.number(&mut self.last_transition)?;
        energy(&mut self.energy, codec)?;
        codec.count(&mut self.statistics.slip_steps)?;
        codec.count(&mut self.statistics.stick_steps)
    }

    fn exchange_segment(&mut self, codec: &mut impl Codec) -> Option<()> {
        let segment = &mut self.segment;
        codec.number(&mut segment.start)?;
        codec.number(&mut segment.end)?;
        codec.number(&mut segment.length)?;
        let mut degree = segment.degree as u64;
        codec.count(&mut degree)?;
        segment.degree = usize::try_from(degree).ok().filter(|d| *d <= MAX_DEGREE)?;
        let mut dimension = segment.dimension as u64;
        codec.count(&mut dimension)?;
        if dimension != self.model.dimension() as u64 {
            return None;
        }
        for row in &mut segment.coefficients {
            state(row, codec)?;
        }
        mode(&mut self.segment_mode, codec)?;
        codec.flag(&mut self.segment_is_ready)
    }

    fn exchange_stick_system(&mut self, codec: &mut impl Codec) -> Option<()> {
        let mut present = self.stick_system.is_some();
        codec.flag(&mut present)?;
        if !present {
            self.stick_system = None;
            return Some(());
        }
        let mut linear = match &self.stick_system {
            Some(system) => system.linear.clone(),
            None => self.probe_stick(),
        };
        linear
            .numbers_mut()
            .try_for_each(|value| codec.number(value))?;
        linear.prepare();
        let system = StickSystem::new(linear, &self.model, self.front);
        self.stick_system = Some(Arc::new(system));
        Some(())
    }
}

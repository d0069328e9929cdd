//! The beam as a [`Model`] behind the C interface; the work is done by its [`Content`].

use crate::experiment::Experiment;
use crate::fmu_state;
use crate::instance::{Content, Instance};
use crate::lifecycle::{Interface, Phase};
use crate::model::{Model, SavedState, copied, own};
use crate::status::{Fault, Status};
use crate::tangent::{Answer, Request};
use crate::types::EventInfo;
use crate::values::Access;
use std::any::Any;

impl Model for Instance {
    #[inline]
    fn interface(&self) -> Interface {
        self.content.interface
    }
    #[inline]
    fn phase(&self) -> Phase {
        self.content.phase
    }
    fn set_phase(&mut self, phase: Phase) {
        self.content.phase = phase;
    }

    fn setup_experiment(&mut self, experiment: Experiment) -> Result<(), Fault> {
        experiment.check()?;
        self.content.experiment = experiment;
        self.content.time = experiment.start;
        Ok(())
    }
    fn enter_initialization(&mut self) {
        self.content.phase = Phase::Initialization;
        self.content.stale = true;
    }
    fn exit_initialization(&mut self) -> Result<(), Fault> {
        Instance::exit_initialization(self)
    }
    fn reset(&mut self) {
        Instance::reset(self);
    }

    fn content(&self) -> Option<&Content> {
        Some(&self.content)
    }

    fn get(
        &mut self,
        references: &[u32],
        access: Access,
        write: &mut dyn FnMut(usize, f64),
    ) -> Result<(), Fault> {
        self.content.get(references, access, write)
    }
    fn set(
        &mut self,
        references: &[u32],
        access: Access,
        read: &dyn Fn(usize) -> f64,
    ) -> Result<(), Fault> {
        self.content.set(references, access, read)
    }
    fn directional(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        write: &mut dyn FnMut(usize, f64),
    ) -> Result<(), Fault> {
        self.content.directional(unknowns, knowns, seed, write)
    }

    fn tangents(&mut self, request: &Request, answer: Answer) -> Result<(), Fault> {
        self.content.tangents(&mut self.tangents, request, answer)
    }

    fn save(&self, old: Option<SavedState>) -> SavedState {
        copied(&self.content, old)
    }
    fn restore(&mut self, state: &dyn Any) -> Result<(), Fault> {
        let state: &Content = own(state)?;
        self.content.accepts(state)?;
        self.content.clone_from(state);
        Ok(())
    }
    fn serialize(&self, state: &dyn Any) -> Result<Vec<u8>, Fault> {
        own(state).map(fmu_state::serialize)
    }
    fn deserialize(&self, bytes: &[u8]) -> Result<SavedState, Fault> {
        let content = fmu_state::deserialize(self.content.layout, bytes)?;
        self.content.accepts(&content)?;
        Ok(Box::new(content))
    }

    fn do_step(&mut self, point: f64, step: f64) -> Result<(), Fault> {
        Instance::do_step(self, point, step)
    }
    fn set_input_rates(
        &mut self,
        references: &[u32],
        orders: &[i32],
        rates: &[f64],
    ) -> Result<(), Fault> {
        self.content.set_input_rates(references, orders, rates)
    }
    fn output_rates(
        &mut self,
        references: &[u32],
        orders: &[i32],
        write: &mut dyn FnMut(usize, f64),
    ) -> Result<(), Fault> {
        self.content.output_rates(references, orders, write)
    }
    fn last_step(&self) -> Status {
        self.content.last_step
    }
    fn time(&self) -> f64 {
        self.content.time
    }

    fn set_time(&mut self, time: f64) -> Result<(), Fault> {
        self.content.set_time(time)
    }
    fn set_states(&mut self, states: &[f64]) -> Result<(), Fault> {
        self.content.set_states(states)
    }
    fn get_states(&mut self, states: &mut [f64]) -> Result<(), Fault> {
        self.content.get_states(states)
    }
    fn get_nominals(&mut self, nominals: &mut [f64]) -> Result<(), Fault> {
        self.content.get_nominals(nominals)
    }
    fn get_derivatives(&mut self, rates: &mut [f64]) -> Result<(), Fault> {
        self.content.get_derivatives(rates)
    }
    fn get_indicators(&mut self, indicators: &mut [f64]) -> Result<(), Fault> {
        self.content.get_indicators(indicators)
    }
    fn new_discrete_states(&mut self) -> Result<EventInfo, Fault> {
        self.content.new_discrete_states()
    }
}

//! What a backend must do: the calls of FMI 2.0 co-simulation, one method each, nothing more.

use super::status::Status;

/// One live FMU instance of some backend. Lengths of slices are checked by the caller ([`super::Instance`]).
///
/// States live in numbered slots of the slave and are freed with it; both backends can do that without `unsafe` here.
pub(crate) trait Slave {
    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status;
    fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Status;
    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Status;
    fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Status;
    fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Status;
    fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Status;
    fn set_string(&mut self, references: &[u32], values: &[&str]) -> Status;
    /// First derivatives of inputs, per s, for the next step; refused by backends that can't pass them on.
    fn set_input_rates(&mut self, _references: &[u32], _rates: &[f64]) -> Status {
        Status::Error
    }
    fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>)
    -> Status;
    fn enter_initialization(&mut self) -> Status;
    fn exit_initialization(&mut self) -> Status;
    fn do_step(&mut self, time: f64, step: f64) -> Status;
    fn reset(&mut self) -> Status;
    fn terminate(&mut self) -> Status;
    /// Saves the state in a new slot.
    fn save_state(&mut self) -> Result<usize, Status>;
    /// Saves the state in an existing slot.
    fn overwrite_state(&mut self, slot: usize) -> Status;
    fn restore_state(&mut self, slot: usize) -> Status;
    fn serialize_state(&mut self, slot: usize) -> Result<Vec<u8>, Status>;
    /// Puts a serialised state in a new slot.
    fn deserialize_state(&mut self, bytes: &[u8]) -> Result<usize, Status>;
}

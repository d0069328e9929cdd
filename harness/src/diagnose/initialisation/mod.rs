//! Where fits start: spectra, grids, score tests, several starts.

pub(crate) mod effect_response;
pub mod expected_gain;
pub mod first_fits;
pub mod force_spectrum;
pub mod free_characteristic;
pub mod multistart;
pub(crate) mod projected_out;
pub mod response_spectrum;
pub(crate) mod responses;
pub mod score_test;
pub mod search_options;
pub mod shape_grid;
pub mod starts;
pub(crate) mod subset_regression;
pub mod wave_fit;

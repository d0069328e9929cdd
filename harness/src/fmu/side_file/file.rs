//! The tables of a side file as they are written.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Raw {
    pub friction_coefficient: Option<Spanned<f64>>,
    #[serde(default)]
    pub variables: BTreeMap<Spanned<String>, Spanned<String>>,
    #[serde(default)]
    pub state: Vec<RawState>,
    #[serde(default)]
    pub constant: Vec<RawConstant>,
    #[serde(default)]
    pub effect: Vec<RawEffect>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawState {
    pub start: Spanned<String>,
    pub value: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawConstant {
    pub variable: Spanned<String>,
    pub value: Option<f64>,
    pub std: Option<f64>,
    pub std_absolute: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    #[serde(default)]
    pub per_run: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEffect {
    pub id: Spanned<String>,
    pub title: String,
    #[serde(default)]
    pub equation: String,
    #[serde(default)]
    pub description: String,
    #[serde(default)]
    pub source: String,
    #[serde(default)]
    pub signature: String,
    #[serde(default)]
    pub confounders: String,
    pub parameter: Vec<RawParameter>,
    #[serde(default)]
    pub state: Vec<RawEffectState>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawParameter {
    pub name: Option<String>,
    pub variable: Spanned<String>,
    pub role: Spanned<String>,
    pub typical: f64,
    pub min: f64,
    pub max: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEffectState {
    pub name: Option<String>,
    pub variable: Spanned<String>,
    pub nominal: f64,
}

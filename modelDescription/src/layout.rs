//! Lookup of variables by value reference and by name.

use crate::table::variables;
use std::collections::HashMap;
use std::sync::LazyLock;

/// Marks a value reference without variable.
const NONE: u16 = u16::MAX;

static BY_REFERENCE: LazyLock<Vec<u16>> = LazyLock::new(|| {
    let last = variables().iter().map(|v| v.reference).max().unwrap_or(0);
    let mut map = vec![NONE; last as usize + 1];
    for (index, variable) in variables().iter().enumerate() {
        map[variable.reference as usize] = index as u16;
    }
    map
});

static BY_NAME: LazyLock<HashMap<&'static str, usize>> = LazyLock::new(|| {
    variables()
        .iter()
        .enumerate()
        .map(|(index, v)| (v.name.as_str(), index))
        .collect()
});

/// Index in the table of the variable with a value reference.
#[inline]
pub fn index_of_reference(reference: u32) -> Option<usize> {
    match BY_REFERENCE.get(reference as usize) {
        Some(&index) if index != NONE => Some(index as usize),
        _ => None,
    }
}

/// Index in the table of the variable with a name.
pub fn index_of_name(name: &str) -> Option<usize> {
    BY_NAME.get(name).copied()
}

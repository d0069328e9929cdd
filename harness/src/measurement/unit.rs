//! Units as headers write them: `x [mm]`, `x (mm)`, `t/ms`, or a row of units below the names.

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Time,
    Length,
    Velocity,
    Acceleration,
    Force,
    Voltage,
    Other,
}

impl Quantity {
    pub fn words(self) -> &'static str {
        match self {
            Quantity::Time => "a time",
            Quantity::Length => "a length",
            Quantity::Velocity => "a velocity",
            Quantity::Acceleration => "an acceleration",
            Quantity::Force => "a force",
            Quantity::Voltage => "a voltage",
            Quantity::Other => "another quantity",
        }
    }

    /// Its SI unit; `None` for other quantities, whose units keep their values.
    pub fn si(self) -> Option<&'static str> {
        match self {
            Quantity::Time => Some("s"),
            Quantity::Length => Some("m"),
            Quantity::Velocity => Some("m/s"),
            Quantity::Acceleration => Some("m/s2"),
            Quantity::Force => Some("N"),
            Quantity::Voltage => Some("V"),
            Quantity::Other => None,
        }
    }
}

/// A unit with the factor that turns its values into SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unit {
    pub symbol: &'static str,
    pub quantity: Quantity,
    pub factor: f64,
}

const fn unit(symbol: &'static str, quantity: Quantity, factor: f64) -> Unit {
    Unit {
        symbol,
        quantity,
        factor,
    }
}

use Quantity::{Acceleration, Force, Length, Other, Time, Velocity, Voltage};

/// The units known. Both signs for micro are replaced by `u` before a unit is looked up.
const UNITS: [Unit; 43] = [
    unit("s", Time, 1.0),
    unit("sec", Time, 1.0),
    unit("second", Time, 1.0),
    unit("seconds", Time, 1.0),
    unit("ms", Time, 1e-3),
    unit("us", Time, 1e-6),
    unit("ns", Time, 1e-9),
    unit("min", Time, 60.0),
    unit("m", Length, 1.0),
    unit("cm", Length, 1e-2),
    unit("mm", Length, 1e-3),
    unit("um", Length, 1e-6),
    unit("micron", Length, 1e-6),
    unit("nm", Length, 1e-9),
    unit("inch", Length, 0.0254),
    unit("mil", Length, 2.54e-5),
    unit("m/s", Velocity, 1.0),
    unit("mm/s", Velocity, 1e-3),
    unit("um/s", Velocity, 1e-6),
    unit("m/s^2", Acceleration, 1.0),
    unit("m/s2", Acceleration, 1.0),
    unit("m/s\u{b2}", Acceleration, 1.0),
    unit("m/s**2", Acceleration, 1.0),
    unit("mm/s^2", Acceleration, 1e-3),
    unit("g", Acceleration, 9.806_65),
    unit("N", Force, 1.0),
    unit("kN", Force, 1e3),
    unit("mN", Force, 1e-3),
    unit("lbf", Force, 4.448_222),
    unit("V", Voltage, 1.0),
    unit("mV", Voltage, 1e-3),
    unit("volt", Voltage, 1.0),
    unit("volts", Voltage, 1.0),
    unit("A", Other, 1.0),
    unit("Hz", Other, 1.0),
    unit("rad", Other, 1.0),
    unit("deg", Other, 1.0),
    unit("\u{b0}", Other, 1.0),
    unit("\u{b0}C", Other, 1.0),
    unit("degC", Other, 1.0),
    unit("rpm", Other, 1.0),
    unit("%", Other, 1.0),
    unit("1", Other, 1.0),
];

/// The factor that turns values of a unit into SI; `None` for a unit that is not known.
pub(crate) fn factor_to_si(text: &str) -> Option<f64> {
    find(text).map(|unit| unit.factor)
}

/// The unit that `text` is, exactly or but for capitals.
pub(super) fn find(text: &str) -> Option<Unit> {
    let text = text.trim().replace(['\u{b5}', '\u{3bc}'], "u");
    let exact = UNITS.iter().find(|unit| unit.symbol == text);
    let or_capitals = || {
        UNITS
            .iter()
            .find(|unit| unit.symbol.eq_ignore_ascii_case(&text))
    };
    exact.or_else(or_capitals).copied()
}

/// A cell of a row of units: a unit, bare or in brackets.
pub(super) fn of_cell(cell: &str) -> Option<Unit> {
    let cell = cell.trim();
    let bare = cell
        .strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']'))
        .or_else(|| cell.strip_prefix('(').and_then(|r| r.strip_suffix(')')));
    find(bare.unwrap_or(cell))
}

/// A column's name as the header has it, taken apart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Name {
    /// As the file has it.
    pub full: String,
    /// Without the unit.
    pub bare: String,
    pub unit: Option<Unit>,
}

impl Name {
    /// Takes a name apart: `x [mm]`, `x (mm)`, `x/mm`. What is no known unit stays part of the
    /// name.
    pub fn read(full: &str) -> Name {
        let in_brackets = |open: char, close: char| {
            let inside = full.strip_suffix(close)?;
            let (bare, unit) = inside.rsplit_once(open)?;
            Some((bare, find(unit)?))
        };
        let after_slash = || {
            let (bare, unit) = full.split_once('/')?;
            let bracketed = unit.strip_prefix('(').and_then(|u| u.strip_suffix(')'));
            Some((bare, find(bracketed.unwrap_or(unit))?))
        };
        let parts = in_brackets('[', ']')
            .or_else(|| in_brackets('(', ')'))
            .or_else(after_slash);
        let (bare, unit) = parts.map_or((full, None), |(bare, unit)| (bare, Some(unit)));
        Name {
            full: full.to_owned(),
            bare: bare.trim_end_matches('/').trim().to_owned(),
            unit,
        }
    }

    /// Whether a name in campaign.toml means this column.
    pub fn is(&self, wanted: &str) -> bool {
        self.full == wanted || (!self.bare.is_empty() && self.bare == wanted)
    }

    pub fn measures(&self, quantity: Quantity) -> bool {
        self.unit.is_some_and(|unit| unit.quantity == quantity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_in_brackets_and_behind_a_slash_are_taken_off_the_name() {
        let cases = [
            ("x [mm]", "x", Some(1e-3)),
            ("laser (\u{b5}m)", "laser", Some(1e-6)),
            ("t/ms", "t", Some(1e-3)),
            ("v/(mm/s)", "v", Some(1e-3)),
            ("v/m/s", "v", Some(1.0)),
            ("a [g]", "a", Some(9.806_65)),
            ("[s]", "", Some(1.0)),
            ("force/weight", "force/weight", None),
            ("w (tip)", "w (tip)", None),
            ("tip_displacement_m", "tip_displacement_m", None),
        ];
        for (full, bare, factor) in cases {
            let name = Name::read(full);
            assert_eq!(name.bare, bare, "{full}");
            assert_eq!(name.unit.map(|u| u.factor), factor, "{full}");
            assert!(name.is(full));
        }
    }

    #[test]
    fn capitals_decide_between_units_that_differ_by_them_alone() {
        assert_eq!(find("mN").unwrap().factor, 1e-3);
        assert_eq!(find("MM").unwrap().quantity, Quantity::Length);
        assert_eq!(of_cell("(S)").unwrap().quantity, Quantity::Time);
        assert_eq!(of_cell("x"), None);
    }
}

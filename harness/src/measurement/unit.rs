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

/// Standard acceleration of gravity, m/s^2.
const G: f64 = 9.806_65;

/// The units known, as [`spelled`] writes them.
const UNITS: [Unit; 71] = [
    unit("s", Time, 1.0),
    unit("sec", Time, 1.0),
    unit("second", Time, 1.0),
    unit("seconds", Time, 1.0),
    unit("ms", Time, 1e-3),
    unit("us", Time, 1e-6),
    unit("ns", Time, 1e-9),
    unit("min", Time, 60.0),
    unit("m", Length, 1.0),
    unit("dm", Length, 1e-1),
    unit("cm", Length, 1e-2),
    unit("mm", Length, 1e-3),
    unit("um", Length, 1e-6),
    unit("micron", Length, 1e-6),
    unit("nm", Length, 1e-9),
    unit("inch", Length, 0.0254),
    unit("mil", Length, 2.54e-5),
    unit("thou", Length, 2.54e-5),
    unit("ft", Length, 0.3048),
    unit("m/s", Velocity, 1.0),
    unit("cm/s", Velocity, 1e-2),
    unit("mm/s", Velocity, 1e-3),
    unit("um/s", Velocity, 1e-6),
    unit("nm/s", Velocity, 1e-9),
    unit("m/min", Velocity, 1.0 / 60.0),
    unit("mm/min", Velocity, 1e-3 / 60.0),
    unit("km/h", Velocity, 1.0 / 3.6),
    unit("in/s", Velocity, 0.0254),
    unit("inch/s", Velocity, 0.0254),
    unit("ips", Velocity, 0.0254),
    unit("ft/s", Velocity, 0.3048),
    unit("m/s^2", Acceleration, 1.0),
    unit("cm/s^2", Acceleration, 1e-2),
    unit("mm/s^2", Acceleration, 1e-3),
    unit("um/s^2", Acceleration, 1e-6),
    unit("in/s^2", Acceleration, 0.0254),
    unit("ft/s^2", Acceleration, 0.3048),
    unit("Gal", Acceleration, 1e-2),
    unit("g", Acceleration, G),
    unit("gn", Acceleration, G),
    unit("mg", Acceleration, 1e-3 * G),
    unit("ug", Acceleration, 1e-6 * G),
    unit("N", Force, 1.0),
    unit("kN", Force, 1e3),
    unit("daN", Force, 10.0),
    unit("mN", Force, 1e-3),
    unit("uN", Force, 1e-6),
    unit("nN", Force, 1e-9),
    unit("kgf", Force, G),
    unit("kp", Force, G),
    unit("gf", Force, 1e-3 * G),
    unit("lbf", Force, 4.448_222),
    unit("V", Voltage, 1.0),
    unit("kV", Voltage, 1e3),
    unit("mV", Voltage, 1e-3),
    unit("uV", Voltage, 1e-6),
    unit("volt", Voltage, 1.0),
    unit("volts", Voltage, 1.0),
    unit("A", Other, 1.0),
    unit("mA", Other, 1.0),
    unit("Hz", Other, 1.0),
    unit("kHz", Other, 1.0),
    unit("rad", Other, 1.0),
    unit("mrad", Other, 1.0),
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

/// Words for units, and the symbols that stand for them.
const WORDS: [(&str, &str); 21] = [
    ("meter", "m"),
    ("meters", "m"),
    ("metre", "m"),
    ("metres", "m"),
    ("millimeter", "mm"),
    ("millimeters", "mm"),
    ("millimetre", "mm"),
    ("millimetres", "mm"),
    ("micrometer", "um"),
    ("micrometers", "um"),
    ("micrometre", "um"),
    ("micrometres", "um"),
    ("microns", "micron"),
    ("in", "inch"),
    ("inches", "inch"),
    ("millisecond", "ms"),
    ("milliseconds", "ms"),
    ("microseconds", "us"),
    ("newton", "N"),
    ("newtons", "N"),
    ("kilonewton", "kN"),
];

/// How "by second squared" and "by second" are written, and how [`UNITS`] does. What comes first counts.
const BY_SECONDS: [(&str, &str); 12] = [
    ("/second^2", "/s^2"),
    ("/sec^2", "/s^2"),
    ("/sec2", "/s^2"),
    ("/s2", "/s^2"),
    ("/s/s", "/s^2"),
    ("s^-2", "/s^2"),
    ("s-2", "/s^2"),
    ("/second", "/s"),
    ("/sec", "/s"),
    ("s^-1", "/s"),
    ("s-1", "/s"),
    ("/s^2", "/s^2"),
];

/// A unit in the spelling of [`UNITS`]: `u` for both signs of micro, symbols for words, `m/s^2` for `m/s2`, `m/s**2`, `m/s/s`, `m/sec^2`,
/// `m s^-2`, `ms-2` and those with raised digits.
fn spelled(text: &str) -> String {
    let text = text.trim().replace(['\u{b5}', '\u{3bc}'], "u");
    let text = text.replace("\u{207b}", "-").replace('\u{b9}', "1");
    let text = text.replace("**", "^").replace('\u{b2}', "2");
    if let Some((_, symbol)) = WORDS.iter().find(|w| w.0.eq_ignore_ascii_case(&text)) {
        return (*symbol).to_owned();
    }
    let lower = text.to_ascii_lowercase();
    for (end, divided) in BY_SECONDS {
        if let Some(of) = lower.strip_suffix(end) {
            let of = text[..of.len()].trim_end_matches([' ', '.', '*', '\u{b7}', '\u{22c5}']);
            return match of {
                "" => text,
                of => format!("{of}{divided}"),
            };
        }
    }
    text
}

/// The unit that `text` is, exactly or but for capitals.
pub(super) fn find(text: &str) -> Option<Unit> {
    let text = spelled(text);
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
    /// What stands in square brackets at the end and is no unit that is known: text other than a number, which counts channels.
    pub strange: Option<String>,
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
            // `v m/s` has its unit behind the blank.
            let behind = bare.rsplit_once(' ');
            let of_two = behind.and_then(|(bare, of)| Some((bare, find(&format!("{of}/{unit}"))?)));
            of_two.or_else(|| Some((bare, find(bracketed.unwrap_or(unit))?)))
        };
        let parts = in_brackets('[', ']')
            .or_else(|| in_brackets('(', ')'))
            .or_else(after_slash);
        let (bare, unit) = parts.map_or((full, None), |(bare, unit)| (bare, Some(unit)));
        let bracketed = full.strip_suffix(']').and_then(|f| f.rsplit_once('['));
        let strange = bracketed
            .map(|(_, inside)| inside.trim())
            .filter(|inside| unit.is_none() && inside.parse::<f64>().is_err())
            .filter(|inside| !inside.is_empty());
        Name {
            full: full.to_owned(),
            bare: bare.trim_end_matches('/').trim().to_owned(),
            unit,
            strange: strange.map(str::to_owned),
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
            ("v km/h", "v", Some(1.0 / 3.6)),
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
    fn brackets_without_a_known_unit_are_strange() {
        let strange = |full| Name::read(full).strange;
        assert_eq!(strange("force [stone]").as_deref(), Some("stone"));
        for full in ["force [uN]", "channel [3]", "w (tip)", "w []", "w"] {
            assert_eq!(strange(full), None, "{full}");
        }
    }

    #[test]
    fn spellings_of_one_unit_are_one() {
        let cases = [
            (
                "m/s2,m/s^2,m/s**2,m/s\u{b2},m/sec^2,m/s/s,m.s-2,m s^-2,ms-2,M/S2,m\u{b7}s\u{207b}\u{b2}",
                1.0,
            ),
            ("mm/s2,mm/s^2,mm/s/s,mm/s\u{b2},MM/S2", 1e-3),
            ("mm/s,mm/sec,mm/second,mm s-1,mm/SEC", 1e-3),
            ("\u{b5}N,\u{3bc}N,uN", 1e-6),
            ("m/min,M/MIN", 1.0 / 60.0),
            ("in,inch,inches", 0.0254),
        ];
        for (spellings, factor) in cases {
            for text in spellings.split(',') {
                assert_eq!(find(text).map(|u| u.factor), Some(factor), "{text}");
            }
        }
        for text in ["s-2", "s^-1", "/s", "1/s", "K", "H"] {
            assert_eq!(find(text), None, "{text}");
        }
    }

    #[test]
    fn capitals_decide_between_units_that_differ_by_them_alone() {
        assert_eq!(find("mN").unwrap().factor, 1e-3);
        assert_eq!(find("mn").unwrap().factor, 1e-3);
        assert_eq!(find("MM").unwrap().quantity, Quantity::Length);
        assert_eq!(of_cell("(S)").unwrap().quantity, Quantity::Time);
        assert_eq!(of_cell("x"), None);
    }
}

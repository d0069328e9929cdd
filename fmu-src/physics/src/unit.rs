//! Units as exponents of the SI base units.

/// A unit: symbol and exponents of kg, m, s and rad.
///
/// Every value of this project is in SI; a unit is only a label for people and tools.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    /// Symbol in the notation of the FMI standard, e.g. `N.s2/m2`.
    pub symbol: &'static str,
    /// Exponent of the kilogram.
    pub kg: i32,
    /// Exponent of the metre.
    pub m: i32,
    /// Exponent of the second.
    pub s: i32,
    /// Exponent of the radian.
    pub rad: i32,
}

impl Unit {
    /// The unit of a rate of change.
    ///
    /// # Panics
    /// If it is not among [`ALL`].
    pub fn per_second(self) -> Self {
        let is_it = |u: &&Self| (u.kg, u.m, u.s, u.rad) == (self.kg, self.m, self.s - 1, self.rad);
        let found = ALL.iter().find(is_it).copied();
        found.unwrap_or_else(|| panic!("list the unit of rates of {}", self.symbol))
    }
}

const fn unit(symbol: &'static str, kg: i32, m: i32, s: i32, rad: i32) -> Unit {
    Unit {
        symbol,
        kg,
        m,
        s,
        rad,
    }
}

/// Dimensionless.
pub const ONE: Unit = unit("1", 0, 0, 0, 0);
/// Metre.
pub const METRE: Unit = unit("m", 0, 1, 0, 0);
/// Per metre.
pub const PER_METRE: Unit = unit("1/m", 0, -1, 0, 0);
/// Second.
pub const SECOND: Unit = unit("s", 0, 0, 1, 0);
/// Second per metre.
pub const SECOND_PER_METRE: Unit = unit("s/m", 0, -1, 1, 0);
/// Metre per second.
pub const METRE_PER_SECOND: Unit = unit("m/s", 0, 1, -1, 0);
/// Metre per second squared.
pub const METRE_PER_SECOND2: Unit = unit("m/s2", 0, 1, -2, 0);
/// Kilogram.
pub const KILOGRAM: Unit = unit("kg", 1, 0, 0, 0);
/// Newton.
pub const NEWTON: Unit = unit("N", 1, 1, -2, 0);
/// Per newton.
pub const PER_NEWTON: Unit = unit("1/N", -1, -1, 2, 0);
/// Newton per metre.
pub const NEWTON_PER_METRE: Unit = unit("N/m", 1, 0, -2, 0);
/// Newton per cubic metre.
pub const NEWTON_PER_METRE3: Unit = unit("N/m3", 1, -2, -2, 0);
/// Newton second per metre.
pub const NEWTON_SECOND_PER_METRE: Unit = unit("N.s/m", 1, 0, -1, 0);
/// Newton second squared per square metre.
pub const NEWTON_SECOND2_PER_METRE2: Unit = unit("N.s2/m2", 1, -1, 0, 0);
/// Hertz.
pub const HERTZ: Unit = unit("Hz", 0, 0, -1, 0);
/// One per second: a rate of decay.
pub const PER_SECOND: Unit = unit("1/s", 0, 0, -1, 0);
/// Radian.
pub const RADIAN: Unit = unit("rad", 0, 0, 0, 1);
/// Joule.
pub const JOULE: Unit = unit("J", 1, 2, -2, 0);
/// Watt.
pub const WATT: Unit = unit("W", 1, 2, -3, 0);

/// Every unit in use, for tables of units.
pub const ALL: &[Unit] = &[
    ONE,
    METRE,
    PER_METRE,
    SECOND,
    SECOND_PER_METRE,
    METRE_PER_SECOND,
    METRE_PER_SECOND2,
    KILOGRAM,
    NEWTON,
    PER_NEWTON,
    NEWTON_PER_METRE,
    NEWTON_PER_METRE3,
    NEWTON_SECOND_PER_METRE,
    NEWTON_SECOND2_PER_METRE2,
    HERTZ,
    PER_SECOND,
    RADIAN,
    JOULE,
    WATT,
];

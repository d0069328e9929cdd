//! Declared types: one per unit, so that tools show quantities by name, and the enumerations.

use beam_physics::unit::Unit;

/// Name and description of the declared type of a unit, by the unit's symbol.
const BY_UNIT: [(&str, &str, &str); 19] = [
    ("1", "Number", "Dimensionless number"),
    ("m", "Length", "Length or displacement"),
    ("1/m", "PerLength", "Change per length"),
    ("s", "Time", "Time"),
    ("s/m", "Slowness", "Change per speed"),
    ("m/s", "Velocity", "Velocity"),
    ("m/s2", "Acceleration", "Acceleration"),
    ("kg", "Mass", "Mass"),
    ("N", "Force", "Force"),
    ("1/N", "PerForce", "Change per force"),
    ("N/m", "Stiffness", "Stiffness"),
    ("N/m3", "CubicStiffness", "Force per cube of a displacement"),
    ("N.s/m", "Damping", "Force per velocity"),
    ("N.s2/m2", "QuadraticDrag", "Force per square of a velocity"),
    ("Hz", "Frequency", "Frequency"),
    ("1/s", "DampingRate", "Viscous damping per mass"),
    ("rad", "Angle", "Angle"),
    ("J", "Energy", "Energy"),
    ("W", "Power", "Power"),
];

/// The declared type of a unit: its name and description.
pub fn of_unit(unit: Unit) -> Option<(&'static str, &'static str)> {
    BY_UNIT
        .iter()
        .find(|row| row.0 == unit.symbol)
        .map(|row| (row.1, row.2))
}

/// One item of an enumeration: name, value, description.
pub type Item = (&'static str, i32, &'static str);

/// The enumerations: name, description, items.
pub const ENUMERATIONS: [(&str, &str, &[Item]); 4] = [
    (
        "ContactMode",
        "Mode of the contact",
        &[
            (
                "BackwardSlip",
                -1,
                "Slip, the tip lags behind the belt (v_r < 0)",
            ),
            ("Stick", 0, "Stick (v_r = 0)"),
            (
                "ForwardSlip",
                1,
                "Slip, the tip overtakes the belt (v_r > 0)",
            ),
            (
                "Bristle",
                2,
                "A friction law with memory that knows no modes",
            ),
        ],
    ),
    (
        "FrictionLaw",
        "Friction law",
        &[
            (
                "Stelter",
                1,
                "Stelter 1992, eq. (7), exponent read as -v/v1",
            ),
            (
                "StelterAsPrinted",
                2,
                "Stelter 1992, eq. (7) as printed, exponent -v1/v: rises with speed, nothing vibrates by itself",
            ),
            ("Coulomb", 3, "Static and constant kinetic coefficient"),
            ("Stribeck", 4, "Stribeck curve with viscous term"),
            ("Table", 5, "Points joined by monotone cubics"),
        ],
    ),
    (
        "StartContact",
        "Mode of the contact at the start",
        &[
            (
                "Automatic",
                0,
                "Stick where v_r = 0 to rounding and friction can hold the tip",
            ),
            (
                "Stick",
                1,
                "Stick where friction can hold the tip; the velocity is projected on v_r = 0",
            ),
            ("Slip", 2, "Slip"),
        ],
    ),
    (
        "StartEffects",
        "Meaning of the start values of the effects' states",
        &[
            ("Given", 0, "Used as they are"),
            (
                "Settled",
                1,
                "Added to the values in equilibrium with the start motion; a drive that gives way shifts the belt by its displacement",
            ),
        ],
    ),
];

/// Items of an enumeration.
pub fn enumeration(name: &str) -> &'static [Item] {
    ENUMERATIONS
        .iter()
        .find(|row| row.0 == name)
        .map_or(&[], |row| row.2)
}

/// Units in which people like to read a unit: name and factor (display = factor * SI).
pub fn display_units(symbol: &str) -> &'static [(&'static str, f64)] {
    match symbol {
        "m" => &[("mm", 1e3), ("um", 1e6)],
        "m/s" => &[("mm/s", 1e3)],
        "s" => &[("ms", 1e3)],
        "N" => &[("kN", 1e-3)],
        "rad" => &[("deg", 57.295_779_513_082_32)],
        _ => &[],
    }
}

/// The unit in which tools should show a unit at first.
pub fn shown_in(symbol: &str) -> Option<&'static str> {
    matches!(symbol, "m" | "m/s" | "rad").then(|| {
        let units = display_units(symbol);
        units.first().expect("listed above").0
    })
}

//! Whether the units of a formula fit together.
//!
//! Every quantity, parameter and state has a unit; what is added or compared must have one and the same, `exp`, `sin` and the like take
//! plain numbers, and the result must be in the unit of what it stands for. A number written into a formula may stand for a value with
//! any unit (`w/0.001`), so nothing is known of what it multiplies; nor is anything of a unit that is not understood.

use beam_physics::expression::{Expression, Step};

/// Exponents of kg, m, s, K and A.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dimension([f64; 5]);

/// Symbols of the base units, in their order.
const BASE: [&str; 5] = ["kg", "m", "s", "K", "A"];
/// Units with a name of their own: symbol and exponents.
const NAMED: [(&str, [f64; 5]); 14] = [
    ("kg", [1.0, 0.0, 0.0, 0.0, 0.0]),
    ("m", [0.0, 1.0, 0.0, 0.0, 0.0]),
    ("s", [0.0, 0.0, 1.0, 0.0, 0.0]),
    ("K", [0.0, 0.0, 0.0, 1.0, 0.0]),
    ("A", [0.0, 0.0, 0.0, 0.0, 1.0]),
    ("N", [1.0, 1.0, -2.0, 0.0, 0.0]),
    ("Pa", [1.0, -1.0, -2.0, 0.0, 0.0]),
    ("J", [1.0, 2.0, -2.0, 0.0, 0.0]),
    ("W", [1.0, 2.0, -3.0, 0.0, 0.0]),
    ("V", [1.0, 2.0, -3.0, 0.0, -1.0]),
    ("Hz", [0.0, 0.0, -1.0, 0.0, 0.0]),
    ("rad", [0.0; 5]),
    ("1", [0.0; 5]),
    ("-", [0.0; 5]),
];

impl Dimension {
    /// That of a plain number.
    pub const ONE: Self = Self([0.0; 5]);

    /// That of a unit such as `N.s2/m2`: products by `.`, `*` or a space, each `/` before what it divides by, exponents behind the
    /// symbol. `None` for what is not understood.
    pub fn of(unit: &str) -> Option<Self> {
        let mut out = [0.0; 5];
        for (i, part) in unit.split('/').enumerate() {
            let sign = if i == 0 { 1.0 } else { -1.0 };
            for factor in part.split(['.', '*', ' ']).filter(|f| !f.is_empty()) {
                let end = factor
                    .find(|c: char| c.is_ascii_digit() || c == '^' || c == '-')
                    .filter(|end| *end > 0)
                    .unwrap_or(factor.len());
                let (symbol, exponent) = factor.split_at(end);
                let exponent = exponent.trim_start_matches('^');
                let exponent: f64 = if exponent.is_empty() {
                    1.0
                } else {
                    exponent.parse().ok()?
                };
                let (_, of) = NAMED.iter().find(|n| n.0 == symbol)?;
                for (o, e) in out.iter_mut().zip(of) {
                    *o += sign * exponent * e;
                }
            }
        }
        Some(Self(out))
    }

    /// That of a rate of change.
    pub fn per_second(self) -> Self {
        self.times(Self([0.0, 0.0, 1.0, 0.0, 0.0]), -1.0)
    }

    /// Product with a power of another.
    fn times(self, other: Self, power: f64) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + power * other.0[i]))
    }

    fn power(self, exponent: f64) -> Self {
        Self(self.0.map(|e| e * exponent))
    }

    fn fits(self, other: Self) -> bool {
        self.0
            .iter()
            .zip(other.0)
            .all(|(a, b)| (a - b).abs() < 1e-9)
    }

    /// As people write it.
    fn symbol(self) -> String {
        let parts = BASE.iter().zip(self.0).filter(|(_, e)| e.abs() > 1e-9);
        let parts: Vec<String> = parts
            .map(|(s, e)| match e == 1.0 {
                true => (*s).to_owned(),
                false => format!("{s}^{e}"),
            })
            .collect();
        match parts.is_empty() {
            true => "a plain number".to_owned(),
            false => parts.join("."),
        }
    }
}

/// A value on the way: what is known of its unit, and the number if it was written into the formula.
#[derive(Clone, Copy)]
struct Item {
    /// `None` where any unit may be.
    of: Option<Dimension>,
    number: Option<f64>,
}

/// A name in a formula with its unit; `None` where that is not understood.
pub(super) type Named<'a> = (&'a str, Option<Dimension>);

/// Whether the units of a formula fit together and give `wanted`; what can't be compiled is passed over.
///
/// # Errors
/// What does not fit, in words.
pub(super) fn check(
    formula: &str,
    names: &[Named],
    tables: &[Named],
    wanted: Option<Dimension>,
) -> Result<(), String> {
    let quantities: Vec<&str> = names.iter().map(|n| n.0).collect();
    let curves: Vec<&str> = tables.iter().map(|t| t.0).collect();
    let Ok(program) = Expression::compile(formula, &quantities, &curves) else {
        return Ok(());
    };
    let mut stack: Vec<Item> = Vec::new();
    for step in program.steps() {
        let item = match step {
            Step::Number(value) => Item {
                of: None,
                number: Some(value),
            },
            Step::Quantity(i) => Item {
                of: names[i].1,
                number: None,
            },
            Step::Table(i) => {
                stack.pop();
                Item {
                    of: tables[i].1,
                    number: None,
                }
            }
            Step::Unary(name) => unary(name, pop(&mut stack))?,
            Step::Binary(name) => {
                let b = pop(&mut stack);
                binary(name, pop(&mut stack), b)?
            }
            Step::Choose => {
                let b = pop(&mut stack);
                let a = pop(&mut stack);
                pop(&mut stack);
                same("if", a, b)?
            }
        };
        stack.push(item);
    }
    match (pop(&mut stack).of, wanted) {
        (Some(found), Some(wanted)) if !found.fits(wanted) => Err(format!(
            "{formula} is in {}, but what it stands for is in {}",
            found.symbol(),
            wanted.symbol()
        )),
        _ => Ok(()),
    }
}

fn pop(stack: &mut Vec<Item>) -> Item {
    stack.pop().unwrap_or(Item {
        of: None,
        number: None,
    })
}

fn open(of: Option<Dimension>) -> Item {
    Item { of, number: None }
}

/// Two values that must be in one unit, which is that of the result.
fn same(name: &str, a: Item, b: Item) -> Result<Item, String> {
    match (a.of, b.of) {
        (Some(x), Some(y)) if !x.fits(y) => Err(format!(
            "the two sides of '{name}' are in {} and in {}",
            x.symbol(),
            y.symbol()
        )),
        (x, y) => Ok(open(x.or(y))),
    }
}

/// A value that must be a plain number.
fn plain(name: &str, a: Item) -> Result<(), String> {
    match a.of {
        Some(x) if !x.fits(Dimension::ONE) => {
            Err(format!("'{name}' takes a plain number, not {}", x.symbol()))
        }
        _ => Ok(()),
    }
}

fn unary(name: &str, a: Item) -> Result<Item, String> {
    match name {
        "-" | "abs" => Ok(Item {
            of: a.of,
            number: a.number.map(|n| if name == "-" { -n } else { n.abs() }),
        }),
        "sqrt" => Ok(open(a.of.map(|x| x.power(0.5)))),
        "sign" => Ok(open(Some(Dimension::ONE))),
        "floor" => Ok(open(a.of)),
        _ => {
            plain(name, a)?;
            Ok(open(Some(Dimension::ONE)))
        }
    }
}

fn binary(name: &str, a: Item, b: Item) -> Result<Item, String> {
    let product = |sign: f64| open(a.of.zip(b.of).map(|(x, y)| x.times(y, sign)));
    match name {
        "*" => Ok(product(1.0)),
        "/" => Ok(product(-1.0)),
        "^" => {
            plain("^", b)?;
            match b.number {
                Some(exponent) => Ok(open(a.of.map(|x| x.power(exponent)))),
                None => {
                    plain("^", a)?;
                    Ok(open(a.of))
                }
            }
        }
        "+" | "-" | "min" | "max" => same(name, a, b),
        // Comparisons and atan2.
        _ => {
            same(name, a, b)?;
            Ok(open(Some(Dimension::ONE)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_units_are_read_as_they_are_written() {
        // Source: definitions of the derived units (SI brochure, 9th edition, table 4).
        for (a, b) in [
            ("N.s2/m2", "kg.s^0/m^1"),
            ("N s/m", "kg/s"),
            ("W", "N.m/s"),
            ("1/m", "m-1"),
            ("Pa", "N/m2"),
            ("s/m/s", "1/m"),
            ("rad", "1"),
        ] {
            assert!(
                Dimension::of(a).unwrap().fits(Dimension::of(b).unwrap()),
                "{a} {b}"
            );
        }
        assert_eq!(Dimension::of("furlong"), None);
    }

    fn of(formula: &str, unit: &str, wanted: &str) -> Result<(), String> {
        let names = [
            ("w", Dimension::of("m")),
            ("v_r", Dimension::of("m/s")),
            ("c", Dimension::of(unit)),
        ];
        check(
            formula,
            &names,
            &[("g", Dimension::of("N"))],
            Dimension::of(wanted),
        )
    }

    #[test]
    fn what_fits_passes_and_numbers_may_stand_for_anything() {
        for (formula, unit, wanted) in [
            ("1 + c*w", "1/m", "1"),
            ("-c*w^3", "N/m3", "N"),
            ("c*v_r*abs(v_r)", "N.s2/m2", "N"),
            ("1 + 0.3*tanh(w/0.001)", "1", "1"),
            ("1 + c*(1 - exp(-abs(w)/1e-3))", "1", "1"),
            ("c*sqrt(abs(w))", "N/m^0.5", "N"),
            ("table(w, g) + c", "N", "N"),
            ("if(w > 0, c, 2*c)*w", "N/m", "N"),
            ("c*w", "furlong", "N"),
            ("c*max(w, 0)", "N/m", "N"),
        ] {
            assert_eq!(of(formula, unit, wanted), Ok(()), "{formula}");
        }
    }

    #[test]
    fn what_does_not_fit_is_told_in_words() {
        for (formula, unit, wanted, expected) in [
            (
                "1 + c*w",
                "1",
                "1",
                "is in m, but what it stands for is in a plain number",
            ),
            ("-c*w^3", "N/m", "N", "kg.m^3.s^-2"),
            ("exp(w)", "1", "1", "'exp' takes a plain number, not m"),
            (
                "c*(w + v_r)",
                "1",
                "m",
                "the two sides of '+' are in m and in m.s^-1",
            ),
            ("w > v_r", "1", "1", "the two sides of '>'"),
            ("table(w, g)", "1", "m", "kg.m.s^-2"),
        ] {
            let found = of(formula, unit, wanted).unwrap_err();
            assert!(found.contains(expected), "{formula}: {found}");
        }
    }
}

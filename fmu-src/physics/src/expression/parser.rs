//! Reads formulas by recursive descent.

use super::{FUNCTIONS, MAX_DEPTH, Op, Problem};
use crate::real::{Real, ZERO, real, value};

/// -1, 0 or 1; unlike [`f64::signum`], 0 has the sign 0.
pub(super) fn sign(x: Real) -> Real {
    if value(x) == 0.0 { ZERO } else { x.signum() }
}

/// 1 if true, 0 if not.
fn truth(holds: bool) -> Real {
    real(f64::from(u8::from(holds)))
}

fn function(name: &str) -> Option<Op> {
    Some(match name {
        "sin" => Op::Unary("sin", Real::sin),
        "cos" => Op::Unary("cos", Real::cos),
        "tan" => Op::Unary("tan", Real::tan),
        "asin" => Op::Unary("asin", Real::asin),
        "acos" => Op::Unary("acos", Real::acos),
        "atan" => Op::Unary("atan", Real::atan),
        "atan2" => Op::Binary("atan2", Real::atan2),
        "sinh" => Op::Unary("sinh", Real::sinh),
        "cosh" => Op::Unary("cosh", Real::cosh),
        "tanh" => Op::Unary("tanh", Real::tanh),
        "exp" => Op::Unary("exp", Real::exp),
        "ln" => Op::Unary("ln", Real::ln),
        "log10" => Op::Unary("log10", Real::log10),
        "sqrt" => Op::Unary("sqrt", Real::sqrt),
        "abs" => Op::Unary("abs", Real::abs),
        "sign" => Op::Unary("sign", sign),
        "floor" => Op::Unary("floor", Real::floor),
        "min" => Op::Binary("min", Real::min),
        "max" => Op::Binary("max", Real::max),
        "if" => Op::Choose,
        _ => return None,
    })
}

/// Recursive descent; every rule leaves one more value on the stack.
struct Parser<'a> {
    text: &'a str,
    at: usize,
    quantities: &'a [&'a str],
    tables: &'a [&'a str],
    program: Vec<Op>,
    waiting: usize,
    depth: usize,
}

/// Turns a formula into its program.
pub(super) fn parse(text: &str, quantities: &[&str], tables: &[&str]) -> Result<Vec<Op>, Problem> {
    let mut parser = Parser {
        text,
        at: 0,
        quantities,
        tables,
        program: Vec::new(),
        waiting: 0,
        depth: 0,
    };
    parser.comparison()?;
    match parser.peek() {
        None => Ok(parser.program),
        Some(')') => Err(parser.problem("')' without '('")),
        Some(c) => Err(parser.problem(format!("an operator was expected before '{c}'"))),
    }
}

impl Parser<'_> {
    fn problem(&self, text: impl Into<String>) -> Problem {
        Problem {
            column: self.text[..self.at].chars().count() + 1,
            text: text.into(),
        }
    }

    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    /// Takes the symbol if it comes next.
    fn takes(&mut self, symbol: &str) -> bool {
        self.peek();
        let found = self.text[self.at..].starts_with(symbol);
        self.at += if found { symbol.len() } else { 0 };
        found
    }

    fn emit(&mut self, op: Op) -> Result<(), Problem> {
        self.waiting = self.waiting + 1 - op.takes();
        if self.waiting > MAX_DEPTH {
            return Err(self.problem("too long; shorten the formula"));
        }
        self.program.push(op);
        Ok(())
    }

    fn comparison(&mut self) -> Result<(), Problem> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.problem("nested too deeply"));
        }
        self.sum()?;
        for symbol in ["<=", ">=", "<", ">"] {
            if self.takes(symbol) {
                self.sum()?;
                self.emit(Op::Binary(
                    symbol,
                    match symbol {
                        "<=" => |a, b| truth(a <= b),
                        ">=" => |a, b| truth(a >= b),
                        "<" => |a, b| truth(a < b),
                        _ => |a, b| truth(a > b),
                    },
                ))?;
                break;
            }
        }
        self.depth -= 1;
        Ok(())
    }

    fn sum(&mut self) -> Result<(), Problem> {
        self.product()?;
        loop {
            let op = if self.takes("+") {
                Op::Add
            } else if self.takes("-") {
                Op::Subtract
            } else {
                return Ok(());
            };
            self.product()?;
            self.emit(op)?;
        }
    }

    fn product(&mut self) -> Result<(), Problem> {
        self.signed()?;
        loop {
            let op = if self.takes("*") {
                Op::Multiply
            } else if self.takes("/") {
                Op::Divide
            } else {
                return Ok(());
            };
            self.signed()?;
            self.emit(op)?;
        }
    }

    fn signed(&mut self) -> Result<(), Problem> {
        let mut negative = false;
        loop {
            if self.takes("-") {
                negative = !negative;
            } else if !self.takes("+") {
                break;
            }
        }
        self.power()?;
        if negative {
            self.emit(Op::Negate)?;
        }
        Ok(())
    }

    fn power(&mut self) -> Result<(), Problem> {
        self.atom()?;
        if self.takes("^") || self.takes("**") {
            self.depth += 1;
            if self.depth > MAX_DEPTH {
                return Err(self.problem("nested too deeply"));
            }
            self.signed()?;
            self.depth -= 1;
            self.emit(Op::Power)?;
        }
        Ok(())
    }

    fn atom(&mut self) -> Result<(), Problem> {
        match self.peek() {
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.name(),
            Some('(') => {
                self.takes("(");
                self.comparison()?;
                self.close()
            }
            Some(c) => Err(self.problem(format!("a value was expected instead of '{c}'"))),
            None => Err(self.problem("the formula ends where a value was expected")),
        }
    }

    fn close(&mut self) -> Result<(), Problem> {
        if self.takes(")") {
            Ok(())
        } else {
            Err(self.problem("')' was expected"))
        }
    }

    fn number(&mut self) -> Result<(), Problem> {
        let rest = &self.text[self.at..];
        let bytes = rest.as_bytes();
        let digits = |from: usize| {
            let more = bytes[from..].iter();
            from + more
                .take_while(|b| b.is_ascii_digit() || **b == b'.')
                .count()
        };
        let mut end = digits(0);
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let exponent = digits(end + 1 + sign);
            if exponent > end + 1 + sign {
                end = exponent;
            }
        }
        match rest[..end].parse() {
            Ok(value) if f64::is_finite(value) => {
                self.at += end;
                self.emit(Op::Number(real(value)))
            }
            _ => Err(self.problem(format!("'{}' is not a number", &rest[..end]))),
        }
    }

    fn name(&mut self) -> Result<(), Problem> {
        let rest = &self.text[self.at..];
        let end = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(rest.len());
        let name = &rest[..end];
        if let Some(index) = self.quantities.iter().position(|q| *q == name) {
            self.at += end;
            return self.emit(Op::Quantity(index));
        }
        if name == "pi" {
            self.at += end;
            return self.emit(Op::Number(real(std::f64::consts::PI)));
        }
        if name == "table" {
            self.at += end;
            return self.table();
        }
        let Some(&(_, count)) = FUNCTIONS.iter().find(|f| f.0 == name) else {
            return Err(self.unknown(name));
        };
        let op = function(name).expect("every function of the table has its operation");
        self.at += end;
        if !self.takes("(") {
            return Err(self.problem(format!("'(' was expected after '{name}'")));
        }
        for i in 0..count {
            if i > 0 && !self.takes(",") {
                return Err(
                    self.problem(format!("'{name}' takes {count} values: ',' was expected"))
                );
            }
            self.comparison()?;
        }
        if self.takes(",") {
            return Err(self.problem(format!("'{name}' takes {count} values")));
        }
        self.close()?;
        self.emit(op)
    }

    /// The rest of `table(x, name)`.
    fn table(&mut self) -> Result<(), Problem> {
        if !self.takes("(") {
            return Err(self.problem("'(' was expected after 'table'"));
        }
        self.comparison()?;
        if !self.takes(",") {
            return Err(self.problem("'table' takes a value and the name of a table"));
        }
        self.peek();
        let rest = &self.text[self.at..];
        let end = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(rest.len());
        let Some(index) = self.tables.iter().position(|t| *t == &rest[..end]) else {
            let known = match self.tables {
                [] => "there is none".to_owned(),
                tables => format!("known are {}", tables.join(", ")),
            };
            return Err(self.problem(format!("unknown table '{}'; {known}", &rest[..end])));
        };
        self.at += end;
        self.close()?;
        self.emit(Op::Table(index))
    }

    fn unknown(&self, name: &str) -> Problem {
        let functions: Vec<&str> = FUNCTIONS.iter().map(|f| f.0).collect();
        // What a formula may not use has no name.
        let quantities = self.quantities.iter().copied();
        let named: Vec<&str> = quantities.filter(|q| !q.is_empty()).collect();
        let hint = if name == "log" {
            "ln is the natural logarithm, log10 the decimal one".to_owned()
        } else {
            format!(
                "known are {}, pi and the functions {}",
                named.join(", "),
                functions.join(", ")
            )
        };
        self.problem(format!("unknown name '{name}'; {hint}"))
    }
}

//! Numbers for people: few digits, and prefixes instead of powers of ten.

/// `value` with `digits` significant digits; very large and small ones as 1.2e-9.
pub fn number(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-4..6).contains(&exponent) {
        return format!("{value:.*e}", digits.saturating_sub(1));
    }
    let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A share in percent: `2.35 %`, and with two digits where two decimals would leave less: `0.012 %`.
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        small if small.abs() < 0.1 => format!("{} %", number(small, 2)),
        value => format!("{value:.2} %"),
    }
}

/// `value` of an SI `unit` with three digits and a prefix: `1.23 mm`. Units of 1 get no prefix.
pub fn with_unit(value: f64, unit: &str) -> String {
    if unit == "1" || unit.is_empty() {
        return number(value, 3);
    }
    let prefixes = [
        (1e6, "M"),
        (1e3, "k"),
        (1.0, ""),
        (1e-3, "m"),
        (1e-6, "µ"),
        (1e-9, "n"),
        (1e-12, "p"),
    ];
    // Half of the last digit shown, so that 999.96 becomes 1 k and not 1000.
    let size = value.abs() * 1.0005;
    let fitting = prefixes.iter().find(|(factor, _)| size >= *factor);
    match fitting {
        Some((factor, prefix)) if value.is_finite() && size < 1e9 => {
            format!("{} {prefix}{unit}", number(value / factor, 3))
        }
        _ => format!("{} {unit}", number(value, 3)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let shown: Vec<String> = [0.0, 1.0, 0.033_333, 12345.6, 1.5e-7, -2.50, f64::NAN]
            .iter()
            .map(|v| number(*v, 3))
            .collect();
        assert_eq!(shown, ["0", "1", "0.0333", "12346", "1.50e-7", "-2.5", "–"]);
    }

    #[test]
    fn units_get_prefixes() {
        let shown = [
            with_unit(0.00123, "m"),
            with_unit(999.96, "Hz"),
            with_unit(-6.4e-7, "m"),
            with_unit(0.5, "1"),
            with_unit(0.0, "N"),
        ];
        assert_eq!(shown, ["1.23 mm", "1 kHz", "-640 nm", "0.5", "0 N"]);
    }
}

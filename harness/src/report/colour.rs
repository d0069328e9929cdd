//! The palette: Okabe and Ito's colours, which colour-blind readers tell apart.

/// A colour by role; the values are in `style.css`, for light and dark mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Colour {
    /// Text colour; use it for measured data.
    Ink,
    Grey,
    Blue,
    Orange,
    Green,
    Red,
    Purple,
    Sky,
}

impl Colour {
    /// In this order for series without a meaning of their own.
    pub const SERIES: [Colour; 6] = [
        Colour::Blue,
        Colour::Orange,
        Colour::Green,
        Colour::Purple,
        Colour::Red,
        Colour::Sky,
    ];

    /// All of them.
    pub(super) const ALL: [Colour; 8] = [
        Colour::Ink,
        Colour::Grey,
        Colour::Blue,
        Colour::Orange,
        Colour::Green,
        Colour::Red,
        Colour::Purple,
        Colour::Sky,
    ];

    /// Its value in light mode, `#rrggbb`.
    pub(super) fn hex(self) -> &'static str {
        match self {
            Colour::Ink => "#1b1f24",
            Colour::Grey => "#7f868e",
            Colour::Blue => "#0072b2",
            Colour::Orange => "#d55e00",
            Colour::Green => "#009e73",
            Colour::Red => "#b3261e",
            Colour::Purple => "#aa4499",
            Colour::Sky => "#3d97d0",
        }
    }

    /// The same with an opacity of 0 to 1, `#rrggbbaa`.
    pub(super) fn translucent(self, opacity: f64) -> String {
        format!("{}{:02x}", self.hex(), (255.0 * opacity).round() as u8)
    }

    pub(super) fn css(self) -> &'static str {
        match self {
            Colour::Ink => "var(--ink)",
            Colour::Grey => "var(--grey)",
            Colour::Blue => "var(--blue)",
            Colour::Orange => "var(--orange)",
            Colour::Green => "var(--green)",
            Colour::Red => "var(--red)",
            Colour::Purple => "var(--purple)",
            Colour::Sky => "var(--sky)",
        }
    }
}

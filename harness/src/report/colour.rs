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

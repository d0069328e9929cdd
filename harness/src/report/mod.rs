//! A small layer for self-contained HTML reports with inline SVG: no network, no script.
//!
//! ```
//! use stickslip::report::{Axis, Colour, Page, Plot};
//! let plot = Plot::new(Axis::linear("time", "s"), Axis::linear("tip displacement", "mm"))
//!     .line("measured", Colour::Ink, &[0.0, 1.0, 2.0], &[0.1, 0.3, 0.2])
//!     .shade("stick", Colour::Blue, &[(0.5, 1.5)])
//!     .caption("One sentence that says what the picture shows.");
//! let html = Page::new("Title", "What this is about.").section("A section").figure(&plot).html();
//! assert!(html.contains("<svg"));
//! ```
//!
//! Pictures: [`Plot`] (lines, points, bands, shaded intervals; linear and log axes), [`Bars`], [`Matrix`]. Every one
//! needs axes with units and a caption; colours are safe for colour-blind readers and follow light and dark mode.

mod axis;
mod bars;
mod colour;
#[cfg(test)]
mod contrast;
mod layer;
mod matrix;
mod number;
mod page;
mod plot;
mod standalone;
mod stroke;
mod svg;
mod table;

pub use axis::Axis;
pub use bars::Bars;
pub use colour::Colour;
pub use matrix::Matrix;
pub use number::{number, with_unit};
pub use page::{Figure, Page};
pub use plot::Plot;
pub use standalone::svg_file;
pub use table::{Cell, Table};

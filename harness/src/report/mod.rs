//! Self-contained HTML reports: figures that Plotly draws, from disk and without a network.
//!
//! ```
//! use stickslip::report::{Axis, Colour, Figure, Page, Plot};
//! let plot = Plot::new(Axis::linear("time", "s"), Axis::linear("tip displacement", "mm"))
//!     .line("measured", Colour::Ink, &[0.0, 1.0, 2.0], &[0.1, 0.3, 0.2])
//!     .shade("stick", Colour::Blue, &[(0.5, 1.5)])
//!     .caption("One sentence that says what the picture shows.");
//! assert_eq!(plot.figure_json()["data"][0]["y"][1], 0.3);
//! let html = Page::new("Title", "What this is about.").section("A section").figure(&plot).html();
//! assert!(html.contains("Plotly"));
//! ```
//!
//! Figures: [`Plot`] (lines, points, bands, shaded intervals; linear and log axes), [`Bars`],
//! [`Matrix`]. Every one needs axes with units and a caption; colours are safe for colour-blind
//! readers and follow light and dark mode. A [`Plot`] can also be written as a static picture,
//! [`svg_file`].

mod axis;
mod bars;
mod colour;
#[cfg(test)]
mod contrast;
mod drawn;
mod layer;
mod layout;
mod matrix;
mod number;
mod page;
mod plot;
mod plotly_script;
mod standalone;
mod stroke;
mod svg;
mod table;
mod thinning;
mod trace;

pub use axis::Axis;
pub use bars::Bars;
pub use colour::Colour;
pub use drawn::Drawn;
pub use matrix::Matrix;
pub use number::{number, percent, with_unit};
pub use page::{Figure, Page};
pub use plot::Plot;
pub use plotly_script::{figure_script, plotly_script};
pub use standalone::svg_file;
pub use table::{Cell, Table};

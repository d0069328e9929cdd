//! A picture as a file of its own.

use super::page::Figure;
use super::plot::Plot;

/// The palette and text style of the page, for white paper.
pub(super) const STYLE: &str = ":root{--ink:#1b1f24;--grey:#7f868e;--paper:#fff;--grid:#eceff2;--blue:#0072b2;--orange:#d55e00;\
--green:#009e73;--red:#b3261e;--purple:#aa4499;--sky:#3d97d0}svg svg{overflow:hidden}text{font:12px \
system-ui,\"Segoe UI\",Roboto,sans-serif;fill:var(--ink)}.grid{stroke:var(--grid)}.frame{fill:none;stroke:var(--grey)}\
.marked{stroke:var(--ink);stroke-width:2}";

/// The picture as the text of an .svg file, its caption as title.
pub fn svg_file(figure: &Plot) -> String {
    let svg = figure.svg();
    let inside = svg.find('>').map_or(svg.len(), |at| at + 1);
    let (head, body) = svg.split_at(inside);
    let title = super::svg::escape(figure.caption());
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{head}<title>{title}</title><style>{STYLE}</style>\
         <rect width=\"100%\" height=\"100%\" style=\"fill:var(--paper)\"/>{body}\n"
    )
}

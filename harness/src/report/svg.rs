//! The frame that all pictures share: axes, grid, ticks, legend.

use std::fmt::Write as _;

use super::axis::{Axis, Scale};
use super::colour::Colour;

/// A picture grows to so many times its size, where the page has room, and no further: its texts would shout.
const LARGEST: f64 = 1.3;
/// Room around the plotting area, px: for tick texts and axis labels.
const LEFT: f64 = 66.0;
const RIGHT: f64 = 14.0;
const BOTTOM: f64 = 46.0;
const LEGEND_ROW: f64 = 18.0;
/// Width of a legend's character and of its mark, px.
const CHARACTER: f64 = 6.2;
const MARK: f64 = 30.0;

/// How a legend entry is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    Line,
    Dashed,
    Point,
    Area,
}

/// An SVG in the making, with its plotting area.
pub(super) struct Canvas {
    pub text: String,
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
    total: (f64, f64),
}

impl Canvas {
    /// A canvas of `width` x `height` px with a legend on top and room for axes.
    pub fn new(width: f64, height: f64, legend: &[(String, Colour, Mark)]) -> Canvas {
        let mut canvas = Canvas {
            text: String::new(),
            left: LEFT,
            top: 8.0,
            width: width - LEFT - RIGHT,
            height: 0.0,
            total: (width, height),
        };
        canvas.legend(legend);
        canvas.height = height - canvas.top - BOTTOM;
        canvas
    }

    fn legend(&mut self, entries: &[(String, Colour, Mark)]) {
        let first = self.left;
        let mut x = first;
        for (i, (name, colour, mark)) in entries.iter().enumerate() {
            let width = MARK + CHARACTER * name.chars().count() as f64 + 12.0;
            if i > 0 && x + width > self.total.0 {
                x = first;
                self.top += LEGEND_ROW;
            }
            let (y, c) = (self.top + 6.0, colour.css());
            let _ = match mark {
                Mark::Line => write!(
                    self.text,
                    r#"<line x1="{x}" x2="{}" y1="{y}" y2="{y}" style="stroke:{c}" stroke-width="2"/>"#,
                    x + 22.0
                ),
                Mark::Dashed => {
                    write!(
                        self.text,
                        r#"<line x1="{x}" x2="{}" y1="{y}" y2="{y}" style="stroke:{c}" stroke-width="2" stroke-dasharray="5 3"/>"#,
                        x + 22.0
                    )
                }
                Mark::Point => write!(
                    self.text,
                    r#"<circle cx="{}" cy="{y}" r="3.5" style="fill:{c}"/>"#,
                    x + 11.0
                ),
                Mark::Area => {
                    write!(
                        self.text,
                        r#"<rect x="{x}" y="{}" width="22" height="10" style="fill:{c}" fill-opacity="0.3"/>"#,
                        y - 5.0
                    )
                }
            };
            self.label(x + 27.0, y + 4.0, "start", name);
            x += width;
        }
        if !entries.is_empty() {
            self.top += LEGEND_ROW + 4.0;
        }
    }

    /// Moves the plotting area's left border to the right if less room than `needed` px is left of it.
    pub fn widen_left(&mut self, needed: f64) {
        let more = (needed - self.left).max(0.0);
        self.left += more;
        self.width -= more;
    }

    /// Text at a point; `anchor` is `start`, `middle` or `end`.
    pub fn label(&mut self, x: f64, y: f64, anchor: &str, text: &str) {
        let _ = write!(
            self.text,
            r#"<text x="{x:.1}" y="{y:.1}" text-anchor="{anchor}">{}</text>"#,
            escape(text)
        );
    }

    /// Grid, ticks, labels and the border of the plotting area.
    pub fn axes(&mut self, x: (&Axis, &Scale), y: (&Axis, &Scale)) {
        let (left, top, right, bottom) = (
            self.left,
            self.top,
            self.left + self.width,
            self.top + self.height,
        );
        self.axis_below(x.0, x.1);
        for (tick, text) in y.0.ticks(y.1, (self.height / 42.0) as usize) {
            let at = bottom - self.height * y.1.share(tick);
            let _ = write!(
                self.text,
                r#"<line class="grid" x1="{left}" x2="{right:.1}" y1="{at:.1}" y2="{at:.1}"/>"#
            );
            self.label(left - 6.0, at + 4.0, "end", &text);
        }
        self.upright(14.0, top + self.height / 2.0, &y.0.label);
    }

    /// Border, and grid, ticks and label of the horizontal axis only.
    pub fn axis_below(&mut self, axis: &Axis, scale: &Scale) {
        let (left, top, bottom) = (self.left, self.top, self.top + self.height);
        for (tick, text) in axis.ticks(scale, ((self.width / 90.0) as usize).max(3)) {
            let at = left + self.width * scale.share(tick);
            let _ = write!(
                self.text,
                r#"<line class="grid" x1="{at:.1}" x2="{at:.1}" y1="{top}" y2="{bottom:.1}"/>"#
            );
            self.label(at, bottom + 16.0, "middle", &text);
        }
        let _ = write!(
            self.text,
            r#"<rect class="frame" x="{left}" y="{top}" width="{:.1}" height="{:.1}"/>"#,
            self.width, self.height
        );
        self.label(
            left + self.width / 2.0,
            bottom + 36.0,
            "middle",
            &axis.label,
        );
    }

    /// Text turned to read upwards, centred at a point.
    pub fn upright(&mut self, x: f64, y: f64, text: &str) {
        let _ = write!(
            self.text,
            r#"<text transform="translate({x:.1},{y:.1}) rotate(-90)" text-anchor="middle">{}</text>"#,
            escape(text)
        );
    }

    /// The finished element.
    pub fn finish(self, description: &str) -> String {
        let (w, h) = self.total;
        format!(
            r#"<svg viewBox="0 0 {w} {h}" style="max-width:{:.0}px" role="img" aria-label="{}" xmlns="http://www.w3.org/2000/svg">{}</svg>"#,
            LARGEST * w,
            escape(description),
            self.text
        )
    }

    /// Opens a group clipped to the plotting area: an inner `<svg>` clips without needing an id.
    pub fn open_area(&mut self) {
        let _ = write!(
            self.text,
            r#"<svg x="{l}" y="{t:.1}" width="{w:.1}" height="{h:.1}" viewBox="{l} {t:.1} {w:.1} {h:.1}">"#,
            l = self.left,
            t = self.top,
            w = self.width,
            h = self.height
        );
    }

    /// Closes [`Canvas::open_area`].
    pub fn close_area(&mut self) {
        self.text.push_str("</svg>");
    }
}

/// Text as XML.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

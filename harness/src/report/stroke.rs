//! Path data of lines, no more of it than the picture can show.

use std::fmt::Write as _;

use super::thinning::{Point, is_finite, kept};

/// Lines of fewer points are drawn point by point; pictures are about as many px wide.
const DENSE: usize = 1500;
/// Points this near to the one drawn before are left out, px.
const NEAR: f64 = 0.4;

/// Path data of a line through points in px; a point that is not finite interrupts it.
pub(super) fn line(points: impl Iterator<Item = Point>) -> String {
    let points: Vec<Point> = points.collect();
    let (mut pen, kept) = (Pen::default(), kept(&points, DENSE));
    for run in &kept.runs {
        let joined = run.iter().map(|i| points[*i]);
        if kept.by_column {
            pen.polyline(joined.map(whole));
        } else {
            pen.polyline(joined);
        }
    }
    pen.d
}

/// Path data of the area between two curves, both from left to right.
pub(super) fn area(low: &[Point], high: &[Point]) -> String {
    let side = |points: &[Point]| -> Vec<Point> {
        let finite: Vec<Point> = points.iter().copied().filter(is_finite).collect();
        if finite.len() <= DENSE {
            return finite;
        }
        let runs = kept(&finite, DENSE).runs;
        runs.iter().flatten().map(|i| whole(finite[*i])).collect()
    };
    let mut pen = Pen::default();
    pen.polyline(side(low).into_iter().chain(side(high).into_iter().rev()));
    pen.d
}

/// The middle of its column: whole px take half the text, and nobody sees the difference where a column is full.
fn whole((x, y): Point) -> Point {
    (x.floor() + 0.5, y.round())
}

/// Writes path data in tenths of a px, relative to where it is.
#[derive(Default)]
struct Pen {
    d: String,
    /// In tenths of a px.
    at: (i64, i64),
}

fn tenths(point: Point) -> (i64, i64) {
    (
        (10.0 * point.0).round() as i64,
        (10.0 * point.1).round() as i64,
    )
}

impl Pen {
    fn move_to(&mut self, point: Point) {
        self.at = tenths(point);
        let (x, y) = (self.at.0 as f64 / 10.0, self.at.1 as f64 / 10.0);
        let _ = write!(self.d, "M{x} {y}");
    }

    fn line_to(&mut self, point: Point) {
        let next = tenths(point);
        let dx = (next.0 - self.at.0) as f64 / 10.0;
        let dy = (next.1 - self.at.1) as f64 / 10.0;
        let _ = match (next.0 == self.at.0, next.1 == self.at.1) {
            (true, true) => Ok(()),
            (true, false) => write!(self.d, "v{dy}"),
            (false, true) => write!(self.d, "h{dx}"),
            (false, false) => write!(self.d, "l{dx} {dy}"),
        };
        self.at = next;
    }

    /// Joins points, those that lie on one another left out.
    fn polyline(&mut self, points: impl Iterator<Item = Point>) {
        let mut last: Option<Point> = None;
        for point in points {
            match last {
                None => self.move_to(point),
                Some(p) if (point.0 - p.0).abs() < NEAR && (point.1 - p.1).abs() < NEAR => continue,
                Some(_) => self.line_to(point),
            }
            last = Some(point);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The points of path data, absolute.
    fn drawn(d: &str) -> Vec<Point> {
        let (mut at, mut points) = ((0.0, 0.0), Vec::new());
        let starts: Vec<usize> = d
            .char_indices()
            .filter(|(_, c)| c.is_ascii_alphabetic())
            .map(|(i, _)| i)
            .chain([d.len()])
            .collect();
        for w in starts.windows(2) {
            let numbers: Vec<f64> = d[w[0] + 1..w[1]]
                .split(' ')
                .map(|v| v.parse().unwrap())
                .collect();
            at = match &d[w[0]..=w[0]] {
                "M" => (numbers[0], numbers[1]),
                "l" => (at.0 + numbers[0], at.1 + numbers[1]),
                "h" => (at.0 + numbers[0], at.1),
                "v" => (at.0, at.1 + numbers[0]),
                other => panic!("{other}"),
            };
            points.push(at);
        }
        points
    }

    #[test]
    fn a_long_record_keeps_every_peak_and_takes_no_more_text_than_a_short_one() {
        let wave = |n: usize| -> Vec<Point> {
            let value = |x: f64| 150.0 + 100.0 * (3.0 * x).sin();
            let mut points: Vec<Point> = (0..n)
                .map(|i| 1000.0 * i as f64 / n as f64)
                .map(|x| (x, value(x)))
                .collect();
            // A spike of one sample.
            points[n / 3].1 = 290.0;
            points
        };
        let (short, long) = (
            line(wave(20_000).into_iter()),
            line(wave(2_000_000).into_iter()),
        );
        assert!(long.len() < 30_000, "{}", long.len());
        assert!((long.len() as f64 / short.len() as f64 - 1.0).abs() < 0.1);
        let spike = drawn(&long).into_iter().find(|p| p.1 == 290.0).unwrap();
        assert!((spike.0 - 1000.0 / 3.0).abs() <= 1.0, "{spike:?}");
        let high = drawn(&long).iter().filter(|p| p.1 > 249.0).count();
        assert!(high > 400, "{high}");
    }

    #[test]
    fn a_closed_curve_run_through_a_thousand_times_is_drawn_once() {
        let turns = |n: usize| {
            let angle = |i: usize| 0.0628 * i as f64;
            // Interrupted now and then, as a model put together from pieces is.
            let cut = |i: usize| if i % 300 == 299 { f64::NAN } else { 0.0 };
            let x = |i: usize| 300.0 + 200.0 * angle(i).cos() + cut(i);
            line((0..n).map(|i| (x(i), 150.0 + 100.0 * angle(i).sin())))
        };
        let (few, many) = (turns(2_000), turns(200_000));
        assert!(many.len() < 3 * few.len(), "{} {}", few.len(), many.len());
        let right = drawn(&many).iter().fold(0.0_f64, |m, p| m.max(p.0));
        assert!((right - 500.0).abs() < 0.2);
    }

    #[test]
    fn a_missing_point_interrupts_a_line() {
        let points = [
            (0.0, 0.0),
            (5.0, 1.0),
            (f64::NAN, 0.0),
            (9.0, 1.0),
            (12.0, 1.0),
        ];
        assert_eq!(line(points.into_iter()), "M0 0l5 1M9 1h3");
        assert_eq!(
            area(&[(0.0, 0.0), (5.0, 1.0)], &[(0.0, 3.0), (5.0, 4.0)]),
            "M0 0l5 1v3l-5 -1"
        );
    }
}

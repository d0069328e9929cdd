//! Which points of a line a picture needs.
//!
//! A line of millions of samples covers each cell of a picture many times. A curve over its x axis keeps the lowest and the
//! highest point of each column; any other curve leaves out what runs over cells that it has inked before.

use std::collections::HashSet;

/// A point in cells of the picture.
pub(super) type Point = (f64, f64);

/// What is left of a line.
pub(super) struct Kept {
    /// Indices of points to be joined; between two runs the line is interrupted.
    pub runs: Vec<Vec<usize>>,
    /// Whether columns of the picture stand for their points.
    pub by_column: bool,
}

/// Points that show all of a line in a picture of so many columns; a point that is not finite interrupts it. Lines of fewer
/// points than columns are kept point by point.
pub(super) fn kept(points: &[Point], columns: usize) -> Kept {
    let pieces = pieces(points);
    let over_x = || {
        let runs_right = |piece: &[usize]| piece.is_sorted_by(|a, b| points[*a].0 <= points[*b].0);
        pieces.iter().all(|piece| runs_right(piece))
    };
    if points.len() <= columns {
        return Kept {
            runs: pieces,
            by_column: false,
        };
    }
    if over_x() {
        let runs = pieces.iter().map(|piece| extremes(points, piece));
        return Kept {
            runs: runs.collect(),
            by_column: true,
        };
    }
    let mut inked = HashSet::new();
    let fresh = pieces
        .iter()
        .flat_map(|piece| fresh_ink(points, piece, &mut inked));
    Kept {
        runs: fresh.collect(),
        by_column: false,
    }
}

/// One point of each cell, for clouds of more points than the picture has columns.
pub(super) fn one_per_cell(points: &[Point], columns: usize) -> Vec<usize> {
    let mut inked = HashSet::new();
    let finite = (0..points.len()).filter(|i| is_finite(&points[*i]));
    finite
        .filter(|i| {
            let (x, y) = points[*i];
            points.len() <= columns || inked.insert((x.floor() as i64, y.floor() as i64))
        })
        .collect()
}

pub(super) fn is_finite(point: &Point) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

/// Indices of finite points, cut where one is missing.
fn pieces(points: &[Point]) -> Vec<Vec<usize>> {
    let all: Vec<usize> = (0..points.len()).collect();
    all.split(|i| !is_finite(&points[*i]))
        .filter(|piece| !piece.is_empty())
        .map(<[usize]>::to_vec)
        .collect()
}

/// Of each column the lowest and highest point, in the order in which they come.
fn extremes(points: &[Point], piece: &[usize]) -> Vec<usize> {
    let mut found = Vec::new();
    for column in piece.chunk_by(|a, b| points[*a].0.floor() == points[*b].0.floor()) {
        let (mut low, mut high) = (column[0], column[0]);
        for &i in column {
            if points[i].1 < points[low].1 {
                low = i;
            }
            if points[i].1 > points[high].1 {
                high = i;
            }
        }
        found.push(low.min(high));
        if low != high {
            found.push(low.max(high));
        }
    }
    found
}

/// The stretches of a piece that run over cells not inked before.
fn fresh_ink(
    points: &[Point],
    piece: &[usize],
    inked: &mut HashSet<(i32, i32)>,
) -> Vec<Vec<usize>> {
    const NEAR: f64 = 0.4;
    let (mut runs, mut run) = (Vec::new(), Vec::new());
    let mut last = piece[0];
    for &i in &piece[1..] {
        let (from, to) = (points[last], points[i]);
        if (to.0 - from.0).abs() < NEAR && (to.1 - from.1).abs() < NEAR {
            continue;
        }
        let before = inked.len();
        inked.extend(cells(from, to));
        if inked.len() > before {
            if run.is_empty() {
                run.push(last);
            }
            run.push(i);
        } else if !run.is_empty() {
            runs.push(std::mem::take(&mut run));
        }
        last = i;
    }
    if !run.is_empty() {
        runs.push(run);
    }
    runs
}

/// Cells under the line between two points.
fn cells(from: Point, to: Point) -> impl Iterator<Item = (i32, i32)> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let steps = dx.abs().max(dy.abs()).ceil().clamp(1.0, 1e4);
    (0..=steps as usize).map(move |i| {
        let share = i as f64 / steps;
        (
            (from.0 + share * dx).floor() as i32,
            (from.1 + share * dy).floor() as i32,
        )
    })
}

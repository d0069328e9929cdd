//! Figure 12: the kinds of motion over belt velocity and normal force.

use super::claim::{Bound, Claim, Finding};
use super::{PaperFigure, Workshop};
use crate::command::sweep::pictures;
use crate::command::sweep::plan::StartKind;
use crate::command::sweep::study::Study;
use crate::command::sweep::table::Result as Row;
use crate::command::sweep::terminal::name;
use crate::error::Error;
use crate::report::number;

/// The figure.
pub fn figure(workshop: &Workshop) -> Result<PaperFigure, Error> {
    // The same points in quick pictures: areas on a coarser grid are other areas.
    let axes = [
        ("belt_velocity", "m/s", 0.01, 0.25, COLUMNS),
        ("normal_force", "N", 5.0, 125.0, ROWS),
    ];
    let starts = [StartKind::Fixed, StartKind::Grid];
    let look = |s: &Study| {
        (
            starts.map(|kind| pictures::map(s, kind)),
            starts.map(|kind| Kinds::of(s, kind)),
        )
    };
    let (plots, [fixed, largest]) = workshop.study("figure12", &axes, &[], &starts, look)?;
    let [fixed_plot, largest_plot] = plots;
    Ok(PaperFigure {
        number: "12",
        title: "Kinds of motion over belt velocity and normal force".into(),
        claims: claims(&fixed, &largest).into(),
        pictures: vec![
            ("figure12".into(), fixed_plot),
            ("figure12_largest".into(), largest_plot),
        ],
    })
}

const COLUMNS: usize = 25;
const ROWS: usize = 17;
/// Frequency in Hz above which a motion is the small one.
const FAST: f64 = 200.0;
/// Share in % of the map from which on points are an area.
const AREA: f64 = 5.0;

/// Shares of the map in %.
#[derive(Debug, Clone, Copy, Default)]
struct Kinds {
    /// Largest connected area of period one.
    area_of_ones: f64,
    /// Largest connected area without vibration.
    area_of_rest: f64,
    one: f64,
    longer: f64,
    irregular: f64,
    unresolved: f64,
    none: f64,
    fast: f64,
    /// 30 to 40 Hz.
    main: f64,
}

impl Kinds {
    fn of(study: &Study, kind: StartKind) -> Kinds {
        let rows = pictures::representative(study, kind);
        let here: Vec<_> = rows.into_iter().map(|(row, r)| (row, name(r), r)).collect();
        let share = |f: &dyn Fn(&str, &Row) -> bool| {
            let many = here.iter().filter(|(_, n, r)| f(n, r)).count();
            100.0 * many as f64 / here.len().max(1) as f64
        };
        let grid = |axis: usize| &study.plan.axes[axis].values;
        let area = |wanted: &str| {
            let mut cells = vec![vec![false; grid(1).len()]; grid(0).len()];
            for (row, n, _) in &here {
                let at = |axis: usize| grid(axis).iter().position(|v| *v == row.at[axis]);
                if let (Some(x), Some(y)) = (at(0), at(1)) {
                    cells[x][y] = n == wanted;
                }
            }
            100.0 * largest_area(&cells) as f64 / here.len().max(1) as f64
        };
        let beats = |r: &Row, low: f64, high: f64| {
            r.vibrates() && r.main_frequency.is_some_and(|f| (low..=high).contains(&f))
        };
        Kinds {
            area_of_ones: area("period 1"),
            area_of_rest: area("no vibration"),
            one: share(&|n, _| n == "period 1"),
            longer: share(&|n, _| n.starts_with("period ") && n != "period 1"),
            irregular: share(&|n, _| n == "irregular"),
            unresolved: share(&|n, _| n == "unresolved" || n == "settling"),
            none: share(&|n, _| n == "no vibration"),
            fast: share(&|_, r| beats(r, FAST, f64::INFINITY)),
            main: share(&|_, r| beats(r, 30.0, 40.0)),
        }
    }

    fn words(&self) -> String {
        let all = [
            (self.one, "period one"),
            (self.longer, "longer periods"),
            (self.irregular, "irregular"),
            (self.unresolved, "unresolved or still settling"),
            (self.none, "no vibration"),
        ];
        let each = all.map(|(share, what)| format!("{} % {what}", number(share, 2)));
        format!(
            "{} ({} % of all near the second natural frequency, {} % at 30 to 40 Hz)",
            each.join(", "),
            number(self.fast, 2),
            number(self.main, 2)
        )
    }
}

/// Number of cells of the largest area of true ones that touch along an edge.
fn largest_area(cells: &[Vec<bool>]) -> usize {
    let mut left = cells.to_vec();
    let mut largest = 0;
    for x in 0..left.len() {
        for y in 0..left[x].len() {
            let mut open = vec![(x, y)];
            let mut size = 0;
            while let Some((x, y)) = open.pop() {
                if !std::mem::take(&mut left[x][y]) {
                    continue;
                }
                size += 1;
                if x > 0 {
                    open.push((x - 1, y));
                }
                if y > 0 {
                    open.push((x, y - 1));
                }
                if x + 1 < left.len() {
                    open.push((x + 1, y));
                }
                if y + 1 < left[x].len() {
                    open.push((x, y + 1));
                }
            }
            largest = largest.max(size);
        }
    }
    largest
}

fn claims(fixed: &Kinds, largest: &Kinds) -> [Claim; 2] {
    let finding = |what: &str, from: &str, value: f64| {
        Finding::new(
            format!("largest connected area {what}, {from}"),
            value,
            "% of the map",
            Bound::AtLeast(AREA),
            "the paper marks areas, not points: a twentieth of the map is 21 of 425 points, and a point more or less decides nothing",
        )
    };
    let (a, b) = (
        "from the fixed start",
        "of the largest motions of six starts",
    );
    [
        Claim::new(
            "There are coherent areas with period-one solutions.",
            format!("From the fixed start: {}", fixed.words()),
            vec![
                finding("of period one", a, fixed.area_of_ones),
                finding("of period one", b, largest.area_of_ones),
            ],
        ),
        Claim::new(
            "In the hatched regions no self-sustained vibrations take place.",
            format!("Largest motions of six starts: {}", largest.words()),
            vec![
                finding("without vibration", a, fixed.area_of_rest),
                finding("without vibration", b, largest.area_of_rest),
            ],
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::claim::Verdict;
    use super::*;

    #[test]
    fn val_largest_area_is_counted_along_edges() {
        // Source: counted by hand; the cells touch by corners only where the areas part.
        let map = ["110.1", "01..1", "..111", "1...1"];
        let cells: Vec<Vec<bool>> = map
            .iter()
            .map(|l| l.chars().map(|c| c == '1').collect())
            .collect();
        assert_eq!(largest_area(&cells), 6);
        assert_eq!(largest_area(&[vec![false; 3]]), 0);
    }

    #[test]
    fn verdicts_come_out_both_ways_and_no_single_point_decides() {
        let kinds = |area| Kinds {
            area_of_ones: area,
            area_of_rest: area,
            ..Kinds::default()
        };
        let verdicts = |a, b| claims(&kinds(a), &kinds(b)).map(|c| c.verdict());
        assert_eq!(verdicts(20.0, 30.0), [Verdict::Agrees; 2]);
        assert_eq!(verdicts(20.0, 3.0), [Verdict::InPart; 2]);
        let point = 100.0 / (COLUMNS * ROWS) as f64;
        assert_eq!(verdicts(point, point), [Verdict::Differs; 2]);
    }
}

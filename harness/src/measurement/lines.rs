//! A text's lines: those with something in them, empty ones, comments.

use std::ops::Range;

/// A line with its place.
#[derive(Clone)]
pub(super) struct Place {
    /// Counted from 1.
    pub line: u64,
    /// Of its bytes in the text.
    pub range: Range<usize>,
}

impl Place {
    pub fn pair(&self) -> (u64, Range<usize>) {
        (self.line, self.range.clone())
    }
}

/// A text's lines, sorted.
#[derive(Default)]
pub(super) struct Lines {
    pub filled: Vec<Place>,
    pub empty: Vec<Place>,
    pub comments: Vec<Place>,
}

impl Lines {
    pub fn of(text: &str) -> Lines {
        let mut lines = Lines::default();
        let mut begin = 0;
        for (line, content) in (1..).zip(text.split('\n')) {
            let range = begin..begin + content.trim_end_matches('\r').len();
            begin += content.len() + 1;
            let kind = match content.trim() {
                "" => &mut lines.empty,
                text if is_comment(text) => &mut lines.comments,
                _ => &mut lines.filled,
            };
            kind.push(Place { line, range });
        }
        lines
    }
}

fn is_comment(line: &str) -> bool {
    // A semicolon before a number begins a row whose first sample is missing.
    let in_words = |rest: &str| {
        let first = rest.trim_start().chars().next();
        first.is_none_or(|c| c.is_alphabetic() || c == ';')
    };
    line.starts_with(['#', '%'])
        || line.starts_with("//")
        || line.strip_prefix(';').is_some_and(in_words)
}

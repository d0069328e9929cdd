//! Sums over the nodes of a step, element by element and in a fixed order: the same digits in vectors of any width.

use super::{NODES, Nodes};

const HALF: usize = NODES / 2;

/// Something that begins on a border of the processor's cache lines: vectors as wide as a line would else be read from two.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Aligned<T>(pub(super) T);

/// Matrix, given by its columns, times a list. Four sums side by side, so that none waits long for the one before.
#[inline(always)]
pub(super) fn product(columns: &Aligned<[Nodes; NODES]>, x: &Nodes) -> Nodes {
    let columns = &columns.0;
    let x = apart(*x);
    let (mut a, mut b) = ([0.0; NODES], [0.0; NODES]);
    let (mut c, mut d) = ([0.0; NODES], [0.0; NODES]);
    for j in (0..NODES).step_by(4) {
        for i in 0..NODES {
            a[i] = columns[j][i].mul_add(x[j], a[i]);
            b[i] = columns[j + 1][i].mul_add(x[j + 1], b[i]);
            c[i] = columns[j + 2][i].mul_add(x[j + 2], c[i]);
            d[i] = columns[j + 3][i].mul_add(x[j + 3], d[i]);
        }
    }
    for i in 0..NODES {
        a[i] = (a[i] + b[i]) + (c[i] + d[i]);
    }
    apart(a)
}

/// Keeps a sum of columns apart from what is done with it: together, the compiler forms vectors of two for the reductions
/// that follow, and the sums with them.
#[inline(always)]
pub(super) fn apart<const N: usize>(values: [f64; N]) -> [f64; N] {
    std::hint::black_box(Aligned(values)).0
}

/// Sum of the products of two lists, in an order that vectors of any width keep.
#[inline(always)]
pub(super) fn dot(a: &Nodes, b: &Nodes) -> f64 {
    let mut s = [0.0; HALF];
    for i in 0..HALF {
        s[i] = a[i] * b[i];
    }
    for i in 0..HALF {
        s[i] = a[HALF + i].mul_add(b[HALF + i], s[i]);
    }
    total(s)
}

/// Sum of eight numbers.
#[inline(always)]
pub(super) fn total(s: [f64; HALF]) -> f64 {
    let s = apart(s);
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}

/// The largest of a list.
#[inline(always)]
pub(super) fn largest(values: &Nodes) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let mut s = [0.0; HALF];
    for i in 0..HALF {
        s[i] = larger(values[i], values[HALF + i]);
    }
    let s = apart(s);
    larger(
        larger(larger(s[0], s[4]), larger(s[2], s[6])),
        larger(larger(s[1], s[5]), larger(s[3], s[7])),
    )
}

/// The largest difference of two lists.
#[inline(always)]
pub(super) fn distance(a: &Nodes, b: &Nodes) -> f64 {
    let mut changes = *a;
    for i in 0..NODES {
        changes[i] = (changes[i] - b[i]).abs();
    }
    largest(&changes)
}

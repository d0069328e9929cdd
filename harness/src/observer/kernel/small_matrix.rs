//! Vectors and matrices of fixed size, as the recursions need them.

use nalgebra::{DMatrix, DVector};

pub(super) type Vector<const N: usize> = [f64; N];

pub(super) type Matrix<const N: usize> = [[f64; N]; N];

pub(super) fn dot<const N: usize>(a: &Vector<N>, b: &Vector<N>) -> f64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += a[i] * b[i];
    }
    sum
}

pub(super) fn axpy<const N: usize>(y: &mut Vector<N>, a: f64, x: &Vector<N>) {
    for i in 0..N {
        y[i] += a * x[i];
    }
}

pub(super) fn times<const N: usize>(a: &Matrix<N>, x: &Vector<N>) -> Vector<N> {
    std::array::from_fn(|i| dot(&a[i], x))
}

pub(super) fn transposed_times<const N: usize>(a: &Matrix<N>, x: &Vector<N>) -> Vector<N> {
    let mut out = [0.0; N];
    for i in 0..N {
        axpy(&mut out, x[i], &a[i]);
    }
    out
}

pub(super) fn quadratic<const N: usize>(m: &Matrix<N>, x: &Vector<N>) -> f64 {
    dot(x, &times(m, x))
}

pub(super) fn add_scaled<const N: usize>(m: &mut Matrix<N>, other: &Matrix<N>, factor: f64) {
    for i in 0..N {
        axpy(&mut m[i], factor, &other[i]);
    }
}

/// `A P A'` for symmetric `P`.
pub(super) fn congruence<const N: usize>(a: &Matrix<N>, p: &Matrix<N>) -> Matrix<N> {
    let mut ap = [[0.0; N]; N];
    for i in 0..N {
        for l in 0..N {
            axpy(&mut ap[i], a[i][l], &p[l]);
        }
    }
    let mut out = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            let value = dot(&ap[i], &a[j]);
            out[i][j] = value;
            out[j][i] = value;
        }
    }
    out
}

/// `A' M A` for symmetric `M`.
pub(super) fn transposed_congruence<const N: usize>(a: &Matrix<N>, m: &Matrix<N>) -> Matrix<N> {
    let mut ma = [[0.0; N]; N];
    for i in 0..N {
        for l in 0..N {
            axpy(&mut ma[i], m[i][l], &a[l]);
        }
    }
    let mut out = [[0.0; N]; N];
    for l in 0..N {
        for i in 0..N {
            axpy(&mut out[i], a[l][i], &ma[l]);
        }
    }
    out
}

pub(super) fn vector<const N: usize>(v: &DVector<f64>) -> Vector<N> {
    std::array::from_fn(|i| if i < v.len() { v[i] } else { 0.0 })
}

pub(super) fn matrix<const N: usize>(m: &DMatrix<f64>) -> Matrix<N> {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            if i < m.nrows() && j < m.ncols() {
                m[(i, j)]
            } else {
                0.0
            }
        })
    })
}

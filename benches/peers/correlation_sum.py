"""Correlation sums of the series in a file by scikit-learn and nolds, timed: delay 8, m = 1..10, 40 radii, maximum norm."""

import sys
import time

import numpy as np
from sklearn.neighbors import KDTree

DELAY, DIMENSIONS, RADII, THEILER = 8, 10, 40, 100
x = np.loadtxt(sys.argv[1])
spread = x.max() - x.min()
radii = spread * 2.0 ** (-np.arange(RADII)[::-1] / 4)


def embedded(m):
    count = len(x) - (m - 1) * DELAY
    return np.column_stack([x[k * DELAY : k * DELAY + count] for k in range(m)])


start = time.perf_counter()
for m in range(1, DIMENSIONS + 1):
    vectors = embedded(m)
    pairs = (KDTree(vectors, metric="chebyshev").two_point_correlation(vectors, radii, dualtree=True) - len(vectors)) // 2
    # The tree knows no Theiler window: pairs near in time are taken off again.
    for lag in range(1, THEILER + 1):
        near = np.abs(vectors[lag:] - vectors[:-lag]).max(axis=1)
        pairs -= np.searchsorted(np.sort(near), radii, side="right")
print(f"N = {len(x)}, scikit-learn dual trees: {time.perf_counter() - start:.1f} s", flush=True)

import nolds  # noqa: E402  (after the first figure: it may be missing)

start = time.perf_counter()
# One embedding dimension of the ten: it builds the whole matrix of distances. nolds has no delay before 0.6 and no Theiler window.
nolds.corr_dim(x, 5, rvals=radii, fit="poly", lag=DELAY)
once = time.perf_counter() - start
print(f"N = {len(x)}, nolds, m = 5 alone: {once:.1f} s; ten dimensions: about {10 * once:.0f} s")

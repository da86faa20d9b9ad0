# SPDX-License-Identifier: BSD-3-Clause
"""Numbers from columns of equidistant samples."""
import math


def high_pass(x, rate, cutoff):
    """Two first-order filters by the bilinear rule: half the power at the cutoff for each, all of it far above."""
    k = math.tan(math.pi * cutoff / rate)
    for _ in range(2):
        y = [0.0] * len(x)
        for i in range(1, len(x)):
            y[i] = ((1.0 - k) * y[i - 1] + x[i] - x[i - 1]) / (1.0 + k)
        x = y
    return x


def low_pass(x, rate, cutoff):
    k = math.tan(math.pi * cutoff / rate)
    for _ in range(2):
        y = [x[0]] * len(x)
        for i in range(1, len(x)):
            y[i] = ((1.0 - k) * y[i - 1] + k * (x[i] + x[i - 1])) / (1.0 + k)
        x = y
    return x


def rms(x, chosen):
    return math.sqrt(sum(x[i] * x[i] for i in chosen) / max(1, len(chosen)))


def median(x):
    x = sorted(x)
    return x[len(x) // 2] if len(x) % 2 else 0.5 * (x[len(x) // 2 - 1] + x[len(x) // 2])


def solve(A, b):
    """Gauss with pivoting; small systems only."""
    n = len(b)
    M = [list(row) + [b[i]] for i, row in enumerate(A)]
    for i in range(n):
        p = max(range(i, n), key=lambda k: abs(M[k][i]))
        M[i], M[p] = M[p], M[i]
        for k in range(n):
            if k != i:
                f = M[k][i] / M[i][i]
                M[k] = [a - f * c for a, c in zip(M[k], M[i])]
    return [M[i][n] / M[i][i] for i in range(n)]


def least_squares(columns, y):
    A = [[sum(a * b for a, b in zip(p, q)) for q in columns] for p in columns]
    return solve(A, [sum(a * b for a, b in zip(p, y)) for p in columns])

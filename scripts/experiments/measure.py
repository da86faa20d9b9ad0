# SPDX-License-Identifier: BSD-3-Clause
"""Numbers from columns of equidistant samples."""
import math


def high_pass(x, rate, cutoff):
    for _ in range(2):
        a, y = 1.0 / (1.0 + 2.0 * math.pi * cutoff / rate), [0.0] * len(x)
        for i in range(1, len(x)):
            y[i] = a * (y[i - 1] + x[i] - x[i - 1])
        x = y
    return x


def low_pass(x, rate, cutoff):
    for _ in range(2):
        a, y = 1.0 - math.exp(-2.0 * math.pi * cutoff / rate), [x[0]] * len(x)
        for i in range(1, len(x)):
            y[i] = y[i - 1] + a * (x[i] - y[i - 1])
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

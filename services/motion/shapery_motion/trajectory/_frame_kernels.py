"""From decoded numbers to frames: cosines, the functions of time, and their products with the fields."""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

import numpy as np

from shapery_motion.compiled import inner, kernel

HALF_PI: Final = 1.5707963267948966


@inner
def cosine(numerator, denominator):
    """Return cos(pi / 2 · numerator / denominator) by additions, multiplications and one division, in this order."""
    turn = numerator % (4 * denominator)
    if turn > 2 * denominator:
        turn = 4 * denominator - turn
    sign = 1.0
    if turn > denominator:
        turn = 2 * denominator - turn
        sign = -1.0
    if 2 * turn <= denominator:
        x = HALF_PI * turn / denominator
        y = x * x
        total = 1.0 / 2432902008176640000.0
        for factor in (
            -1.0 / 6402373705728000.0, 1.0 / 20922789888000.0, -1.0 / 87178291200.0, 1.0 / 479001600.0,
            -1.0 / 3628800.0, 1.0 / 40320.0, -1.0 / 720.0, 1.0 / 24.0, -1.0 / 2.0, 1.0,
        ):  # fmt: skip
            total = total * y + factor
        return sign * total
    x = HALF_PI * (denominator - turn) / denominator
    y = x * x
    total = -1.0 / 121645100408832000.0
    for factor in (
        1.0 / 355687428096000.0, -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0,
        -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0,
    ):  # fmt: skip
        total = total * y + factor
    return sign * (total * x)


@kernel
def functions_of_time(cuts, quantised, bases):
    """Turn cosine coefficients into functions of time of unit norm.

    Parameters
    ----------
    cuts
        Where the runs of frames begin, and the number of frames last.
    quantised : (rank, F, 3)
        Coefficients, run after run.
    bases : (F, rank, 3)
        Receives the functions; those of a mode without any coefficient stay 0.
    """
    rank = len(quantised)
    scales = np.zeros(rank)
    for mode in range(rank):
        total = 0.0
        for at in range(cuts[-1]):
            for axis in range(3):
                value = float(quantised[mode, at, axis])
                total += value * value
        scales[mode] = 1.0 / np.sqrt(total) if total > 0.0 else 0.0
    for run in range(len(cuts) - 1):
        first, length = cuts[run], cuts[run + 1] - cuts[run]
        table = np.empty(4 * length)
        for k in range(4 * length):
            table[k] = cosine(k, length)
        even = np.sqrt(1.0 / length)
        other = np.sqrt(2.0 / length)
        for frequency in range(length):
            factor = other if frequency else even
            for mode in range(rank):
                x = float(quantised[mode, first + frequency, 0])
                y = float(quantised[mode, first + frequency, 1])
                z = float(quantised[mode, first + frequency, 2])
                if x == 0.0 and y == 0.0 and z == 0.0:
                    continue
                weight = factor * scales[mode]
                x, y, z = x * weight, y * weight, z * weight
                for t in range(length):
                    c = table[((2 * t + 1) * frequency) % (4 * length)]
                    bases[first + t, mode, 0] += c * x
                    bases[first + t, mode, 1] += c * y
                    bases[first + t, mode, 2] += c * z


@kernel
def add_cluster(fields, basis, members, frame, sums):
    """Place a cluster's vertices in a frame that holds the offset.

    Parameters
    ----------
    fields : (rank, n)
        Values of the cluster's modes at its vertices.
    basis : (rank, 3)
        The functions of time at this frame.
    members : (n,)
        The vertices.
    frame : (N, 3)
        Receives the sum.
    sums : (3, at least n)
        Scratch.
    """
    rank, n = fields.shape
    for v in range(n):
        sums[0, v] = 0.0
        sums[1, v] = 0.0
        sums[2, v] = 0.0
    for mode in range(rank):
        x, y, z = basis[mode, 0], basis[mode, 1], basis[mode, 2]
        for v in range(n):
            value = fields[mode, v]
            sums[0, v] += value * x
            sums[1, v] += value * y
            sums[2, v] += value * z
    for v in range(n):
        at = members[v]
        frame[at, 0] += sums[0, v]
        frame[at, 1] += sums[1, v]
        frame[at, 2] += sums[2, v]

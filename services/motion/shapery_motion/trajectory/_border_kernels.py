"""What clusters that are decoded say of the vertices beside the next one."""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

import numpy as np

from shapery_motion.compiled import kernel


@kernel
def project(fields, functions, vertices, mean, onto, places, values):
    """Express the trajectories of some vertices by the functions of another cluster.

    Parameters
    ----------
    fields : (r, n)
        Of the cluster that the vertices are in.
    functions : (r, t)
        Its functions of time, all frames and axes in a row.
    vertices : (u,)
        Numbers within that cluster.
    mean : (t,) or (0,)
        What is taken from the trajectories first.
    onto : (s, t)
        Functions of the other cluster, each of unit norm or 0.
    places : (u,)
        Columns of `values` that belong to the vertices.
    values : (s, at least u)
        Receives the components: that of each function in turn, and what it explains is taken away.
    """
    count, length = len(vertices), functions.shape[1]
    rest = np.zeros((length, count))
    column = np.zeros(count)
    for mode in range(len(functions)):
        for u in range(count):
            column[u] = fields[mode, vertices[u]]
        for t in range(length):
            factor = functions[mode, t]
            row = rest[t]
            for u in range(count):
                row[u] += column[u] * factor
    for t in range(len(mean)):
        row = rest[t]
        for u in range(count):
            row[u] -= mean[t]
    for mode in range(len(onto)):
        for u in range(count):
            column[u] = 0.0
        for t in range(length):
            factor = onto[mode, t]
            row = rest[t]
            for u in range(count):
                column[u] += row[u] * factor
        for t in range(length):
            factor = onto[mode, t]
            row = rest[t]
            for u in range(count):
                row[u] -= column[u] * factor
        for u in range(count):
            values[mode, places[u]] = column[u]


@kernel
def averages(owners, targets, values, counts, means):
    """Average the columns of `values` that the edges of each vertex lead to.

    `owners` (e,) and `targets` (e,) are the ends of the edges; `counts` (n,) and `means` (s, n) receive how many there
    are and the averages, 0 where there are none.
    """
    for e in range(len(owners)):
        counts[owners[e]] += 1.0
    for mode in range(len(values)):
        for e in range(len(owners)):
            means[mode, owners[e]] += values[mode, targets[e]]
        for v in range(len(counts)):
            if counts[v] > 0.0:
                means[mode, v] /= counts[v]

"""Pairing trees: the vertices of a cluster are joined in pairs, the pairs in pairs, and so on up to one root.

The tree follows from the connectivity alone, in whole numbers.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

import numpy as np

from shapery_motion.compiled import kernel


@kernel
def pairing_tree(starts, neighbours):
    """Join the vertices of a graph in pairs, level by level.

    Parameters
    ----------
    starts, neighbours
        The neighbours of vertex v are `neighbours[starts[v]:starts[v + 1]]`, each once and without v.

    Returns
    -------
    children : (p, 2)
        The two nodes of each pair, p = n - 1; pair i makes node n + i.
    levels : (p,)
        The level of each pair, from 0 at the vertices up; not decreasing.
    sizes : (n + p,)
        Vertices below each node.
    links, link_starts, link_weights
        For pair i, the nodes beside its first child are ``links[link_starts[2i]:link_starts[2i + 1]]`` and those
        beside its second child follow up to ``link_starts[2i + 2]``, as they were at the pair's level, without the
        other child; the weights are the edges in between.
    inner_weights : (p,)
        Edges between the two children.
    """
    n = len(starts) - 1
    pairs = max(n - 1, 0)
    children = np.zeros((pairs, 2), dtype=np.int32)
    levels = np.zeros(pairs, dtype=np.int32)
    sizes = np.ones(n + pairs, dtype=np.int32)
    link_starts = np.zeros(2 * pairs + 1, dtype=np.int64)
    inner_weights = np.zeros(pairs, dtype=np.int32)
    links = np.zeros(4 * len(neighbours) + 16, dtype=np.int32)
    link_weights = np.zeros(len(links), dtype=np.int32)
    filled = 0

    nodes = np.arange(n).astype(np.int32)
    here_starts, here_neighbours = starts.astype(np.int64), neighbours.astype(np.int32)
    here_weights = np.ones(len(neighbours), dtype=np.int32)
    position = np.full(n + pairs, -1, dtype=np.int32)
    partner = np.full(n + pairs, -1, dtype=np.int32)
    made, level = 0, 0
    while len(nodes) > 1:
        count = len(nodes)
        for k in range(count):
            position[nodes[k]] = k
        before = made
        # small nodes choose first, and take the neighbour to which most edges per vertex lead
        largest = sizes[nodes[0]]
        for k in range(count):
            largest = max(largest, sizes[nodes[k]])
        places = np.zeros(largest + 2, dtype=np.int64)
        for k in range(count):
            places[sizes[nodes[k]] + 1] += 1
        for size in range(largest):
            places[size + 1] += places[size]
        order = np.empty(count, dtype=np.int64)
        for k in range(count):
            size = sizes[nodes[k]]
            order[places[size]] = k
            places[size] += 1
        matched = 0
        for turn in range(count):
            k = int(order[turn])
            a = nodes[k]
            if partner[a] >= 0:
                continue
            best, best_weight = -1, 0
            for e in range(here_starts[k], here_starts[k + 1]):
                b = here_neighbours[e]
                if partner[b] >= 0:
                    continue
                weight = here_weights[e]
                if best >= 0:
                    left, right = np.int64(weight) * sizes[best], np.int64(best_weight) * sizes[b]
                    if left < right or (left == right and b > best):
                        continue
                best, best_weight = b, weight
            if best >= 0:
                partner[a], partner[best] = best, a
                matched += 1
        if 4 * matched < count:
            # too few neighbours are left, or none: the remaining ones are joined as they come
            last = -1
            for k in range(count):
                a = nodes[k]
                if partner[a] < 0:
                    if last < 0:
                        last = a
                    else:
                        partner[a], partner[last] = last, a
                        last = -1
        parent = np.empty(count, dtype=np.int32)
        above = 0
        for k in range(count):
            a = nodes[k]
            b = partner[a]
            if b < 0:
                parent[k] = a
                above += 1
            elif position[b] > k:
                children[made, 0], children[made, 1] = a, b
                levels[made] = level
                sizes[n + made] = sizes[a] + sizes[b]
                parent[k] = n + made
                parent[position[b]] = n + made
                made += 1
                above += 1
        # links of this level's pairs
        for i in range(before, made):
            for side in range(2):
                k = position[children[i, side]]
                other = children[i, 1 - side]
                for e in range(here_starts[k], here_starts[k + 1]):
                    if here_neighbours[e] == other:
                        inner_weights[i] = here_weights[e]
                        continue
                    if filled == len(links):
                        grown = np.zeros(2 * filled, dtype=np.int32)
                        grown[:filled] = links
                        links = grown
                        grown_weights = np.zeros(2 * filled, dtype=np.int32)
                        grown_weights[:filled] = link_weights
                        link_weights = grown_weights
                    links[filled] = here_neighbours[e]
                    link_weights[filled] = here_weights[e]
                    filled += 1
                link_starts[2 * i + side + 1] = filled
        # the graph of the next level
        next_nodes = np.empty(above, dtype=np.int32)
        next_starts = np.zeros(above + 1, dtype=np.int64)
        next_neighbours = np.empty(here_starts[count], dtype=np.int32)
        next_weights = np.empty(here_starts[count], dtype=np.int32)
        seen = np.full(n + pairs, -1, dtype=np.int64)
        total, at = 0, 0
        for k in range(count):
            a = nodes[k]
            b = partner[a]
            if b >= 0 and position[b] < k:
                continue
            up = parent[k]
            next_nodes[at] = up
            begin = total
            for side in range(2):
                if side == 1 and b < 0:
                    continue
                at_child = k if side == 0 else position[b]
                for e in range(here_starts[at_child], here_starts[at_child + 1]):
                    to = parent[position[here_neighbours[e]]]
                    if to == up:
                        continue
                    if seen[to] >= begin:
                        next_weights[seen[to]] += here_weights[e]
                    else:
                        seen[to] = total
                        next_neighbours[total] = to
                        next_weights[total] = here_weights[e]
                        total += 1
            at += 1
            next_starts[at] = total
        for k in range(count):
            partner[nodes[k]] = -1
        nodes = next_nodes
        here_starts, here_neighbours, here_weights = next_starts, next_neighbours[:total], next_weights[:total]
        level += 1
    return (
        children,
        levels,
        sizes,
        links[:filled].copy(),
        link_starts,
        link_weights[:filled].copy(),
        inner_weights,
    )

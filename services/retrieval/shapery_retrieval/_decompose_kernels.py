"""Compiled loops of `shapery_retrieval.decompose`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def shift_once(at, feature, window, feature_window, distances, features, areas):
    """One step of manifold mean shift (Eq. 4.2) from the sample `at` with the current feature.

    Returns the sample nearest to the weighted centre on the surface, the weighted mean feature (written in place), the
    density (Eq. 4.1, with areas in place of counts), and how far the sample lies from where it was.
    """
    s, c = features.shape
    weights = np.zeros(s)
    total = 0.0
    reach = 2.0 * window
    for j in range(s):
        d = distances[at, j]
        if d > reach:
            continue
        square = 0.0
        for k in range(c):
            e = features[j, k] - feature[k]
            square += e * e
        w = areas[j] * np.exp(-((d / window) ** 2) - square / (feature_window * feature_window))
        weights[j] = w
        total += w
    if total <= 0.0:
        return at, 0.0, 0.0
    for k in range(c):
        mean = 0.0
        for j in range(s):
            mean += weights[j] * features[j, k]
        feature[k] = mean / total
    best = np.inf
    centre = at
    for i in range(s):
        if distances[at, i] > window:
            continue
        cost = 0.0
        for j in range(s):
            if weights[j] > 0.0:
                cost += weights[j] * distances[i, j] * distances[i, j]
        # the window's centre moves only where that gains something
        if cost < best * (1 - 1e-9):
            best = cost
            centre = i
    return centre, total / (window * window), distances[at, centre]


@njit(cache=True, nogil=True)
def seek_modes(windows, feature_window, distances, features, areas, steps):
    """For each of s samples its mode: the (s,) sample where it comes to rest and the (s, c) feature there."""
    s, c = features.shape
    places = np.empty(s, dtype=np.int64)
    found = np.empty((s, c))
    for i in range(s):
        at = i
        feature = features[i].copy()
        for _ in range(steps):
            following, _, _ = shift_once(at, feature, windows[i], feature_window, distances, features, areas)
            if following == at:
                break
            at = following
        places[i] = at
        found[i] = feature
    return places, found


@njit(cache=True, nogil=True)
def largest_stable_windows(modes, smallest, largest, step, feature_window, distances, features, areas, shift, density):
    """For each mode the largest window under which it is still one (section 4.4.1), and its repeatability.

    A mode is stable while the centre of its window moves by less than `shift` windows and the density has not fallen
    below `density` times that of the smallest window.
    """
    result = np.full(len(modes), smallest)
    repeats = np.ones(len(modes), dtype=np.int64)
    for k in range(len(modes)):
        window = smallest
        feature = features[modes[k]].copy()
        _, first, _ = shift_once(modes[k], feature, window, feature_window, distances, features, areas)
        while window + step <= largest:
            window += step
            feature = features[modes[k]].copy()
            _, here, moved = shift_once(modes[k], feature, window, feature_window, distances, features, areas)
            if moved > shift * window or here < density * first:
                break
            result[k] = window
            repeats[k] += 1
    return result, repeats

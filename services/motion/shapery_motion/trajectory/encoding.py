"""Encoding of a group at a given step, and what it comes to."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct, idct

from shapery_contracts.errors import InvalidInput
from shapery_motion.graph import VertexGraph
from shapery_motion.trajectory._frame_kernels import functions_of_time
from shapery_motion.trajectory.borders import Border, DecodedCluster, in_rows, numbers_within
from shapery_motion.trajectory.model import BASES, DEPENDENT_BASES, DEPENDENT_FIELDS, FIELDS, MODEL, GroupModel
from shapery_motion.trajectory.reduction import Trajectories
from shapery_motion.trajectory.streams import BasisStream, FieldStream, PairingTree

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

LARGEST: Final = (1 << 24) - (1 << 20)
"""Where whole numbers end that are coded, a little below what the format can hold."""
TRADE: Final = 0.08
DEPENDENT_TRADE: Final = 0.09
"""Squared error, in squared steps, for which a bit is spared, with plain and with dependent quantisation."""
PAYING: Final = 12.0
DEPENDENT_PAYING: Final = 13.5
"""Squared steps, divided by the squared error of a number, above which a mode's numbers may pay."""
GRID: Final = 4
"""Frames between places where a run may begin, or a multiple of it in long groups."""
PLACES: Final = (32, 64)
"""How many such places are compared in all ways at the most, when there is little time and when there is enough."""
MODES: Final = (16, 64)
"""By how many modes they are compared, likewise."""
RUN_BITS: Final = (8.0, 20.0)
"""What a further run costs by itself, likewise."""
PRODUCT: Final = 128
"""Frames up to which a run is transformed by a product of matrices where cuts are compared."""
ROUNDS: Final = 4
"""How often cuts are moved to where they cost least, at the most."""


@dataclass(frozen=True, eq=False)
class Cluster:
    """What encoding needs of a cluster, whatever the step."""

    members: IntArray
    tree: PairingTree
    border: Border
    mean: FloatArray
    """(3F,) the mean trajectory, as cosine coefficients of the runs."""
    trajectories: FloatArray
    """(n, 3F) less the mean, likewise."""
    cuts: IntArray
    energies: FloatArray
    """Falling eigenvalues of the Gram matrix of these."""
    modes: FloatArray
    """(r, 3F) orthonormal, in the order of `energies`."""


@dataclass(frozen=True, eq=False)
class Encoded:
    """A group encoded at a step."""

    step: float
    sections: tuple[tuple[str, bytes], ...]
    squared_error: float
    model: GroupModel

    @property
    def size(self) -> int:
        """Bytes of the sections."""
        return sum(len(payload) for _, payload in self.sections)


def in_runs(values: FloatArray, cuts: IntArray) -> FloatArray:
    """Return the orthonormal cosine coefficients of each run along the first axis."""
    result = np.empty_like(values)
    for first, stop in itertools.pairwise(cuts):
        result[first:stop] = dct(values[first:stop], axis=0, norm="ortho")
    return result


def out_of_runs(coefficients: FloatArray, cuts: IntArray) -> FloatArray:
    """Return what `in_runs` was given."""
    result = np.empty_like(coefficients)
    for first, stop in itertools.pairwise(cuts):
        result[first:stop] = idct(coefficients[first:stop], axis=0, norm="ortho")
    return result


def principal_modes(points: FloatArray, step: float, numbers: int) -> tuple[FloatArray, FloatArray]:
    """Return energies and modes (r, d) of the points (n, d) that may ever pay at a step, as numbers of a mode go."""
    n, d = points.shape
    least = step * step / 12.0 * numbers / 16.0
    energies, vectors = np.linalg.eigh(points @ points.T if n <= d else points.T @ points)
    energies, vectors = energies[::-1], vectors[:, ::-1]
    rank = max(int((energies > least).sum()), 0)
    if n <= d:
        modes = (vectors[:, :rank].T @ points) / np.sqrt(energies[:rank])[:, None]
    else:
        modes = np.ascontiguousarray(vectors[:, :rank].T)
    return energies[:rank].copy(), modes


def prepare(
    trajectories: Trajectories, graph: VertexGraph, labels: IntArray, step: float, *, thorough: bool
) -> list[Cluster]:
    """Find the modes and the runs of each cluster.

    Parameters
    ----------
    trajectories
        Of all vertices.
    graph
        The mesh.
    labels : (n,)
        Clusters from 0 without gaps.
    step
        About the step that will be used.
    thorough
        Whether to take time for the modes and the runs: these are then the last.
    """
    n, frames, _ = trajectories.full.shape
    scratch = np.full(n, -1, dtype=np.int64)
    groups = tuple(np.flatnonzero(labels == label) for label in range(int(labels.max()) + 1))
    local = numbers_within(labels, groups)
    clusters = []
    for members in groups:
        tree = PairingTree.of_members(graph, members, scratch)
        mean = trajectories.full[members].mean(axis=0)
        own = trajectories.full[members] - mean
        points = own.reshape(len(members), -1)
        if not thorough:
            points = trajectories.points[members] - trajectories.points[members].mean(axis=0)
        energies, modes = principal_modes(points, step, len(members) + 3 * frames)
        if not thorough:
            modes = modes @ trajectories.directions
        functions = modes.reshape(len(modes), frames, 3).transpose(1, 0, 2)
        amplitudes = np.concatenate(
            (math.sqrt(len(members)) * mean[:, None], functions * np.sqrt(energies)[:, None]), axis=1
        )
        cuts = best_cuts(amplitudes / step, thorough=thorough)
        coefficients = in_runs(functions, cuts).transpose(1, 0, 2).reshape(len(modes), 3 * frames)
        transformed = in_runs(own.transpose(1, 0, 2), cuts).transpose(1, 0, 2).reshape(len(members), 3 * frames)
        border = Border.of_members(graph, members, labels, local)
        middle = in_runs(mean, cuts).reshape(-1)
        clusters.append(Cluster(members, tree, border, middle, transformed, cuts, energies, coefficients))
    return clusters


def best_cuts(amplitudes: FloatArray, *, thorough: bool) -> IntArray:
    """Return where runs should begin, so that the cosine coefficients of (F, r, 3) functions, in steps, cost least.

    All ways to cut on a coarse grid are compared (dynamic programming), runs are split further as long as that pays,
    and cuts are moved to where they cost least. If `thorough`, by more modes, on a finer grid, and to the very frame.
    """
    frames = len(amplitudes)
    # in half steps, and in single precision, which takes half the time
    values = (2.0 * amplitudes[:, : MODES[thorough]].reshape(frames, -1)).astype(np.float32)
    if values.size == 0 or frames < 2 * GRID:
        return np.array([0, frames], dtype=np.int64)
    known: dict[tuple[int, int], float] = {}

    def cost(first: int, stop: int) -> float:
        if (first, stop) not in known:
            run = _transformed(values[first:stop])
            known[first, stop] = RUN_BITS[thorough] + float(np.log2(1.0 + np.abs(run)).sum())
        return known[first, stop]

    cuts = _split(cost, _cuts_on_grid(cost, frames, GRID * -(-frames // (GRID * PLACES[thorough]))))
    for _ in range(ROUNDS if thorough else 1):
        moved = _moved(cost, cuts, 1 if thorough else 2)
        if moved == cuts:
            break
        cuts = moved
    return np.array(cuts, dtype=np.int64)


def _transformed(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return orthonormal cosine coefficients; short runs by a product of matrices, which is faster there."""
    if len(values) > PRODUCT:
        return np.asarray(dct(values, axis=0, norm="ortho"))
    return _cosines(len(values)) @ values


@cache
def _cosines(length: int) -> NDArray[np.float32]:
    return np.asarray(dct(np.eye(length, dtype=np.float32), axis=0, norm="ortho"))


def _cuts_on_grid(cost: Callable[[int, int], float], frames: int, grid: int) -> list[int]:
    places = [*range(0, frames - grid + 1, grid), frames]
    if len(places) < 3:
        return [0, frames]
    least, before = [0.0], [0]
    for stop in range(1, len(places)):
        costs = [least[first] + cost(places[first], places[stop]) for first in range(stop)]
        before.append(int(np.argmin(costs)))
        least.append(costs[before[-1]])
    cuts = [len(places) - 1]
    while cuts[-1]:
        cuts.append(before[cuts[-1]])
    return [places[cut] for cut in reversed(cuts)]


def _split(cost: Callable[[int, int], float], cuts: list[int]) -> list[int]:
    done = [0]
    waiting = list(itertools.pairwise(cuts))
    while waiting:
        first, stop = waiting.pop()
        best, place = cost(first, stop), 0
        for at in range(first + GRID, stop - GRID + 1, GRID):
            both = cost(first, at) + cost(at, stop)
            if both < best:
                best, place = both, at
        if place:
            waiting += [(first, place), (place, stop)]
        else:
            done.append(stop)
    return sorted(done)


def _moved(cost: Callable[[int, int], float], cuts: list[int], by: int) -> list[int]:
    """Move each cut to where it costs least between those beside it, by a multiple of some frames."""
    cuts = cuts.copy()
    for k in range(1, len(cuts) - 1):
        first, stop = cuts[k - 1], cuts[k + 1]
        near = range(max(first + 2, cuts[k] - 2 * GRID), min(stop - 1, cuts[k] + 2 * GRID + 1), by)
        cuts[k] = min([cuts[k], *near], key=lambda at: cost(first, at) + cost(at, stop))
    return cuts


def encode_at(
    clusters: list[Cluster],
    graph: VertexGraph,
    step: float,
    *,
    offset: FloatArray,
    sources: IntArray,
    dependent: bool = False,
) -> Encoded:
    """Encode a group at a step.

    The squared error counts a kept frame as often as it is shown. Dependent quantisation takes less room and more time.

    Raises
    ------
    InvalidInput
        ``invalid_params`` where the step is too fine for the size of the coordinates.
    """
    frames = int(clusters[0].cuts[-1])
    numbers = sum(len(c.modes) * (len(c.members) + 3 * frames) for c in clusters)
    trade, paying = (DEPENDENT_TRADE, DEPENDENT_PAYING) if dependent else (TRADE, PAYING)
    bases = BasisStream(room=8 * numbers + 64, trade=trade, dependent=dependent)
    fields = FieldStream(room=8 * numbers + 64, trade=trade, dependent=dependent)
    n = sum(len(c.members) for c in clusters)
    labels = np.zeros(n, dtype=np.int64)
    ranks = np.zeros(len(clusters), dtype=np.int64)
    error = 0.0
    done: list[DecodedCluster] = []
    shown = np.bincount(sources, minlength=frames).astype(np.float64)
    once = bool((shown == 1.0).all())
    for label, cluster in enumerate(clusters):
        labels[cluster.members] = label
        count = len(cluster.members)
        root = math.sqrt(count)
        rank = int((cluster.energies > step * step / paying * (count + 3 * frames)).sum())
        modes = cluster.modes[:rank] * np.sqrt(cluster.energies[:rank])[:, None]
        targets = np.concatenate((root * cluster.mean[None], modes)) / step
        if np.abs(targets).max() > LARGEST:
            raise InvalidInput(
                "invalid_params",
                "The bound is too fine for coordinates of this size.",
                "Allow a larger error, or move the motion nearer to the origin.",
            )
        levels = bases.code(cluster.cuts, 1 + rank, targets.reshape(1 + rank, frames, 3))
        ranks[label] = 1 + rank
        flat = 0.5 * levels.reshape(1 + rank, -1).astype(np.float64)
        moved = cluster.trajectories + (cluster.mean - flat[0] * (step / root))
        flat = flat[1:]
        used = np.asarray(flat.any(axis=1))
        flat[used] /= np.sqrt((flat[used] ** 2).sum(axis=1))[:, None]
        # the fields are fitted anew to the bases as a decoder will have them
        wanted, carry = fitted(flat, used, moved)
        functions = np.zeros((frames, 1 + rank, 3))
        functions_of_time(cluster.cuts, levels, functions)
        beside = cluster.border, done
        decoded = fields.code_around_mean(cluster.tree, levels, in_rows(functions), *beside, wanted / step, carry)
        done.append(DecodedCluster.of(decoded, functions))
        rest = moved - (decoded[1:].T * step) @ flat
        if once:
            error += float((rest**2).sum())
        else:
            in_time = out_of_runs(rest.reshape(count, frames, 3).transpose(1, 0, 2), cluster.cuts)
            error += float(shown @ (in_time**2).sum(axis=(1, 2)))
    model = GroupModel(offset, step, sources, labels, ranks, tuple(c.cuts for c in clusters))
    sections = (
        (MODEL, model.pack(graph)),
        (DEPENDENT_BASES if dependent else BASES, bases.stream.finished()),
        (DEPENDENT_FIELDS if dependent else FIELDS, fields.stream.finished()),
    )
    return Encoded(step, sections, error, model)


def fitted(functions: FloatArray, used: NDArray[np.bool_], trajectories: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fit fields to functions of time by least squares.

    Parameters
    ----------
    functions : (r, t)
        Of unit norm, or 0.
    used : (r,)
        Which are not 0.
    trajectories : (n, t)
        What is to be fitted.

    Returns
    -------
    (n, r), (r, r)
        The fields; and by how much of the error of each field the later ones should change, so that they make up for
        it as well as they can.
    """
    gram = functions @ functions.T
    gram[~used, ~used] = 1.0
    fields = np.linalg.solve(gram, functions @ trajectories.T).T
    lower = np.linalg.cholesky(gram[::-1, ::-1])
    carry = -np.linalg.inv(lower / np.diag(lower))[::-1, ::-1]
    return np.ascontiguousarray(fields), np.triu(carry, 1)

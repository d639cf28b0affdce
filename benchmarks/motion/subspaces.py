"""Peers that find the few motions in a sequence by principal components.

All of them code whole numbers with the range coder of the dissertation's codec (adaptive contexts by column and by the
size of neighbours), with one step for all: in the products of fields and bases it bears on both sides alike. A
component is kept where it pays, the fields are fitted anew to the rounded bases, and the step is brought to the error
that is asked for.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.motion.case import Case, Coded, to_target
from shapery_motion.gradient.streams import IntegerStream
from shapery_motion.gradient.traversal import Traversal, traverse

FloatArray = NDArray[np.float64]
PAYS = (1.5, 3.0, 6.0)
"""How many times the energy of its rounding a component must have; the best is taken, clustered the middle one."""

COUNTS = (2, 4, 8, 16, 32, 64, 128)
"""The numbers of clusters that are tried."""


@dataclass(frozen=True, eq=False)
class Part:
    """A block of the data as a product: fields (p, k) times the transposed bases (q, k), plus a mean (q,)."""

    rows: NDArray[np.int64]
    """Which rows of the data (vertices) the block has."""
    mean: FloatArray
    fields: FloatArray
    bases: FloatArray
    """Orthonormal columns."""


def principal(rows: NDArray[np.int64], block: FloatArray) -> Part:
    """Return all components of a block (p, q), largest first."""
    mean = block.mean(axis=0)
    centred = block - mean
    if len(centred) < centred.shape[1]:
        left, sizes, right = np.linalg.svd(centred, full_matrices=False)
        return Part(rows, mean, left * sizes, right.T)
    values, vectors = np.linalg.eigh(centred.T @ centred)
    keep = np.argsort(values)[::-1]
    bases = vectors[:, keep]
    return Part(rows, mean, centred @ bases, bases)


@dataclass(frozen=True, eq=False)
class Rounded:
    """A part in whole numbers."""

    mean: NDArray[np.int64]
    fields: NDArray[np.int64]
    bases: NDArray[np.int64]
    sizes: FloatArray
    """(k,) the singular values, in single precision: what the bases are scaled by."""

    def decoded(self, step: float) -> FloatArray:
        """Return the block (p, q)."""
        bases = self.bases * step / np.maximum(self.sizes, 1e-300)
        return np.asarray((self.fields * step) @ bases.T + self.mean * (step / math.sqrt(len(self.fields))))


def rounded(part: Part, step: float, pays: float, *, plain: bool = False) -> Rounded:
    """Round a part; components that do not pay are left out. `plain` does not fit the fields to the rounded bases."""
    p, q = len(part.fields), len(part.bases)
    energy = (part.fields**2).sum(axis=0)
    k = int(np.count_nonzero(energy > pays * step**2 / 12 * (p + q)))
    sizes = np.sqrt(energy[:k]).astype(np.float32).astype(np.float64)
    bases = np.rint(part.bases[:, :k] * sizes / step).astype(np.int64)
    scaled = bases * step / np.maximum(sizes, 1e-300)
    # the best fields for the rounded bases, of the data within the kept components
    target = part.fields[:, :k] @ (part.bases[:, :k].T @ scaled)
    fields = np.linalg.solve(scaled.T @ scaled + 1e-12 * np.eye(k), target.T).T if k else np.zeros((p, 0))
    if plain:
        fields = part.fields[:, :k]
    mean = np.rint(part.mean / (step / math.sqrt(p))).astype(np.int64)
    return Rounded(mean, np.rint(fields / step).astype(np.int64), bases, sizes)


def coded_bytes(
    found: list[Rounded], residuals: list[NDArray[np.int64]], coordinates: int, *, plain: bool = False
) -> tuple[int, float]:
    """Return the bytes of all parts (means, sizes, bases, residuals of the fields), and the CPU time of decoding them.

    Bases and means are predicted in time, unless `plain`, from the two frames before; `coordinates` follow each other
    in a row.
    """
    streams: list[tuple[bytes, int, int]] = []
    for part, fields in zip(found, residuals, strict=True):
        columns = np.concatenate((part.mean[:, None], part.bases), axis=1)
        k = columns.shape[1]
        for values in (columns if plain else _in_time(columns, coordinates), fields):
            if values.shape[1]:
                stream = IntegerStream(values.shape[1])
                stream.write(values)
                streams.append((stream.finish(), values.shape[1], len(values)))
        streams.append((part.sizes.astype(np.float32).tobytes() + bytes(8), 0, k))
    start = time.process_time()
    for data, columns_count, rows in streams:
        if columns_count:
            IntegerStream(columns_count, memoryview(data)).read(rows)
    return sum(len(data) for data, _, _ in streams), time.process_time() - start


def _in_time(columns: NDArray[np.int64], coordinates: int) -> NDArray[np.int64]:
    """Predict rows (frames × coordinates, k) linearly or by the last, whichever leaves less."""
    frames = columns.reshape(-1, coordinates, columns.shape[1])
    first = np.diff(frames, axis=0, prepend=0)
    second = np.diff(first, axis=0, prepend=0)
    best = min((frames, first, second), key=lambda found: float(np.log2(1 + np.abs(found)).sum()))
    return np.asarray(best.reshape(columns.shape))


def trajectory_pca(case: Case, kg: float) -> Coded | None:
    """Trajectories in one basis, their coefficients predicted by the parallelogram (like Coddyac)."""
    return clustered(case, kg, np.zeros(case.frames.shape[1], dtype=np.int64), 0, {})


def clustered(
    case: Case,
    kg: float,
    labels: NDArray[np.int64],
    label_bytes: int,
    settings: dict[str, int],
    trials: tuple[float, ...] = PAYS,
    *,
    plain: bool = False,
) -> Coded | None:
    """Trajectories in one basis for each cluster of vertices."""
    walk = traverse(case.faces, case.frames.shape[1])
    data = np.ascontiguousarray(case.frames.transpose(1, 0, 2)).reshape(case.frames.shape[1], -1)
    parts = [principal(rows, data[rows]) for rows in (np.flatnonzero(labels == c) for c in range(labels.max() + 1))]
    best: Coded | None = None
    for pays in trials:

        def attempt(step: float, pays: float = pays) -> float:
            return case.kg(_frames([(part, rounded(part, step, pays, plain=plain)) for part in parts], step, case))

        step = to_target(attempt, 2 * kg / 100 * case.spread, kg)
        if not step:
            continue
        found = [rounded(part, step, pays, plain=plain) for part in parts]
        fields = [whole.fields for whole in found]
        if not plain:
            fields = [_predicted(part, whole, walk, labels) for part, whole in zip(parts, found, strict=True)]
        total, seconds = coded_bytes(found, fields, 3, plain=plain)
        if best is None or total + label_bytes < best.motion_bytes:
            start = time.process_time()
            decoded = _frames(list(zip(parts, found, strict=True)), step, case)
            seconds += time.process_time() - start
            modes = sum(whole.fields.shape[1] for whole in found)
            best = Coded(total + label_bytes, decoded, seconds, settings={**settings, "modes": modes})
    return best


def _frames(found: list[tuple[Part, Rounded]], step: float, case: Case) -> FloatArray:
    data = np.empty((case.frames.shape[1], 3 * case.frames.shape[0]))
    for part, whole in found:
        data[part.rows] = whole.decoded(step)
    return np.asarray(data.reshape(case.frames.shape[1], -1, 3).transpose(1, 0, 2))


def _predicted(part: Part, whole: Rounded, walk: Traversal, labels: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the differences of fields from their parallelograms, where those lie in the cluster, in coding order."""
    n, k = len(labels), whole.fields.shape[1]
    values = np.zeros((n, k), dtype=np.int64)
    values[part.rows] = whole.fields
    mine = np.zeros(n, dtype=bool)
    mine[part.rows] = True
    order = walk.vertex_order[mine[walk.vertex_order]]
    a, b, c = walk.predictors[order].T
    here = [(axis >= 0) & mine[axis] for axis in (a, b, c)]
    full = here[0] & here[1] & here[2]
    predicted = np.zeros((len(order), k), dtype=np.int64)
    predicted[1:] = values[order[:-1]]
    for corner, inside in ((b, here[1]), (a, here[0])):
        predicted[inside] = values[corner[inside]]
    both = here[0] & here[1] & ~full
    predicted[both] = (values[a[both]] + values[b[both]]) >> 1
    predicted[full] = values[a[full]] + values[b[full]] - values[c[full]]
    # a parallelogram suits smooth fields, none suits rough ones: decided component by component
    averaged = predicted.copy()
    averaged[full] = (values[a[full]] + values[b[full]]) >> 1
    choices = [values[order], values[order] - predicted, values[order] - averaged]
    costs = np.stack([np.log2(1 + np.abs(choice)).sum(axis=0) for choice in choices])
    best = costs.argmin(axis=0) if k else np.zeros(0, dtype=int)
    return np.stack(choices)[best, :, np.arange(k)].T.reshape(len(order), k)


def clustered_pca(case: Case, kg: float, counts: tuple[int, ...] = COUNTS, *, plain: bool = False) -> Coded | None:
    """Trajectories in a basis for each cluster, with the number of clusters that does best.

    The search goes from the middle of `counts` to either side for as long as that gains. `plain` is the method as it
    was published: rounded components through an entropy coder. Otherwise it has the predictions and the fitting of the
    other peers.

    References
    ----------
    M. Sattler, R. Sarlette, R. Klein, Simple and efficient compression of animation sequences, Symposium on Computer
    Animation 2005, doi:10.1145/1073368.1073398.
    """
    middle = len(counts) // 2
    best = _with_clusters(case, kg, counts[middle], plain=plain)
    for side in (counts[middle + 1 :], counts[:middle][::-1]):
        for count in side:
            found = _with_clusters(case, kg, count, plain=plain)
            if found is None or (best is not None and found.motion_bytes >= best.motion_bytes):
                break
            best = found
    return best


def _with_clusters(case: Case, kg: float, count: int, *, plain: bool) -> Coded | None:
    if count * 8 > case.frames.shape[1]:
        return None
    labels = subspace_clusters(case, count)
    stream = IntegerStream(1)
    order = traverse(case.faces, len(labels)).vertex_order
    stream.write(np.diff(labels[order], prepend=0).reshape(-1, 1))
    return clustered(case, kg, labels, len(stream.finish()), {"clusters": count}, PAYS[1:2], plain=plain)


_CLUSTERS: dict[tuple[str, int], NDArray[np.int64]] = {}


def subspace_clusters(case: Case, count: int, *, dimensions: int = 6, rounds: int = 8) -> NDArray[np.int64]:
    """Group vertices by the subspaces of their trajectories (Lloyd's iteration on the error of reconstruction)."""
    if (case.name, count) in _CLUSTERS:
        return _CLUSTERS[case.name, count]
    data = np.ascontiguousarray(case.frames.transpose(1, 0, 2)).reshape(case.frames.shape[1], -1)
    # distances between trajectories are kept by their first components
    whole = principal(np.arange(len(data)), data)
    keep = min(60, whole.fields.shape[1])
    points = whole.fields[:, :keep]
    rng = np.random.default_rng(0)
    centres = points[[int(rng.integers(len(points)))]]
    while len(centres) < count:
        nearest = ((points[:, None] - centres) ** 2).sum(axis=2).min(axis=1)
        centres = np.concatenate((centres, points[[int(nearest.argmax())]]))
    labels = ((points[:, None] - centres) ** 2).sum(axis=2).argmin(axis=1)
    for _ in range(rounds):
        errors = np.full((len(points), count), math.inf)
        for c in range(count):
            mine = points[labels == c]
            if len(mine) <= dimensions:
                continue
            centred = points - mine.mean(axis=0)
            values, vectors = np.linalg.eigh(np.cov(mine.T))
            bases = vectors[:, np.argsort(values)[::-1][:dimensions]]
            errors[:, c] = (centred**2).sum(axis=1) - ((centred @ bases) ** 2).sum(axis=1)
        fresh = errors.argmin(axis=1)
        if np.array_equal(fresh, labels):
            break
        labels = fresh
    labels = np.unique(labels, return_inverse=True)[1].astype(np.int64)
    _CLUSTERS[case.name, count] = labels
    return labels


def shape_pca(case: Case, kg: float) -> Coded | None:
    """Frames as combinations of eigenshapes; their weights are predicted in time."""
    n = case.frames.shape[1]
    walk = traverse(case.faces, n)
    # rows are coordinates, columns frames: the fields are the eigenshapes
    part = principal(np.arange(3 * n), np.ascontiguousarray(case.frames.reshape(len(case.frames), -1).T))
    best: Coded | None = None
    for pays in PAYS:

        def attempt(step: float, pays: float = pays) -> float:
            return case.kg(rounded(part, step, pays).decoded(step).T.reshape(case.frames.shape))

        step = to_target(attempt, 2 * kg / 100 * case.spread, kg)
        if not step:
            continue
        whole = rounded(part, step, pays)
        k = whole.fields.shape[1]
        shapes = [walk.residuals(np.ascontiguousarray(whole.fields[:, j].reshape(n, 3))) for j in range(k)]
        fields = np.concatenate(shapes, axis=1) if k else np.zeros((n, 0), dtype=np.int64)
        total, seconds = coded_bytes([whole], [fields], 1)
        if best is None or total < best.motion_bytes:
            start = time.process_time()
            decoded = np.asarray(whole.decoded(step).T.reshape(case.frames.shape))
            seconds += time.process_time() - start
            best = Coded(total, decoded, seconds, settings={"modes": k})
    return best

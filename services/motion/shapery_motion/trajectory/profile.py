"""The profile ``trajectory``: see `shapery_motion.profiles.Profile`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import IntArray
from shapery_motion.container.sections import damaged
from shapery_motion.graph import VertexGraph
from shapery_motion.profiles import EncodedGroup, GroupTask
from shapery_motion.trajectory import _frame_kernels as kernels
from shapery_motion.trajectory.borders import Border, DecodedCluster, in_rows, numbers_within
from shapery_motion.trajectory.clustering import FEW, MANY, SHARE, Worth, find_clusters, share_of
from shapery_motion.trajectory.encoding import LARGEST, Cluster, Encoded, encode_at, prepare
from shapery_motion.trajectory.model import (
    BASES,
    DEPENDENT_BASES,
    DEPENDENT_FIELDS,
    FARTHEST,
    FIELDS,
    FIRST_FIELDS,
    MODEL,
    SECOND_FIELDS,
    GroupModel,
)
from shapery_motion.trajectory.reduction import Trajectories
from shapery_motion.trajectory.streams import BasisStream, FieldStream, PairingTree

FloatArray = NDArray[np.float64]

PART_NAMES: Final = {
    MODEL: "clusters",
    BASES: "bases",
    FIELDS: "fields",
    DEPENDENT_BASES: "bases",
    DEPENDENT_FIELDS: "fields",
}
TAIL: Final = 3.5
"""Where only the largest error is bounded, the root mean squared one is this many times smaller; vertices farther off
are corrected one by one."""
FIRST: Final = 4.5
"""Squared step, in mean squared errors of a vertex, where the search for it begins."""
SLOPE: Final = 0.39
"""By which power of the squared error the size falls, about: by 42 % from one error to twice the error."""
COARSER: Final = (2.0, 5.0)
ONE_COARSER: Final = (2.5,)
"""Steps beside the one that is used, in its units, at which the report tells rate and error, when there is time and
when there is none."""
LOOKS: Final = (1, 2)
"""Quick encodings before clusters are sought, when there is no time and when there is."""
QUICK: Final = 1000
"""Clusters times vertices, a frame, from which merging starts when there is no time."""
LOOK_MOVES: Final = (3, 0)
MOVES: Final = ((3, 3), (6, 8))
"""How often vertices are moved before and after clusters are merged, in a quick look, and for the clusters themselves
when there is no time and when there is."""
LONG: Final = 64
"""Frames from which on it is worth the time to seek clusters from a second start."""
COARSENED: Final = 1.095
"""By how much the step may grow, about, when quantisation becomes dependent."""
PASSES: Final = 3
MOST_PASSES: Final = 12
"""How many trials the search for the step takes, about, and at the most."""
APART: Final = 0.01
"""Logarithms of steps that lie apart enough to tell how the error grows."""
NEAR: Final = 0.994
NEAR_ENOUGH: Final = 0.97
"""Share of the allowed squared error that is used up at least before the search for the step ends, when there is time
and when there is none. With dependent quantisation errors are no smooth function of the step, and differ by half a
percent between steps next to each other."""


def encode_group(task: GroupTask) -> EncodedGroup:
    """Encode a group of frames: see `shapery_motion.profiles.Profile`."""
    frames, n = len(task.frames), task.frames.shape[1]
    if not np.abs(task.frames).max(initial=0.0) <= 1e-3 * FARTHEST:
        raise InvalidInput("invalid_mesh", f"Coordinates may be at most {1e-3 * FARTHEST:g}.", "Use another unit.")
    graph = VertexGraph.of_faces(n, task.faces)
    allowed = min(task.squared_error, frames * n * (task.largest / TAIL) ** 2)
    if not math.isfinite(allowed) or allowed <= 0.0:
        raise InvalidInput("invalid_params", "The error must be bounded by a number greater than 0.")
    sources, kept = repeated_frames(task.frames, 0.01 * allowed / frames)
    moving = task.frames[kept]
    offset = moving.mean(axis=(0, 1))
    full = np.ascontiguousarray((moving - offset).transpose(1, 0, 2))
    lost = float(sum(((task.frames[f] - moving[s]) ** 2).sum() for f, s in enumerate(sources)))
    # what the differences of frames shown more than once add to the error, about
    target = allowed - lost
    trajectories = Trajectories.of(full, target)
    step = max(math.sqrt(FIRST * target / (frames * n)), trajectories.size / LARGEST)
    thorough = task.preset == "default"
    step, worth = quick_look(trajectories, graph, step, target, looks=LOOKS[thorough], offset=offset, sources=sources)
    many: tuple[int, ...] = (min(MANY[0], max(FEW[0], QUICK * len(moving) // n)),)
    if thorough:
        many = MANY if len(moving) >= LONG else MANY[:1]
    moves = MOVES[thorough]
    ways = find_clusters(trajectories.points, graph, step, worth, count=task.clusters, many=many, moves=moves)
    task.on_progress(0.2)
    labels = ways[0]
    if thorough:
        labels, step = choose_way(trajectories, graph, step, ways, target, task, offset=offset, sources=sources)
    clusters = prepare(trajectories, graph, labels, step, thorough=thorough)
    task.on_progress(0.4)
    near = NEAR if thorough else NEAR_ENOUGH
    best: Encoded | None = None
    low, high = 0.0, math.inf
    slope, tried = 1.8, (0.0, 0.0)
    for number in range(MOST_PASSES):
        task.check_cancelled()
        made = encode_at(clusters, graph, step, offset=offset, sources=sources, dependent=thorough)
        ratio = made.squared_error / target
        if ratio <= 1.0:
            if best is None or made.size < best.size:
                best = made
            low = max(low, step)
            if ratio >= near:
                break
        else:
            high = min(high, step)
        # the error grows with a power of the step, about; two trials tell which if they lie apart
        here = (math.log(step), math.log(max(ratio, 1e-9)))
        if number and abs(here[0] - tried[0]) > APART:
            slope = min(max((here[1] - tried[1]) / (here[0] - tried[0]), 0.7), 2.5)
        tried = here
        aim = 0.5 * (1.0 + near) - (0.0 if best else 0.001 * number)
        guess = step * (aim / max(ratio, 1e-9)) ** (1.0 / slope)
        step = guess if low < guess < high else math.sqrt(max(low, guess / 4) * min(high, guess * 4))
        task.on_progress(0.4 + 0.6 * min(1.0, (number + 1) / PASSES))
    if best is None:
        raise InvalidInput("invalid_params", "The bound is too fine: it could not be met.", "Allow a larger error.")
    points = [(best.squared_error + lost, best.size)]
    for coarser in COARSER if thorough else ONE_COARSER:
        task.check_cancelled()
        # plain quantisation takes a few percent more room and a third of the time
        made = encode_at(clusters, graph, best.step * coarser, offset=offset, sources=sources)
        points.append((made.squared_error + lost, made.size))
    return EncodedGroup(
        sections=best.sections,
        memory=best.model.memory,
        labels=best.model.labels.astype(np.int32),
        points=tuple(points),
        part_names=PART_NAMES,
    )


def choose_way(
    trajectories: Trajectories,
    graph: VertexGraph,
    step: float,
    ways: list[NDArray[np.int64]],
    target: float,
    task: GroupTask,
    *,
    offset: FloatArray,
    sources: NDArray[np.int64],
) -> tuple[NDArray[np.int64], float]:
    """Return those clusters with which a quick encoding is smallest, and the step to go on with."""
    least, labels, best_step = math.inf, ways[0], step
    for number, way in enumerate(ways):
        task.check_cancelled()
        prepared = prepare(trajectories, graph, way, step, thorough=False)
        made = encode_at(prepared, graph, step, offset=offset, sources=sources)
        # sizes at equal errors, as far as rates follow a power of the error
        size = made.size * (made.squared_error / target) ** SLOPE
        if size < least:
            # dependent quantisation errs less at the same step
            least, labels, best_step = size, way, step * COARSENED * nearer(target, made.squared_error)
        task.on_progress(0.2 + 0.2 * (number + 1) / len(ways))
    return labels, best_step


def expected_step(clusters: list[Cluster], target: float) -> float:
    """Return about the step that meets a squared error, from the energies of the modes alone."""
    frames = int(clusters[0].cuts[-1])
    low, high = 0.0, math.sqrt(12.0 * target)
    for _ in range(40):
        step = 0.5 * (low + high)
        lost = 0.0
        for cluster in clusters:
            rounding = step * step / 12.0 * (len(cluster.members) + 3 * frames)
            lost += 3 * frames * step * step / 12.0 + float(np.minimum(cluster.energies, rounding).sum())
        low, high = (step, high) if lost <= target else (low, step)
    return low


def nearer(target: float, found: float) -> float:
    """Return by what a step should be multiplied for another squared error than the one that was found, about."""
    return min(max(math.pow(target / max(found, 1e-300), 1.0 / 1.8), 0.2), 5.0)


def quick_look(
    trajectories: Trajectories,
    graph: VertexGraph,
    step: float,
    target: float,
    *,
    looks: int,
    offset: FloatArray,
    sources: NDArray[np.int64],
) -> tuple[float, Worth]:
    """Return about the step that meets a squared error, and what modes cost there, from quick encodings."""
    worth = Worth(trajectories.full.shape[1], SHARE, SHARE)
    for look in range(looks):
        labels = find_clusters(trajectories.points, graph, step, worth, count=None, many=FEW, moves=LOOK_MOVES)[0]
        clusters = prepare(trajectories, graph, labels, step, thorough=False)
        if not look:
            # a step that is finer than the one that will be used must not be too fine for the coder
            step = max(expected_step(clusters, target), trajectories.size / LARGEST)
        made = encode_at(clusters, graph, step, offset=offset, sources=sources)
        worth = worth_of(clusters, made)
        # better clusters err less than these; a little less than what is allowed is near enough
        step *= nearer(NEAR_ENOUGH * target, made.squared_error)
    return step, worth


def worth_of(clusters: list[Cluster], made: Encoded) -> Worth:
    """Return what modes cost in an encoding."""
    frames = int(clusters[0].cuts[-1])
    energies = [c.energies[: rank - 1] / made.step**2 for c, rank in zip(clusters, made.model.ranks, strict=True)]
    middles = [np.array([len(c.members) * float(c.mean @ c.mean)]) / made.step**2 for c in clusters]
    sizes = {tag: 8.0 * len(payload) for tag, payload in made.sections}
    everything = [np.concatenate(pair) for pair in zip(middles, energies, strict=True)]
    return Worth(
        frames,
        share_of(sizes[FIELDS], energies, [len(c.members) for c in clusters]),
        share_of(sizes[BASES], everything, [3 * frames] * len(clusters)),
    )


def repeated_frames(frames: FloatArray, tolerance: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Find frames that show again what an earlier one showed.

    Parameters
    ----------
    frames : (F, n, 3)
        Coordinates.
    tolerance
        Sum of squared distances up to which two frames are the same.

    Returns
    -------
    sources : (F,)
        For each frame its number among the kept ones.
    kept : (k,)
        The frames that are kept.
    """
    sources = np.zeros(len(frames), dtype=np.int64)
    kept: list[int] = []
    marks = frames.mean(axis=1)
    n = frames.shape[1]
    for f, frame in enumerate(frames):
        # means that differ tell without looking at all vertices
        away = n * ((marks[kept] - marks[f]) ** 2).sum(axis=1)
        for k in np.flatnonzero(away <= tolerance).tolist():
            if ((frame - frames[kept[k]]) ** 2).sum() <= tolerance:
                sources[f] = k
                break
        else:
            sources[f] = len(kept)
            kept.append(f)
    return sources, np.array(kept, dtype=np.int64)


class TrajectoryGroup:
    """An opened group: `frame` costs one product of small matrices for each cluster."""

    def __init__(self, model: GroupModel, fields: list[FloatArray], bases: list[FloatArray]) -> None:
        self._model = model
        self._fields = fields
        self._bases = bases
        self._members = model.members
        self._sums = np.empty((3, max(map(len, self._members))))

    def frame(self, index: int) -> FloatArray:
        """Return the vertices (n, 3) of a frame by its number within the group."""
        model = self._model
        at = int(model.sources[index])
        frame = np.empty((len(model.labels), 3))
        frame[:] = model.offset
        for fields, bases, members in zip(self._fields, self._bases, self._members, strict=True):
            kernels.add_cluster(fields, bases[at], members, frame, self._sums)
        return frame


def open_group(
    sections: Mapping[str, memoryview], frames: int, vertices: int, faces: IntArray, memory: int
) -> TrajectoryGroup:
    """Decode the streams of a group: see `shapery_motion.profiles.Profile`."""
    dependent = DEPENDENT_FIELDS in sections
    functions_tag = DEPENDENT_BASES if dependent else BASES
    tag = next((t for t in (DEPENDENT_FIELDS, FIELDS, SECOND_FIELDS, FIRST_FIELDS) if t in sections), FIELDS)
    for needed in (MODEL, functions_tag, tag):
        if needed not in sections:
            raise damaged(needed, "is missing")
    graph = VertexGraph.of_faces(vertices, faces)
    model = GroupModel.unpack(sections[MODEL], frames, graph, memory)
    basis_stream = BasisStream(data=sections[functions_tag], dependent=dependent)
    field_stream = FieldStream(data=sections[tag], dependent=dependent)
    scratch = np.full(vertices, -1, dtype=np.int64)
    local = numbers_within(model.labels, model.members)
    fields: list[FloatArray] = []
    bases: list[FloatArray] = []
    done: list[DecodedCluster] = []
    for members, rank, cuts in zip(model.members, model.ranks.tolist(), model.cuts, strict=True):
        levels = basis_stream.code(cuts, rank)
        functions = np.zeros((model.kept, rank, 3))
        kernels.functions_of_time(cuts, levels, functions)
        bases.append(functions)
        basis_stream.stream.check_end(functions_tag)
        tree = PairingTree.of_members(graph, members, scratch)
        if tag == FIRST_FIELDS:
            found = field_stream.code(tree, rank)
        else:
            border, rows = Border.of_members(graph, members, model.labels, local), in_rows(functions)
            if tag == SECOND_FIELDS:
                found = field_stream.code(tree, rank, beside=border.predict(done, rows))
            else:
                found = field_stream.code_around_mean(tree, levels, rows, border, done)
            done.append(DecodedCluster.of(found, functions))
        field_stream.stream.check_end(tag)
        fields.append(found * model.step)
        if found.size and not np.abs(fields[-1]).max(axis=1).sum() <= FARTHEST:
            raise damaged(tag, "has numbers that no encoder writes")
    return TrajectoryGroup(model, fields, bases)

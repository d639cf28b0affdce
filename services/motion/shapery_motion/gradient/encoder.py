"""Encoding of a group: Algorithm 1 of section 5.4, with clusters, anchors and key frames chosen by rate and distortion.

Two ways are tried, and the shorter result is kept: to predict frames from key frames as the text does, and to store
every frame by itself, which is what meets a bound where the predictions cannot. A frame is predicted with the cheapest
combination of clusters and anchors that keeps its error within its share; where none does, or where it would cost more
than a key frame, it becomes a key frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_motion.gradient.clustering import FaceClusters, Representative, cluster_faces, cluster_matrices
from shapery_motion.gradient.deformation import FaceFrames, FloatArray, deformation_gradients, face_frames
from shapery_motion.gradient.gluing import choose_anchors, glued_parts
from shapery_motion.gradient.group import Group, KeyFrame, PredictedFrame
from shapery_motion.gradient.sections import MOST, GroupWriter
from shapery_motion.gradient.traversal import Traversal, traverse
from shapery_motion.profiles import GroupTask

TEXT_CLUSTERS: Final = 256
"""Of the text's body motions; what is used where no bound is given."""
CLUSTERS: Final = (1, 4, 16, 64, 256, 1024)
"""The numbers of clusters that are tried; the labels of more cost as much as a key frame."""
SPREADS: Final = (0, 128, 32, 8)
"""How many vertices there are to each spread anchor, in the choices that are tried; 0 for none."""
FINEST: Final = 2.0**-27
"""The least step, in extents of the group: the numbers of a stream have 31 bits."""
UNBOUNDED_STEP: Final = 2.0**-16
"""The step where no bound is given, in extents of the group."""

ENOUGH: Final = 8
"""After how many frames it is judged whether to predict at all."""
ATTEMPTS: Final = 4
"""How often the step of key frames is brought nearer to the bound."""


@dataclass(frozen=True, slots=True)
class GradientOptions:
    """What can be varied of the method; the defaults are those of the profile."""

    representative: Representative = "least_squares"
    """Of a cluster: see `cluster_matrices`."""
    spreads: tuple[int, ...] = SPREADS
    """The choices of spread anchors; (0,) is the text's method."""
    boundary: int = 8
    """Anchors along the open boundary of a part."""
    predict_only: bool = False
    """Whether the first frame and those given are the only key frames, whatever the bound."""
    seed: int = 0
    """Of the first clustering."""


@dataclass(frozen=True, eq=False)
class EncodedFrames:
    """A group, its sections, and how far it is from the original."""

    group: Group
    sections: tuple[tuple[str, bytes], ...]
    squared: FloatArray
    """(F,) squared errors of each frame, summed over its vertices."""
    largest: FloatArray
    """(F,) largest squared error of a vertex in each frame."""

    @property
    def size(self) -> int:
        """Bytes of all sections' payloads."""
        return sum(len(payload) for _, payload in self.sections)


@dataclass(frozen=True, eq=False)
class _Candidate:
    frame: KeyFrame | PredictedFrame
    bytes: int
    squared: float
    largest: float


def encode_frames(task: GroupTask, options: GradientOptions = GradientOptions()) -> EncodedFrames:
    """Encode a group of frames.

    Parameters
    ----------
    task
        The frames, their bounds, and what was chosen for them.
    options
        Of the method.

    Raises
    ------
    InvalidInput
        ``invalid_params`` for a bound that is finer than the format can tell, ``invalid_mesh`` for coordinates that
        are too large for it.
    """
    walk = traverse(task.faces, task.frames.shape[1])
    extent, origin = _extent(task.frames)
    bounded = math.isfinite(task.squared_error) or math.isfinite(task.largest)
    if not bounded:
        unbounded = _predict(task, options, walk, origin, extent * UNBOUNDED_STEP, None)
        assert unbounded is not None
        return unbounded
    alone = None if options.predict_only else _alone(task, walk, origin, extent)
    step = _step(task, extent, 0.5)
    predicted = _predict(task, options, walk, origin, step, alone.size if alone else None)
    if predicted is None or (alone is not None and alone.size <= predicted.size):
        assert alone is not None
        return alone
    return predicted


def _extent(frames: FloatArray) -> tuple[float, FloatArray]:
    low, high = frames.min(axis=(0, 1)), frames.max(axis=(0, 1))
    extent = float((high - low).max())
    if max(float(np.abs(low).max()), float(np.abs(high).max())) > MOST:
        raise InvalidInput("invalid_mesh", f"Coordinates may be at most {MOST:g} in size.", "Use another unit.")
    return max(extent, float(np.abs(low).max()) * 1e-15, 1e-20), low


def _step(task: GroupTask, extent: float, share: float) -> float:
    """Return the step whose rounding uses `share` of the root of what is allowed.

    Rounding errs by step²/12 in each coordinate on the mean, and by √3/2 steps at most.
    """
    frames, vertices = task.frames.shape[:2]
    allowed = 2 * math.sqrt(task.squared_error / (frames * max(vertices, 1)))
    step = share * min(allowed, 2 / math.sqrt(3) * task.largest * (1 - 1e-9))
    if step < extent * FINEST:
        # exact equality was asked for, which a grid gives only by chance; the caller sees what came of it
        return extent * FINEST
    return min(step, extent)


def _errors(original: FloatArray, decoded: FloatArray) -> tuple[float, float]:
    squared = ((original - decoded) ** 2).sum(axis=1)
    return float(squared.sum()), float(squared.max(initial=0.0))


def _alone(task: GroupTask, walk: Traversal, origin: FloatArray, extent: float) -> EncodedFrames:
    """Store every frame by itself, as coarsely as the bounds allow."""
    step, squared, largest = _step(task, extent, 1.0), np.zeros(len(task.frames)), np.zeros(len(task.frames))
    for attempt in range(ATTEMPTS):
        group = Group(task.faces, origin, step)
        for number, frame in enumerate(task.frames):
            squared[number], largest[number] = _errors(frame, group.placed(group.snapped(frame)))
        if squared.sum() <= task.squared_error and largest.max() <= task.largest**2:
            break
        over = max(squared.sum() / max(task.squared_error, 1e-300), largest.max() / max(task.largest**2, 1e-300))
        step = max(step * 0.999 / math.sqrt(max(over, 1.0)), extent * FINEST)
        if attempt == ATTEMPTS - 2:
            # few vertices do not err like the mean of many: no vertex errs by more than this allows to each
            step = max(min(step, _step(task, extent, 1 / math.sqrt(3))), extent * FINEST)
    writer = GroupWriter(group, walk)
    for frame in task.frames:
        task.check_cancelled()
        key = KeyFrame(group.snapped(frame), np.zeros(0, dtype=np.int32))
        group.frames.append(key)
        writer.write_key(key)
    return EncodedFrames(group, writer.finish(), squared, largest)


def _predict(
    task: GroupTask, options: GradientOptions, walk: Traversal, origin: FloatArray, step: float, rival: int | None
) -> EncodedFrames | None:
    """Predict frames from key frames; give up, with nothing, where that promises to become longer than `rival`."""
    predictor = _Predictor(task, options, Group(task.faces, origin, step), walk)
    count, first = len(task.frames), 0
    for number in range(count):
        task.check_cancelled()
        predictor.encode(number)
        task.on_progress((number + 1) / count)
        first = first or predictor.writer.size
        if rival is not None and number >= min(ENOUGH, count - 1):
            # the first frame is dearer than the others, which go on as they did so far
            promised = first + (predictor.writer.size - first) * (count - 1) / number if number else first
            if promised > rival:
                return None
    return EncodedFrames(predictor.group, predictor.finish(), predictor.squared, predictor.largest)


class _Predictor:
    """Walks through the frames of a group and decides on each."""

    def __init__(self, task: GroupTask, options: GradientOptions, group: Group, walk: Traversal) -> None:
        self.group, self.writer = group, GroupWriter(group, walk)
        self.squared, self.largest = np.zeros(len(task.frames)), np.zeros(len(task.frames))
        self._task, self._options = task, options
        self._rng = np.random.default_rng(options.seed)
        self._vertices = task.frames.shape[1]
        self._share = task.squared_error / len(task.frames)
        self._bounded = math.isfinite(task.squared_error) or math.isfinite(task.largest)
        self._key = 0
        self._anchors: NDArray[np.int32] = np.zeros(0, dtype=np.int32)
        self._needed = 0
        self._centres: dict[int, FloatArray] = {}
        self._last = 0
        """Position in the ladder of clusters that was chosen last."""
        solid = max(len(task.faces), 1)
        if task.clusters is not None:
            self._ladder: tuple[int, ...] = (min(task.clusters, solid),)
        elif self._bounded:
            self._ladder = tuple(k for k in CLUSTERS if k < solid) or (1,)
        else:
            self._ladder = (min(TEXT_CLUSTERS, solid),)

    def encode(self, number: int) -> None:
        """Choose how to store a frame, and write it."""
        frame = self._task.frames[number]
        key = self._as_key(frame)
        if number == 0 or number in self._task.key_frames:
            self._take_key(number, key)
            return
        allowed = self._share
        if math.isfinite(allowed):
            # half of what earlier frames have left over
            allowed += 0.5 * max(0.0, self._share * number - float(self.squared[:number].sum()))
        forced = not self._bounded or self._options.predict_only
        best = self._best_prediction(frame, allowed, math.inf if forced else key.bytes)
        if best is None or (not forced and key.bytes < best.bytes):
            self._take_key(number, key)
        else:
            assert isinstance(best.frame, PredictedFrame)
            self.group.frames.append(best.frame)
            self.writer.write_predicted(best.frame)
            self.squared[number], self.largest[number] = best.squared, best.largest

    def finish(self) -> tuple[tuple[str, bytes], ...]:
        """Return the sections."""
        return self.writer.finish()

    def _as_key(self, frame: FloatArray) -> _Candidate:
        positions = self.group.snapped(frame)
        trial = self.writer.copy()
        trial.write_key(KeyFrame(positions, self._anchors))
        squared, largest = _errors(frame, self.group.placed(positions))
        return _Candidate(KeyFrame(positions, self._anchors), trial.size - self.writer.size, squared, largest)

    def _take_key(self, number: int, key: _Candidate) -> None:
        assert isinstance(key.frame, KeyFrame)
        points = self.group.placed(key.frame.positions)
        source = face_frames(points, self.group.faces)
        parts = glued_parts(source, self._vertices)
        needed = self._anchors[: self._needed]
        if len(np.unique(parts[needed])) != parts.max(initial=-1) + 1:
            required = choose_anchors(source, points, boundary=self._options.boundary)
            densest = min((n for n in self._options.spreads if n), default=0)
            spread = self._vertices // densest if densest else 0
            self._anchors = choose_anchors(source, points, boundary=self._options.boundary, spread=spread)
            self._needed = len(required)
        stored = KeyFrame(key.frame.positions, self._anchors)
        self.group.frames.append(stored)
        self.writer.write_key(stored)
        self.squared[number], self.largest[number] = key.squared, key.largest
        self._key, self._source = number, source
        self._centres = {}

    def _best_prediction(self, frame: FloatArray, allowed: float, ceiling: float) -> _Candidate | None:
        """Return the cheapest prediction within the bounds, which is sought up to `ceiling` bytes.

        Without a ceiling the most exact is returned where none is within the bounds.
        """
        gradients = deformation_gradients(self._source, frame)
        best: _Candidate | None = None
        fallback: _Candidate | None = None
        order = sorted(range(len(self._ladder)), key=lambda place: (abs(place - self._last), place))
        chosen = self._last
        tried: dict[int, bool] = {}
        for place in order:
            # a neighbour nearer to the last choice decides whether it pays to go on in its direction
            nearer = place - 1 if place > self._last else place + 1
            if place != self._last and not tried.get(nearer, False):
                continue
            before = best
            candidates = self._predictions(frame, gradients, self._ladder[place])
            for candidate in candidates:
                within = candidate.squared <= allowed and candidate.largest <= self._task.largest**2
                if within and (best is None or candidate.bytes < best.bytes):
                    best = candidate
                if fallback is None or candidate.squared < fallback.squared:
                    fallback = candidate
            affordable = min(candidate.bytes for candidate in candidates) < ceiling
            tried[place] = best is not before or (best is None and affordable)
            if best is not before:
                chosen = place
        if best is None:
            return fallback if math.isinf(ceiling) else None
        self._last = chosen
        return best

    def _predictions(self, frame: FloatArray, gradients: FloatArray, count: int) -> list[_Candidate]:
        """Return the predictions with `count` clusters, one for each choice of anchors."""
        clusters = self._clusters(gradients, count)
        matrices = cluster_matrices(
            clusters, self._source, frame, gradients, representative=self._options.representative
        )
        whole, precision = quantised_matrices(matrices, clusters, gradients, self._source)
        found = []
        for every in self._options.spreads:
            held = min(self._needed + (self._vertices // every if every else 0), len(self._anchors))
            positions = self.group.snapped(frame[self._anchors[:held]])
            predicted = PredictedFrame(clusters.labels, whole, precision, positions)
            squared, largest = _errors(frame, self.group.predicted(predicted, self._key))
            trial = self.writer.copy()
            trial.write_predicted(predicted)
            found.append(_Candidate(predicted, trial.size - self.writer.size, squared, largest))
        return found

    def _clusters(self, gradients: FloatArray, count: int) -> FaceClusters:
        clusters = cluster_faces(
            gradients, self._source.solid, count, self._rng, initial=self._centres.get(count), iterations=8
        )
        if clusters.count == count:
            self._centres[count] = clusters.centres
        return clusters


def quantised_matrices(
    matrices: FloatArray, clusters: FaceClusters, gradients: FloatArray, source: FaceFrames
) -> tuple[NDArray[Any], int]:
    """Return the matrices (k, 9), less the identity, as whole numbers, and how many binary digits of them are a part.

    The steps are a half to the whole of the deviation of the transformations within their clusters: rounding adds one
    or two per cent to the error that clustering made, and finer steps would cost more than they bring.
    """
    points = gradients.reshape(-1, 9)[source.solid]
    spread = points - matrices.reshape(-1, 9)[clusters.labels[source.solid]]
    deviation = math.sqrt(float((spread**2).mean())) if spread.size else 1.0
    precision = min(max(math.ceil(-math.log2(max(deviation, 2.0**-24))), 4), 24)
    values = (matrices - np.eye(3)).reshape(-1, 9)
    highest = float(np.abs(values).max(initial=0.0))
    if highest > 0:
        precision = min(precision, 29 - math.ceil(math.log2(highest)))
    precision = max(precision, -100)
    return np.rint(np.ldexp(values, precision)).astype(np.int64), precision

"""Encoding of a sequence: its groups, its bounds, and the proof that they are met."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_contracts.motion import DEFAULT_KG, MotionEncodeParams
from shapery_geometry.mesh import IntArray
from shapery_geometry.sequence import MeshSequence, SequenceFile
from shapery_geometry.threads import one_blas_thread
from shapery_motion.container.connectivity import pack_connectivity, sorted_faces
from shapery_motion.container.corrections import Corrections, find_corrections
from shapery_motion.container.header import (
    MAX_GROUP_FRAMES,
    Bounds,
    Group,
    Header,
    Metadata,
    groups_bytes,
    pack_groups,
)
from shapery_motion.container.sections import (
    CONNECTIVITY,
    CORRECTIONS,
    END,
    FRAME_BYTES,
    GROUPS,
    HEAD,
    MAGIC,
    META,
    pack_section,
)
from shapery_motion.errors import ErrorMeter, SequenceErrors
from shapery_motion.playing import FrameArray, Motion
from shapery_motion.profiles import EncodedGroup, GroupTask, Profile, get_profile

FloatArray = NDArray[np.float64]
Progress = Callable[[str, float], None]

GROUP_BYTES: Final = 256 << 20
"""Of the coordinates of a group's frames, in double precision."""
GROUP_FRAMES: Final = 512
ATTEMPTS: Final = 4
"""How often a group is encoded at the most, each time a little finer, until its bounds hold as decoded."""


@dataclass(frozen=True, eq=False)
class Encoding:
    """An encoded sequence."""

    data: bytes
    """The file."""
    header: Header
    parts: dict[str, int]
    """Bytes by part of the file; they sum to its length."""
    errors: SequenceErrors
    """Measured on the decoded file."""
    clusters: int
    """Over all groups."""
    labels: IntArray
    """(n,) the cluster of each vertex in the first group."""
    points: tuple[tuple[float, int], ...]
    """KG errors in percent and bytes of motion, of this encoding and of coarser ones."""
    warnings: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Allowed:
    """What the errors may be."""

    squared: float
    """Sum of the squared distances over all vertices and frames."""
    largest: float


def _ignore(_stage: str, _fraction: float) -> None:
    return


@one_blas_thread()
def encode(
    sequence: MeshSequence | SequenceFile,
    params: MotionEncodeParams | None = None,
    *,
    on_progress: Progress = _ignore,
    check_cancelled: Callable[[], None] = lambda: None,
    on_verified: Callable[[SequenceErrors, FrameArray, FrameArray], None] = lambda *_: None,
) -> Encoding:
    """Compress a sequence.

    Parameters
    ----------
    sequence
        In memory, or a file, which is then read three times, a group of frames at a time.
    params
        Bounds and choices.
    on_progress
        Called with the stage (``read``, ``encode``, ``verify``) and the fraction of the whole that is done.
    check_cancelled
        Called often; what it raises ends the work.
    on_verified
        Called with the errors of the whole, and each frame as it was and as the file gives it, in their order.

    Returns
    -------
    Encoding
        The file, and what was measured on it.

    Raises
    ------
    InvalidInput
        What the sequence's reader raises; ``invalid_params`` where a bound cannot be met; ``empty_content``.
    """
    params = _with_a_bound(params or MotionEncodeParams())
    faces = sorted_faces(sequence.faces)
    count, vertices = shape_of(sequence)
    if not vertices:
        raise InvalidInput("empty_content", "The frames have no vertices.")
    on_progress("read", 0.0)
    original, farthest = _measure(sequence, faces, check_cancelled)
    allowed, warnings = _allowed(original, farthest, params, count * vertices)
    profile = get_profile(params.profile)
    sizes = _group_sizes(count, vertices, params)
    if any(key >= count for key in params.key_frames):
        raise InvalidInput("invalid_params", f"Key frame {max(params.key_frames)} is none of the {count} frames.")
    meter = ErrorMeter(faces, vertices, surface=False)
    double = _is_double(sequence)
    made: list[EncodedGroup] = []
    bodies: list[list[bytes]] = []
    parts = {"container": 0, "connectivity": 0}
    memory = 0
    first = 0
    for number, frames in enumerate(_batches(sequence, sizes)):
        check_cancelled()

        def report(fraction: float, done: int = first, here: int = len(frames)) -> None:
            on_progress("encode", min(0.95, 0.05 + 0.9 * (done + fraction * here) / count))

        task = GroupTask(
            frames=frames,
            faces=faces,
            squared_error=allowed.squared * len(frames) / count,
            largest=allowed.largest,
            preset=params.preset,
            clusters=params.clusters,
            key_frames=tuple(key - first for key in params.key_frames if first <= key < first + len(frames)),
            check_cancelled=check_cancelled,
            on_progress=report,
        )
        group, corrections = _within_bounds(profile, task, meter, double)
        made.append(group)
        memory = max(memory, group.memory + corrections.memory)
        body = [pack_section(tag, payload) for tag, payload in group.sections]
        for (tag, _), section in zip(group.sections, body, strict=True):
            name = group.part_names.get(tag, tag)
            parts[name] = parts.get(name, 0) + len(section)
        if len(corrections):
            body.append(pack_section(CORRECTIONS, corrections.pack(len(frames), vertices)))
            parts["corrections"] = parts.get("corrections", 0) + len(body[-1])
        bodies.append(body)
        first += sizes[number]
    errors = meter.result()
    met = Bounds(errors.kg_percent, errors.rmse_edges, errors.largest_fraction)
    asked = Bounds(*(math.nan if v is None else v for v in (params.kg, params.rmse, params.max_error)))
    connectivity = pack_section(CONNECTIVITY, pack_connectivity(vertices, faces))
    metadata = Metadata(params.name, params.unit, f"shapery-motion {version('shapery-motion')}")
    data, header = _assemble(
        Header(
            params.profile, vertices, len(faces), count, len(bodies), 0, memory, params.fps or 0.0, asked, met, double
        ),
        metadata,
        connectivity,
        bodies,
        sizes,
    )
    parts["connectivity"] = len(connectivity)
    parts["container"] = len(data) - sum(parts.values())
    on_progress("verify", 0.95)
    # the file itself, once more from its bytes: what was written is what was measured
    _compare(Motion(data), sequence, errors, check_cancelled, on_verified)
    spread = float((original.frame_spread**2).sum()) * vertices
    totals = [
        (sum(p[0] for p in steps), sum(p[1] for p in steps)) for steps in zip(*(g.points for g in made), strict=False)
    ]
    return Encoding(
        data=data,
        header=header,
        parts=parts,
        errors=errors,
        clusters=sum(int(group.labels.max()) + 1 for group in made),
        labels=made[0].labels,
        points=tuple((100.0 * math.sqrt(e / spread), size) for e, size in totals) if spread else (),
        warnings=tuple(warnings),
    )


def _within_bounds(
    profile: Profile, task: GroupTask, meter: ErrorMeter, double: bool
) -> tuple[EncodedGroup, Corrections]:
    """Encode a group so that the bounds hold for what a decoder gives, and add its errors to the meter."""
    frames, vertices = task.frames.shape[:2]
    dtype = np.float64 if double else np.float32
    for attempt in range(ATTEMPTS):
        finer = 1.0 - 0.02 * attempt
        group = profile.encode_group(replace(task, squared_error=task.squared_error * finer**2))
        sections = {tag: memoryview(payload) for tag, payload in group.sections}
        opened = profile.open_group(sections, frames, vertices, task.faces, group.memory)
        decoded = [opened.frame(index) for index in range(frames)]
        corrections = Corrections.nothing()
        if math.isfinite(task.largest):
            corrections = find_corrections(task.frames, decoded, task.largest * finer)
        total, largest = 0.0, 0.0
        for index, frame in enumerate(decoded):
            corrections.apply(index, frame)
            decoded[index] = frame.astype(dtype)
            squared = ((task.frames[index] - decoded[index]) ** 2).sum(axis=1)
            total += float(squared.sum())
            largest = max(largest, float(squared.max()))
        if total <= task.squared_error and largest <= task.largest**2:
            for index, frame in enumerate(decoded):
                meter.add(task.frames[index].astype(dtype), frame)
            return group, corrections
    raise InvalidInput(
        "invalid_params",
        f"The bound is too fine for coordinates in {'double' if double else 'single'} precision.",
        "Allow a larger error.",
    )


def _assemble(
    header: Header, metadata: Metadata, connectivity: bytes, bodies: list[list[bytes]], sizes: list[int]
) -> tuple[bytes, Header]:
    meta = pack_section(META, metadata.pack())
    offset = (
        len(MAGIC)
        + len(header.pack())
        + FRAME_BYTES
        + len(meta)
        + groups_bytes(len(bodies))
        + FRAME_BYTES
        + len(connectivity)
    )
    groups, first = [], 0
    for body, frames in zip(bodies, sizes, strict=True):
        length = sum(map(len, body))
        groups.append(Group(first, frames, offset, length))
        offset += length
        first += frames
    header = replace(header, file_bytes=offset + FRAME_BYTES)
    pieces = [MAGIC, pack_section(HEAD, header.pack()), meta, pack_section(GROUPS, pack_groups(groups)), connectivity]
    for body in bodies:
        pieces += body
    pieces.append(pack_section(END, b""))
    return b"".join(pieces), header


def _with_a_bound(params: MotionEncodeParams) -> MotionEncodeParams:
    """Return the parameters with the default bound where there is none."""
    if params.kg is None and params.rmse is None and params.max_error is None:
        return params.model_copy(update={"kg": DEFAULT_KG})
    return params


def shape_of(sequence: MeshSequence | SequenceFile) -> tuple[int, int]:
    """Return the numbers of frames and of vertices."""
    if isinstance(sequence, SequenceFile):
        return sequence.frame_count, sequence.vertex_count
    return len(sequence), sequence.vertex_count


def _is_double(sequence: MeshSequence | SequenceFile) -> bool:
    dtype = sequence.dtype if isinstance(sequence, SequenceFile) else sequence.vertices.dtype
    return bool(dtype == np.float64)


def _frames(sequence: MeshSequence | SequenceFile) -> Iterator[NDArray[np.float32] | NDArray[np.float64]]:
    return sequence.frames() if isinstance(sequence, SequenceFile) else iter(sequence.vertices)


def _batches(sequence: MeshSequence | SequenceFile, sizes: list[int]) -> Iterator[FloatArray]:
    frames = _frames(sequence)
    for size in sizes:
        batch = np.stack([np.asarray(next(frames), dtype=np.float64) for _ in range(size)])
        yield batch


def _measure(
    sequence: MeshSequence | SequenceFile, faces: IntArray, check_cancelled: Callable[[], None]
) -> tuple[SequenceErrors, float]:
    """Return the measures of the original alone, its spread, edges and diagonal, and its largest coordinate."""
    meter, farthest = ErrorMeter(faces, shape_of(sequence)[1], surface=False), 0.0
    for frame in _frames(sequence):
        check_cancelled()
        meter.add(frame, frame)
        farthest = max(farthest, float(np.abs(frame).max()))
    return meter.result(), farthest


def _allowed(
    original: SequenceErrors, farthest: float, params: MotionEncodeParams, count: int
) -> tuple[_Allowed, list[str]]:
    """Turn the bounds into sums and distances."""
    kg, rmse, largest = params.kg, params.rmse, params.max_error
    vertices = count / len(original.frame_spread)
    spread = float((original.frame_spread**2).sum()) * vertices
    warnings: list[str] = []
    squared, distance = math.inf, math.inf
    if kg is not None and spread > 0.0:
        squared = min(squared, (kg / 100.0) ** 2 * spread)
    if rmse is not None and original.mean_edge > 0.0:
        squared = min(squared, (rmse * original.mean_edge) ** 2 * count)
    if largest is not None and original.diagonal > 0.0:
        distance = largest * original.diagonal
    if squared == distance == math.inf:
        warnings.append("The frames have no extent that the bound could refer to: single precision is kept.")
        squared = (2.0**-22 * max(farthest, 1e-30)) ** 2 * count
    return _Allowed(squared, distance), warnings


def _group_sizes(count: int, vertices: int, params: MotionEncodeParams) -> list[int]:
    """Return the number of frames of each group, as even as possible."""
    most = params.group_frames or max(8, min(GROUP_FRAMES, GROUP_BYTES // (24 * vertices)))
    groups = -(-count // min(most, MAX_GROUP_FRAMES))
    ends = [count * k // groups for k in range(groups + 1)]
    return [stop - first for first, stop in itertools.pairwise(ends)]


def _compare(
    motion: Motion,
    sequence: MeshSequence | SequenceFile,
    errors: SequenceErrors,
    check_cancelled: Callable[[], None],
    on_verified: Callable[[SequenceErrors, FrameArray, FrameArray], None],
) -> None:
    """Decode the file and hold its errors against those that were measured group by group."""
    meter = ErrorMeter(motion.faces, motion.header.vertices, surface=False)
    for original, decoded in zip(_frames(sequence), motion.frames(), strict=True):
        check_cancelled()
        meter.add(original, decoded)
        on_verified(errors, original, decoded)
    found = meter.result()
    if not np.array_equal(found.frame_rmse, errors.frame_rmse):
        raise RuntimeError("the file does not decode to what its groups did")

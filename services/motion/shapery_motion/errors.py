"""How far a decoded mesh sequence is from its original: the error measures of chapter 5 and of the literature.

All of them are summed frame by frame, so that neither sequence has to fit into memory. `ErrorMeter` takes pairs of
frames as they come; `sequence_errors` runs one over two iterables.

References
----------
Z. Karni, C. Gotsman, Compression of soft-body animation sequences, Computers & Graphics 28(1), 2004,
doi:10.1016/j.cag.2003.10.002, for the KG error.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import IntArray
from shapery_geometry.topology import Topology
from shapery_motion import _error_kernels as kernels

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SequenceErrors:
    """Errors of a whole sequence, and of each of its F frames."""

    kg_percent: float
    """100 · ‖A − Ã‖_F / ‖A − E(A)‖_F, with E(A) the centroid of each frame at each of its vertices."""
    rmse: float
    """Root of the mean squared vertex error over all frames, in model units."""
    rmse_edges: float
    """The same in mean edge lengths (the mean over all edges of all frames)."""
    prediction: float
    """Eq. 5.12, averaged over the frames: the root mean squared error of a frame in mean edge lengths."""
    largest: float
    """The largest distance of any vertex from its original, in model units."""
    largest_fraction: float
    """The same as a fraction of the bounding box's diagonal in the first frame."""
    normal_degrees: float
    """Mean angle between the faces' normals before and after; not a number unless surfaces were measured."""
    dihedral_degrees: float
    """Mean change of the angle between two faces at an edge; not a number unless surfaces were measured."""
    mean_edge: float
    """Mean length of all edges of all frames of the original, in model units."""
    diagonal: float
    """Diagonal of the original's bounding box in the first frame, in model units."""
    frame_rmse: FloatArray
    """(F,) root mean squared vertex error of each frame, in model units."""
    frame_largest: FloatArray
    """(F,) largest vertex error of each frame, in model units."""
    frame_spread: FloatArray
    """(F,) root mean squared distance of each frame's vertices from their centroid, in model units."""

    def summary(self) -> dict[str, float]:
        """Return the figures of the whole sequence by name, without those of surfaces where they were not measured."""
        names = ("kg_percent", "rmse", "rmse_edges", "prediction", "largest", "largest_fraction",
                 "normal_degrees", "dihedral_degrees", "mean_edge", "diagonal")  # fmt: skip
        measured = names if not math.isnan(self.normal_degrees) else names[:6] + names[8:]
        return {name: float(getattr(self, name)) for name in measured}


class ErrorMeter:
    """Sum the errors of a sequence whose frames come in pairs, the original and what was decoded.

    Parameters
    ----------
    faces : (m, 3) int32
        The connectivity of all frames.
    vertex_count
        Number of vertices n of each frame.
    surface
        Whether normals and dihedral angles are compared too, which takes ten times as long.
    topology
        Of the faces, where it is known already.
    """

    def __init__(
        self, faces: IntArray, vertex_count: int, *, surface: bool = True, topology: Topology | None = None
    ) -> None:
        self._faces = np.ascontiguousarray(faces, dtype=np.int32)
        self._count = vertex_count
        self._surface = surface
        topology = topology or Topology(vertex_count, self._faces)
        self._edges = np.ascontiguousarray(topology.edges[topology.edges[:, 0] != topology.edges[:, 1]])
        if surface:
            self._folds, self._pairs = interior_edges(topology)
        self._totals: list[float] = []
        self._largest: list[float] = []
        self._spreads: list[float] = []
        self._edge_sum = 0.0
        self._diagonal = 0.0
        self._normals = (0.0, 0)
        self._dihedrals = (0.0, 0)

    def add(self, original: NDArray[Any], decoded: NDArray[Any]) -> None:
        """Take the next frame: two (n, 3) arrays, float32 or float64."""
        for frame in (original, decoded):
            if frame.shape != (self._count, 3):
                raise InvalidInput(
                    "inconsistent_sequence",
                    f"Frame {len(self._totals)} has the shape {frame.shape}, not ({self._count}, 3).",
                )
        original, decoded = np.ascontiguousarray(original), np.ascontiguousarray(decoded)
        total, largest, spread = kernels.position_sums(original, decoded)
        if not self._totals and self._count:
            extent = original.max(axis=0).astype(np.float64) - original.min(axis=0)
            self._diagonal = float(np.linalg.norm(extent))
        self._totals.append(total)
        self._largest.append(largest)
        self._spreads.append(spread)
        self._edge_sum += kernels.edge_length_sum(original, self._edges)
        if self._surface:
            before = kernels.unit_normals(original, self._faces)
            after = kernels.unit_normals(decoded, self._faces)
            self._normals = _plus(self._normals, kernels.normal_angle_sum(before, after))
            folds = kernels.dihedral_difference_sum(original, decoded, before, after, self._folds, self._pairs)
            self._dihedrals = _plus(self._dihedrals, folds)

    def result(self) -> SequenceErrors:
        """Return the errors of all frames so far.

        Raises
        ------
        InvalidInput
            ``empty_content`` before the first frame.
        """
        frames = len(self._totals)
        if not frames:
            raise InvalidInput("empty_content", "There are no frames to compare.")
        totals, spreads = np.array(self._totals), np.array(self._spreads)
        vertices = max(self._count, 1)
        mean_edge = self._edge_sum / (frames * len(self._edges)) if len(self._edges) else 0.0
        rmse = math.sqrt(totals.sum() / (frames * vertices))
        frame_rmse = np.sqrt(totals / vertices)
        largest = float(np.sqrt(np.max(self._largest)))
        return SequenceErrors(
            kg_percent=100.0 * _ratio(math.sqrt(totals.sum()), math.sqrt(spreads.sum())),
            rmse=rmse,
            rmse_edges=_ratio(rmse, mean_edge),
            prediction=_ratio(float(frame_rmse.mean()), mean_edge),
            largest=largest,
            largest_fraction=_ratio(largest, self._diagonal),
            normal_degrees=_mean_degrees(self._normals) if self._surface else math.nan,
            dihedral_degrees=_mean_degrees(self._dihedrals) if self._surface else math.nan,
            mean_edge=mean_edge,
            diagonal=self._diagonal,
            frame_rmse=frame_rmse,
            frame_largest=np.sqrt(np.array(self._largest)),
            frame_spread=np.sqrt(spreads / vertices),
        )


def sequence_errors(
    originals: Iterable[NDArray[Any]], decoded: Iterable[NDArray[Any]], faces: IntArray, *, surface: bool = True
) -> SequenceErrors:
    """Compare two sequences of one connectivity, frame by frame in flat memory.

    Parameters
    ----------
    originals, decoded
        The frames' vertices, each (n, 3) float32 or float64, in the same order.
    faces : (m, 3) int32
        Their connectivity.
    surface
        Whether normals and dihedral angles are compared too.

    Raises
    ------
    InvalidInput
        ``inconsistent_sequence`` where the numbers of frames or vertices differ, ``empty_content`` for no frames.
    """
    meter: ErrorMeter | None = None
    frames, others = iter(originals), iter(decoded)
    number = 0
    for frame in frames:
        other = next(others, None)
        if other is None:
            raise InvalidInput("inconsistent_sequence", f"The decoded sequence ends after {number} frames.")
        if meter is None:
            meter = ErrorMeter(faces, len(frame), surface=surface)
        meter.add(frame, other)
        number += 1
    if next(others, None) is not None:
        raise InvalidInput(
            "inconsistent_sequence", f"The decoded sequence has more than the original's {number} frames."
        )
    if meter is None:
        raise InvalidInput("empty_content", "There are no frames to compare.")
    return meter.result()


def dissertation_bits(clusters: int, faces: int, vertices: int, *, matrix_bits: int = 9 * 64) -> float:
    """Eq. 5.11: bits per vertex of a predicted frame, (B_M N_C + log₂ N_C · N_F) / N_V.

    Parameters
    ----------
    clusters, faces, vertices
        N_C, N_F and N_V.
    matrix_bits
        B_M: nine numbers of eight bytes in the text.

    Notes
    -----
    The logarithm is to base 2. With the text's 256 clusters, 20,000 faces and 10,002 vertices this gives its 30.74; the
    text's 20.29 for the face (64 clusters, 3,000 faces, 1,500 vertices) does not follow: this gives 36.58. The formula
    leaves out the anchors, the key frames, the connectivity, and what entropy coding would save on the labels.
    """
    if clusters < 1 or vertices < 1 or faces < 0:
        raise ValueError(f"no bits for {clusters} clusters, {faces} faces, {vertices} vertices")
    return (matrix_bits * clusters + math.log2(clusters) * faces) / vertices


def interior_edges(topology: Topology) -> tuple[IntArray, IntArray]:
    """Return the edges (e, 2) with exactly two faces, and those faces (e, 2)."""
    inner = (topology.edge_face_counts == 2) & (topology.edges[:, 0] != topology.edges[:, 1])
    flat = topology.face_edges.ravel()
    order = np.argsort(flat, kind="stable")
    order = order[inner[flat[order]]]
    pairs = (order // 3).astype(np.int32).reshape(-1, 2)
    return np.ascontiguousarray(topology.edges[inner]), np.ascontiguousarray(pairs)


def _plus(sums: tuple[float, int], more: tuple[float, int]) -> tuple[float, int]:
    return sums[0] + more[0], sums[1] + more[1]


def _mean_degrees(sums: tuple[float, int]) -> float:
    return math.degrees(sums[0] / sums[1]) if sums[1] else 0.0


def _ratio(part: float, whole: float) -> float:
    """`part` over `whole`; no error over nothing is no error, any other is infinite."""
    if whole > 0:
        return part / whole
    return 0.0 if part == 0 else math.inf

"""From a mesh to its attributed relational graph."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators.surface_distance import closest_points
from shapery_geometry.threads import one_blas_thread
from shapery_retrieval.arg import Arg
from shapery_retrieval.decompose import Decomposition, decompose
from shapery_retrieval.nodes import build_levels
from shapery_retrieval.normalise import NormalisedMesh, normalise
from shapery_retrieval.patches import SHARES, LocalSurface, Patches
from shapery_retrieval.sides import sample_arrays
from shapery_retrieval.signals import Signals, compute_signals
from shapery_retrieval.whole import whole_descriptors

OnStage = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Description:
    """All that was found out about one mesh.

    Attributes
    ----------
    arg
        What is stored and compared.
    normalised, signals, decomposition
        The surface as it was analysed, what is known at its vertices, and its parts.
    seconds
        Wall time of each stage by name.
    """

    arg: Arg
    normalised: NormalisedMesh
    signals: Signals
    decomposition: Decomposition
    seconds: dict[str, float]

    def cells_on(self, mesh: TriangleMesh) -> NDArray[np.int64]:
        """(n,) sample in whose cell each vertex of another version of the same surface lies.

        Parameters
        ----------
        mesh
            In the frame and unit of the mesh that was described.

        Notes
        -----
        Each vertex takes the cell of the nearest point of the analysed surface.
        """
        own = self.normalised
        placed = (mesh.vertices - own.centre) * own.scale
        nearest = closest_points(own.mesh, placed)
        corner = own.mesh.faces[nearest.faces, np.argmax(nearest.barycentric, axis=1)]
        return np.asarray(self.decomposition.samples.cells[corner])

    @one_blas_thread()
    def hypotheses(self) -> list[Patches]:
        """Return the surface's patches as those of several shares of a whole, for a search in which it is a part."""
        local = LocalSurface(self.normalised, self.signals, self.decomposition.samples)
        return [local.patches(share) for share in SHARES]

    def region_shares(self, mesh: TriangleMesh, faces: Sequence[int]) -> list[NDArray[np.float64]]:
        """For each level the (k,) share of each part's area that lies in a region of the mesh as it was read.

        Raises
        ------
        InvalidInput
            ``invalid_params`` for a face that does not exist.
        """
        chosen = np.asarray(faces, dtype=np.int64)
        if chosen.max() >= len(mesh.faces):
            raise InvalidInput(
                "invalid_params", f"The region names face {chosen.max()}, but the mesh has {len(mesh.faces)} faces."
            )
        inside = np.zeros(len(mesh.faces), dtype=bool)
        inside[chosen] = True
        own = self.normalised
        nearest = closest_points(mesh, own.mesh.vertices / own.scale + own.centre)
        covered = inside[nearest.faces] * self.signals.areas
        shares = []
        for level in range(len(self.decomposition.levels)):
            labels = self.decomposition.vertex_labels(level)
            whole = np.bincount(labels, weights=self.signals.areas)
            shares.append(np.bincount(labels, weights=covered, minlength=len(whole)) / whole)
        return shares


@one_blas_thread()
def describe(mesh: TriangleMesh, *, on_stage: OnStage | None = None) -> Description:
    """Analyse a mesh.

    Parameters
    ----------
    mesh
        Any mesh, in any unit and pose.
    on_stage
        Called with the name of each stage as it begins.

    Raises
    ------
    InvalidInput
        ``empty_content`` or ``invalid_mesh`` for what has no surface that could be described.
    """
    seconds: dict[str, float] = {}
    began = time.perf_counter()

    def stage(name: str) -> None:
        if on_stage is not None:
            on_stage(name)
        nonlocal began
        began = time.perf_counter()

    def done(name: str) -> None:
        seconds[name] = time.perf_counter() - began

    stage("normalise")
    normalised = normalise(mesh)
    done("normalise")
    stage("describe")
    signals = compute_signals(normalised)
    done("describe")
    stage("decompose")
    decomposition = decompose(signals)
    surface = normalised.mesh
    edges = np.concatenate((surface.edges.astype(np.int64), normalised.links.ends))
    levels = build_levels(signals, decomposition, edges)
    done("decompose")
    stage("views")
    whole = whole_descriptors(surface, signals)
    done("views")
    stage("patches")
    masses, features = LocalSurface(normalised, signals, decomposition.samples).described(1.0)
    parts = decomposition.levels[-1].astype(np.uint8)
    whole |= sample_arrays(surface, signals, decomposition.samples)
    whole |= {"patch_masses": masses, "patch_features": features, "patch_parts": parts}
    done("patches")
    # written and read once, so that what is compared now is exactly what will be compared later
    arg = Arg.from_bytes(Arg(levels, MappingProxyType(whole)).to_bytes())
    return Description(arg, normalised, signals, decomposition, seconds)


def build_arg(mesh: TriangleMesh) -> Arg:
    """Return the graph of a mesh; see `describe` for what it refuses.

    The same surface gives the same graph, bit for bit, in whatever order its vertices and faces are.
    """
    return describe(mesh).arg

"""Geodesic distances on a triangulation, by fast marching.

References
----------
R. Kimmel, J. A. Sethian, Computing geodesic paths on manifolds, PNAS 95(15), 1998, doi:10.1073/pnas.95.15.8431.
M. Novotni, R. Klein, Computing geodesic distances on triangular meshes, WSCG 2002 (for the update by an unfolded
source, which is exact where the geodesics from the source do not bend).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapery_geometry.operators import _geodesic_kernels as kernels
from shapery_geometry.operators.intrinsic import IntrinsicTriangulation


@dataclass(frozen=True, eq=False)
class Links:
    """Paths between vertices that lie on no face, such as those that join the components of a shape.

    Attributes
    ----------
    ends : (k, 2) int64
        The vertices that each joins.
    lengths : (k,) float64
        In the unit of the surface.
    """

    ends: NDArray[np.int64]
    lengths: NDArray[np.float64]


NO_LINKS = Links(np.zeros((0, 2), dtype=np.int64), np.zeros(0))


@dataclass(frozen=True, eq=False)
class GeodesicSurface:
    """A surface ready for questions of distance.

    Parameters
    ----------
    triangulation
        Best the intrinsic Delaunay one, whose few obtuse angles keep the error low.
    links
        Further paths.
    """

    triangulation: IntrinsicTriangulation
    links: Links = NO_LINKS

    @cached_property
    def _arrays(self) -> tuple[NDArray[np.generic], ...]:
        n, faces = self.triangulation.vertex_count, self.triangulation.faces
        flat = faces.ravel()
        corners = np.argsort(flat, kind="stable")
        starts = np.concatenate(([0], np.cumsum(np.bincount(flat, minlength=n))))
        ends = np.concatenate((self.links.ends, self.links.ends[:, ::-1]))
        order = np.argsort(ends[:, 0], kind="stable")
        link_starts = np.concatenate(([0], np.cumsum(np.bincount(ends[:, 0], minlength=n))))
        lengths = np.tile(self.links.lengths, 2)[order]
        fans, sides = kernels.fans(faces, self.triangulation.lengths, corners)
        return fans, sides, starts, link_starts, ends[order, 1], lengths

    def distances(self, sources: ArrayLike) -> NDArray[np.float64]:
        """Return the (k, n) distances from k vertices to all; infinite where there is no path."""
        chosen = np.asarray(sources, dtype=np.int64).reshape(-1)
        return np.asarray(kernels.march_all(chosen, self.triangulation.vertex_count, *self._arrays))

    def farthest_points(self, count: int, first: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return vertices spread evenly, each the farthest from those before it, and their (count, n) distances.

        Ties go to the smaller index.
        """
        chosen, distances = kernels.farthest_points(first, count, self.triangulation.vertex_count, *self._arrays)
        return np.asarray(chosen), np.asarray(distances)

"""Differential operators on meshes, and distances between surfaces."""

from __future__ import annotations

from shapery_geometry.operators.curvature import (
    angle_defects,
    gaussian_curvature,
    mean_curvature,
    principal_curvatures,
)
from shapery_geometry.operators.laplacian import cotangent_laplacian, mass_matrix, vertex_areas
from shapery_geometry.operators.sampling import SurfaceSamples, sample_surface
from shapery_geometry.operators.surface_distance import (
    ClosestPoints,
    SurfaceDistances,
    closest_points,
    surface_distances,
)

__all__ = [
    "ClosestPoints",
    "SurfaceDistances",
    "SurfaceSamples",
    "angle_defects",
    "closest_points",
    "cotangent_laplacian",
    "gaussian_curvature",
    "mass_matrix",
    "mean_curvature",
    "principal_curvatures",
    "sample_surface",
    "surface_distances",
    "vertex_areas",
]

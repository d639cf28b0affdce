"""Parameters of the normal flow and what it returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from shapery_geometry.mesh import TriangleMesh


@dataclass(frozen=True, slots=True)
class NormalFlowParams:
    """How the surface flows.

    Parameters
    ----------
    edge_lengths
        Target edge length in mm of each stage, coarse to fine. A coarse stage moves in fewer, larger steps.
    model
        ``threshold``: out where the field exceeds a threshold, in where it does not. ``gradient``: Eq. 3.1 as it is
        written, stopped by edges of the field.
    step
        Way per iteration at full speed, in edge lengths. Above 0.3 the surface runs ahead of its own smoothing.
    curvature_weight
        Share of the way to the plane of its neighbours that a vertex moves along its normal in each iteration.
    tangential_weight
        Share of the way to the mean of its neighbours that it moves across its normal, which spreads vertices evenly.
    threshold_share
        The threshold follows this share of the median inside the surface; none: it stays as given.
    threshold_ground
        What surrounds the object; the share is one of the way from there to the median.
    threshold_range
        Bounds that the running threshold is kept in.
    threshold_interval
        Iterations between two updates of the threshold.
    balloon
        v of Eq. 3.1 (``gradient`` only): positive grows, negative shrinks.
    gradient_sigma
        Standard deviation in mm of the Gaussian of Eq. 3.3.
    gradient_percentile
        The gradient is measured in units of this percentile of itself around the seed.
    front_gap, rear_gap
        Edge lengths within which another part of the surface stops a vertex, ahead of it and behind it.
    opposed, rear_opposed
        Product of the normals below which a part of the surface is another part, ahead and behind. Behind a vertex at
        the rim of something thin lie the sides of its own part, across its way; they must not hold it.
    patience
        Iterations in a row that a vertex may be kept from moving before it is frozen.
    least_scale
        Share of the edge length to which frozen vertices that guard a small feature are refined; 1: not at all.
    damping
        What the step of a vertex is multiplied with when it changes its direction; 1: nothing. It grows back by a tenth
        with every step in one direction.
    aging_limit
        Changes of direction in a row after which a vertex is stopped (S5); none: never.
    interpolation_share
        Share of the vertices without a border in the data under them above which they are interpolated between the
        others in the end (S8, see `shapery_segmentation.flow.interpolation`); none: never. For borders of which a part
        is lost; `interpolation.WORTHWHILE` is a good one.
    window, rest, stir
        A vertex sleeps that has moved less than `rest` edge lengths along its normal, net, in `window` iterations; one
        that has moved more than `stir` wakes its neighbours.
    remesh_interval, release_interval
        Iterations between two passes of split, collapse and flip, and between two that smooth irregular vertices.
    awake_share
        A stage is over when at most this share of the vertices is awake.
    max_iterations
        Iterations of one stage at the most.
    topology
        ``preserve``: the surface keeps the genus and the number of parts of its seed. ``adaptive``: parts that meet
        inside the object merge, necks outside of it split (see `shapery_segmentation.flow.topology`).
    """

    edge_lengths: tuple[float, ...] = (1.5, 1.0)
    model: Literal["threshold", "gradient"] = "threshold"
    step: float = 0.3
    curvature_weight: float = 0.12
    tangential_weight: float = 0.4
    threshold_share: float | None = 0.45
    threshold_ground: float = 0.0
    threshold_range: tuple[float, float] = (1.2, 2.25)
    threshold_interval: int = 10
    balloon: float = 0.3
    gradient_sigma: float = 1.0
    gradient_percentile: float = 98.0
    front_gap: float = 0.8
    rear_gap: float = 0.5
    opposed: float = 0.4
    rear_opposed: float = -0.3
    patience: int = 4
    least_scale: float = 0.5
    damping: float = 0.5
    aging_limit: int | None = 6
    interpolation_share: float | None = None
    window: int = 1
    rest: float = 0.01
    stir: float = 0.1
    remesh_interval: int = 4
    release_interval: int = 20
    awake_share: float = 0.01
    max_iterations: int = 400
    topology: Literal["preserve", "adaptive"] = "preserve"

    def __post_init__(self) -> None:
        if not self.edge_lengths or not all(np.isfinite(h) and h > 0 for h in self.edge_lengths):
            raise ValueError(f"edge_lengths must be positive and at least one, not {self.edge_lengths}")
        if self.model not in ("threshold", "gradient"):
            raise ValueError(f"model must be 'threshold' or 'gradient', not {self.model!r}")
        if self.topology not in ("preserve", "adaptive"):
            raise ValueError(f"topology must be 'preserve' or 'adaptive', not {self.topology!r}")
        for name, low, high in (
            ("step", 0.0, 0.5),
            ("curvature_weight", 0.0, 1.0),
            ("tangential_weight", 0.0, 1.0),
            ("front_gap", 0.0, 3.0),
            ("rear_gap", 0.0, 3.0),
            ("opposed", -1.0, 1.0),
            ("rear_opposed", -1.0, 1.0),
            ("least_scale", 0.1, 1.0),
            ("damping", 0.1, 1.0),
            ("awake_share", 0.0, 1.0),
            ("gradient_percentile", 0.0, 100.0),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise ValueError(f"{name} must lie in [{low:g}, {high:g}], not {value}")
        counts = (
            "threshold_interval", "patience", "window", "remesh_interval",
            "release_interval", "max_iterations",
        )  # fmt: skip
        for name in counts:
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be at least 1, not {getattr(self, name)}")
        if self.aging_limit is not None and self.aging_limit < 1:
            raise ValueError(f"aging_limit must be at least 1, not {self.aging_limit}")
        if self.interpolation_share is not None and not 0.0 <= self.interpolation_share <= 1.0:
            raise ValueError(f"interpolation_share must lie in [0, 1], not {self.interpolation_share}")
        if not self.threshold_range[0] <= self.threshold_range[1]:
            raise ValueError(f"threshold_range must be rising, not {self.threshold_range}")
        if not (np.isfinite(self.gradient_sigma) and self.gradient_sigma >= 0):
            raise ValueError(f"gradient_sigma must not be negative, not {self.gradient_sigma}")


@dataclass(frozen=True, slots=True)
class FlowState:
    """Where the flow is, as `on_iteration` is told."""

    stage: int
    iteration: int
    """Over all stages, from 1."""
    vertices: int
    awake: int
    oscillating: int
    """Of those awake, the ones that change their direction again and again."""
    threshold: float
    surface: Callable[[], TriangleMesh]
    """Makes a copy of the surface as it is."""


@dataclass(frozen=True, slots=True)
class StageRecord:
    """What one stage did."""

    edge_length: float
    iterations: int
    converged: bool
    vertices: int
    threshold: float


@dataclass(frozen=True, slots=True)
class FlowResult:
    """The surface where it came to rest.

    Parameters
    ----------
    mesh
        Closed, manifold, oriented, without self-intersections, RAS mm, and of the seed's genus if the topology is to be
        preserved; its coordinates are float32 values, so that single precision stores it exactly.
    threshold
        At the end.
    iterations
        Over all stages.
    converged
        Whether the last stage ended because the surface rested, not because of `max_iterations`.
    vanished
        Whether the surface shrank to nothing: there is no object where it started. `mesh` is then what was left.
    asleep, frozen, aged, awake
        Vertices by how they ended: at rest; kept from moving by another part of the surface; stopped where they
        oscillated; still moving.
    oscillating
        The most vertices that were oscillating at once, and in `oscillations` the sum over all iterations.
    interpolations
        How often vertices were interpolated (S8).
    reconnections
        How often the topology was changed.
    untouched
        Whether in the end all pairs of faces were found apart, but for what they share.
    stages
        One record per stage that ran.
    """

    mesh: TriangleMesh
    threshold: float
    iterations: int
    converged: bool
    vanished: bool
    asleep: int
    frozen: int
    aged: int
    awake: int
    oscillating: int
    oscillations: int
    interpolations: int
    reconnections: int
    untouched: bool
    stages: tuple[StageRecord, ...]

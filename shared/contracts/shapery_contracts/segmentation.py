"""Parameters and result of the ``segmentation`` kind (chapter 3 of the method)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Point = Annotated[list[float], Field(min_length=3, max_length=3)]
Box = Annotated[list[float], Field(min_length=6, max_length=6)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class SegmentationParams(BaseModel):
    """How to segment; every default is chosen so that two volumes alone suffice."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    mode: Literal["auto", "tumor", "object"] = "auto"
    """``tumor``: enhancing tumors of a head. ``object``: whatever a seed or a box points at, in any volume. ``auto``:
    the latter where a seed or a box is given and the volume is no head, else the former."""
    seeds: Annotated[list[Point], Field(max_length=64)] = []
    """Points in RAS mm to start from; none: seeds are found automatically (tumors only)."""
    box: Box | None = None
    """Two opposite corners x0, y0, z0, x1, y1, z1 in RAS mm that the object lies between (``object`` only)."""
    register_volumes: bool = True
    """Whether volumes that do not lie on the one after contrast are moved onto it."""
    polarity: Literal["auto", "bright", "dark"] = "auto"
    """Of what the input ``vessels`` shows: dark in SWI, bright in MRA, time-of-flight, CTA; ``auto`` asks the data."""
    vessel_seeds: Annotated[list[Point], Field(max_length=64)] = []
    """Points in RAS mm in vessels; none: they are found around the objects."""
    microhemorrhages: Literal["auto", "bright", "dark", "off"] = "auto"
    """How bleedings show in the input ``vessels``; ``auto``: dark where vessels are dark, else they are not looked
    for."""
    max_objects: Annotated[int, Field(ge=1, le=64)] = 8
    """How many objects may be reported at the most."""
    topology: Literal["preserve", "adaptive"] = "adaptive"
    """``adaptive``: parts of the surface that meet inside the object merge, thin ones outside of it split.
    ``preserve``: it keeps the genus of its seed, and where it meets itself, as around a necrosis, there is a seam."""
    edge_length: Positive | None = None
    """Target edge length of the final mesh in mm; by default chosen from the voxel spacing."""
    smoothing: Annotated[float, Field(ge=0, le=1)] = 0.12
    """Weight of the mean-curvature term in each step."""
    random_seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0
    """Seed of the only random generator."""


class SegmentedObject(BaseModel):
    """One recovered object."""

    label: int
    """The object's number, from 1, in the order of falling confidence; also in its surface's file name."""
    seed: Point
    """Where it was started, RAS mm."""
    seeded_by: Literal["automatic", "user"]
    confidence: float
    """In [0, 1]: how sure it is that this is an enhancing tumor."""
    volume_mm3: float
    """Volume inside the surface of the enhancing part (label 1)."""
    core_volume_mm3: float
    """Volume of the core: the enhancing part and what it encloses (labels 1 and 2)."""
    area_mm2: float
    centroid: Point
    vertices: int
    faces: int
    closed: bool
    genus: int
    self_intersections: int
    """Pairs of faces that intersect; 0 for every surface we give out."""
    threshold: float
    """The running threshold at the end, in units of the calibrated difference."""
    iterations: int
    converged: bool
    surface: str
    """Name of the artifact with this object's surface."""
    polarity: Literal["bright", "dark", "between"] = "bright"
    """Whether it is brighter than what surrounds it, darker, or between the two."""
    seed_volume_mm3: float = 0.0
    """Volume of the surface that it grew from."""
    notes: list[str] = []
    """What is particular about it; always where it ended smaller than its seed."""


class SegmentedVessel(BaseModel):
    """One connected vessel, with all its branches."""

    label: int
    """Its number, from 1, by falling volume."""
    length_mm: float
    """Sum over the branches."""
    mean_radius_mm: float
    least_radius_mm: float
    largest_radius_mm: float
    volume_mm3: float
    area_mm2: float
    branches: int
    forks: int
    vertices: int
    faces: int
    closed: bool
    genus: int
    self_intersections: int
    surface: str
    """Name of the artifact with its surface."""


class Microhemorrhage(BaseModel):
    """One cluster of bleeding."""

    volume_mm3: float
    centroid: Point
    voxels: int


class Alignment(BaseModel):
    """Where an input lay relative to the volume after contrast."""

    input: str
    moved: bool
    shift_mm: float
    """How far its middle was moved."""
    degrees: float
    mutual_information_before: float
    mutual_information: float


class StageTime(BaseModel):
    """How long one stage took."""

    name: str
    seconds: float


class SegmentationResult(BaseModel):
    """What ``report.json`` holds and the API returns."""

    objects: list[SegmentedObject]
    mode: Literal["tumor", "object"] = "tumor"
    """How the objects were found."""
    vessels: list[SegmentedVessel] = []
    vessel_polarity: Literal["bright", "dark"] | None = None
    microhemorrhages: list[Microhemorrhage] = []
    """By falling volume."""
    alignments: list[Alignment] = []
    voxel_counts: dict[str, int]
    """Voxels per label of ``labels.nii.gz``: 1 object, 2 enclosed, 3 vessel, 4 microhemorrhage."""
    voxel_volume_mm3: float
    stages: list[StageTime]
    versions: dict[str, str]
    warnings: list[str] = []

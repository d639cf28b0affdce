"""Parameters and results of the ``motion-encode`` and ``motion-decode`` kinds (chapter 5 of the method)."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from shapery_contracts.segmentation import StageTime

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Profile = Literal["trajectory", "gradient"]
Preset = Literal["default", "fast"]
MotionFormat = Literal["npz", "obj", "ply", "glb"]

DEFAULT_KG = 0.1
"""Percent: the bound where none is given. Normals are then off by about two degrees."""


class MotionEncodeParams(BaseModel):
    """How to compress a sequence. Every bound that is given is met by the decoded file; without any, ``kg`` is 0.1."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    kg: Positive | None = None
    """Bound on the KG error in percent: 100 · ‖A − Ã‖ / ‖A − E(A)‖ with E(A) the centroid of each frame."""
    rmse: Positive | None = None
    """Bound on the root mean squared vertex error, in mean edge lengths."""
    max_error: Positive | None = None
    """Bound on the largest vertex error, as a fraction of the diagonal of the first frame's bounding box."""
    preset: Preset = "default"
    """``fast`` encodes several times faster into a slightly larger file."""
    profile: Profile = "trajectory"
    """``trajectory`` is the codec we stand behind; ``gradient`` is the dissertation's."""
    clusters: Annotated[int, Field(ge=1, le=4096)] | None = None
    """Number of clusters; by default chosen by rate and distortion."""
    key_frames: Annotated[list[Annotated[int, Field(ge=0)]], Field(max_length=100_000)] = []
    """Numbers of the key frames (``gradient`` only); none: chosen by their error."""
    group_frames: Annotated[int, Field(ge=1, le=4096)] | None = None
    """Most frames of a group, which is decoded as a whole; by default chosen from the size of the frames."""
    fps: Annotated[float, Field(gt=0, le=10_000)] | None = None
    """Frames per second, for players."""
    unit: Annotated[str, Field(max_length=32)] = ""
    """Unit of the coordinates, for viewers: ``m``, ``mm``."""
    name: Annotated[str, Field(max_length=256)] = ""
    """What the motion is called."""

    @model_validator(mode="after")
    def _profile_has_it(self) -> Self:
        if self.key_frames and self.profile != "gradient":
            raise ValueError("key_frames are of the gradient profile only")
        return self


class MotionErrors(BaseModel):
    """How far the decoded file is from its original."""

    kg_percent: float
    rmse_edges: float
    """Root mean squared vertex error in mean edge lengths."""
    prediction: float
    """Eq. 5.12 of the method, averaged over the frames."""
    largest_fraction: float
    """Largest vertex error, as a fraction of the diagonal of the first frame's bounding box."""


class MotionEncodeResult(BaseModel):
    """What the API returns of an encoding."""

    file: str
    """Name of the artifact that holds the motion."""
    profile: Profile
    preset: Preset
    frames: int
    vertices: int
    faces: int
    groups: int
    clusters: int
    """Over all groups."""
    bytes: int
    parts: dict[str, int]
    """Bytes by part of the file; they sum to ``bytes``."""
    bits_per_vertex_frame: float
    """Of the whole file."""
    motion_bits_per_vertex_frame: float
    """Of the file without its connectivity."""
    connectivity_bits_per_vertex: float
    bounds: dict[str, float]
    """The bounds that were asked for, by the names of the parameters."""
    errors: MotionErrors
    """Measured on the decoded file."""
    stages: list[StageTime]
    versions: dict[str, str]
    warnings: list[str] = []


class RatePoint(BaseModel):
    """One point of the curve of rate over distortion: this encoding, or a coarser one."""

    kg_percent: float
    motion_bits_per_vertex_frame: float


class MotionReport(MotionEncodeResult):
    """What ``report.json`` holds."""

    frame_rmse: list[float]
    """Root mean squared vertex error of each frame, in the unit of the coordinates."""
    frame_largest: list[float]
    """Largest vertex error of each frame, in the unit of the coordinates."""
    vertex_clusters: list[int]
    """The cluster of each vertex in the first group."""
    rate_distortion: list[RatePoint]


class MotionDecodeParams(BaseModel):
    """Which frames to decode, and into what."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    first: Annotated[int, Field(ge=0)] = 0
    """The first frame."""
    stop: Annotated[int, Field(ge=1)] | None = None
    """The frame after the last; by default all are decoded."""
    format: MotionFormat = "npz"
    """``npz``, a zip of ``obj`` or ``ply`` files, or an animated ``glb`` with a morph target for each frame."""

    @model_validator(mode="after")
    def _some_frames(self) -> Self:
        if self.stop is not None and self.stop <= self.first:
            raise ValueError("stop must be greater than first")
        return self


class MotionDecodeResult(BaseModel):
    """What the API returns of a decoding."""

    file: str
    """Name of the artifact that holds the frames."""
    format: MotionFormat
    first: int
    frames: int
    vertices: int
    faces: int
    bytes: int
    stages: list[StageTime]
    versions: dict[str, str]


class MotionInfo(BaseModel):
    """What a motion file tells of itself."""

    version: str
    """Of the format."""
    profile: Profile
    frames: int
    vertices: int
    faces: int
    groups: list[int]
    """Frames of each group."""
    fps: float | None
    unit: str
    name: str
    software: str
    """What wrote it."""
    bytes: int
    sections: dict[str, int]
    """Bytes by kind of section; with the eight of the signature they sum to ``bytes``."""
    decoder_memory: int
    """Bytes that an opened group takes at the most."""
    bits_per_vertex_frame: float
    motion_bits_per_vertex_frame: float
    """Without the connectivity."""
    connectivity_bits_per_vertex: float
    bounds: dict[str, float]
    """What was asked for: ``kg`` in percent, ``rmse`` in edge lengths, ``max_error`` in diagonals."""
    errors: dict[str, float]
    """What was met, in the same units."""

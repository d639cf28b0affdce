"""The job kinds: what each takes, how it is set, what it gives, and where it runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from pydantic import BaseModel

from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats import AssetKind
from shapery_contracts.motion import MotionDecodeParams, MotionDecodeResult, MotionEncodeParams, MotionEncodeResult
from shapery_contracts.retrieval import ShapeIndexParams, ShapeIndexResult, ShapeSearchParams, ShapeSearchResult
from shapery_contracts.segmentation import SegmentationParams, SegmentationResult


@dataclass(frozen=True, slots=True)
class InputSpec:
    """One named input of a job kind."""

    kinds: frozenset[AssetKind]
    description: str
    required: bool = True
    many: bool = False
    """Whether several assets may be given, which are staged together in one folder (a DICOM series)."""


@dataclass(frozen=True, slots=True)
class JobKind:
    """One kind of job."""

    name: str
    service: str
    """The service whose worker runs it; also the name of its queue."""
    summary: str
    inputs: Mapping[str, InputSpec]
    params: type[BaseModel]
    result: type[BaseModel]
    time_limit: float = 3600.0
    """Seconds of wall time after which a job fails; a setting may override it."""
    memory_limit: int = 8 << 30
    """Bytes of resident memory above which a job fails; a setting may override it."""
    stages: tuple[str, ...] = field(default=())
    """Names of the stages in their order, so that a viewer can draw the path ahead."""
    searches: bool = False
    """Whether it reads the shape database. Its handler finds it in its context, and a question without inputs is
    answered by a resident process, too."""


SERVICES = ("segmentation", "retrieval", "motion")
"""Each has a queue and a worker image of its own."""

JOB_KINDS: dict[str, JobKind] = {}
"""All job kinds by name. A plugin (setting ``SHAPERY_PLUGINS``) may add its own with `register_kind`."""


def register_kind(kind: JobKind) -> None:
    """Add a job kind; its name must be new."""
    if kind.name in JOB_KINDS:
        raise ValueError(f"job kind {kind.name!r} is registered twice")
    JOB_KINDS[kind.name] = kind


def get_kind(name: str) -> JobKind:
    """Return the kind called `name`.

    Raises
    ------
    InvalidInput
        ``unknown_job_kind``, with the kinds there are.
    """
    try:
        return JOB_KINDS[name]
    except KeyError:
        known = ", ".join(sorted(JOB_KINDS))
        raise InvalidInput("unknown_job_kind", f"There is no job kind {name!r}.", f"Known kinds: {known}.") from None


_VOLUME = frozenset({AssetKind.VOLUME})

register_kind(
    JobKind(
        name="segmentation",
        service="segmentation",
        summary="Recover tumors, vessels and bleedings from volumes of a head, or any object that a seed points at.",
        inputs={
            "post": InputSpec(_VOLUME, "The volume after contrast (T1c); results lie on its grid.", many=True),
            "pre": InputSpec(_VOLUME, "The volume before contrast (T1).", required=False, many=True),
            "vessels": InputSpec(_VOLUME, "A volume that shows vessels: SWI, MRA or CTA.", required=False, many=True),
        },
        params=SegmentationParams,
        result=SegmentationResult,
        time_limit=1800.0,
        stages=("read", "register", "calibrate", "seed", "evolve", "vessels", "label", "write"),
    )
)

_MESH = frozenset({AssetKind.MESH})

register_kind(
    JobKind(
        name="shape-index",
        service="retrieval",
        summary="Describe a mesh by its attributed relational graph, so that it can be found by example.",
        inputs={"mesh": InputSpec(_MESH, "The mesh: OBJ, PLY, STL, OFF or GLB.")},
        params=ShapeIndexParams,
        result=ShapeIndexResult,
        time_limit=300.0,
        memory_limit=4 << 30,
        stages=("read", "normalise", "describe", "decompose", "views", "write"),
    )
)

register_kind(
    JobKind(
        name="shape-search",
        service="retrieval",
        summary="Find the shapes of the bank that resemble a mesh, a region of it, or a stored shape.",
        inputs={"mesh": InputSpec(_MESH, "The mesh to query by, where no stored shape is named.", required=False)},
        params=ShapeSearchParams,
        result=ShapeSearchResult,
        time_limit=300.0,
        memory_limit=4 << 30,
        stages=("read", "index", "candidates", "match", "write"),
        searches=True,
    )
)

register_kind(
    JobKind(
        name="motion-encode",
        service="motion",
        summary="Compress a mesh sequence into a motion file whose decoded error stays within a bound.",
        inputs={
            "sequence": InputSpec(
                frozenset({AssetKind.SEQUENCE, AssetKind.MESH}),
                "An npz file, a zip of meshes, or the meshes of the frames in the natural order of their names.",
                many=True,
            )
        },
        params=MotionEncodeParams,
        result=MotionEncodeResult,
        time_limit=7200.0,
        stages=("read", "encode", "verify", "write"),
    )
)

register_kind(
    JobKind(
        name="motion-decode",
        service="motion",
        summary="Turn a motion file into frames: npz, a zip of meshes, or an animated glTF scene.",
        inputs={"motion": InputSpec(frozenset({AssetKind.MOTION}), "A motion file (smc).")},
        params=MotionDecodeParams,
        result=MotionDecodeResult,
        stages=("read", "decode", "write"),
    )
)

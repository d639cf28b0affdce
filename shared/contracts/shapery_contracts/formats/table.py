"""The file formats that `shapery_contracts.formats.sniff` knows, as documentation and the API schema list them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from shapery_contracts.formats.model import AssetKind


@dataclass(frozen=True, slots=True)
class KnownFormat:
    """One format, with the endings and media types under which it is given out."""

    format: str
    kind: AssetKind
    summary: str
    extensions: tuple[str, ...]
    media_types: tuple[str, ...]


_GZIP = "application/gzip"
_ZIP = "application/zip"

KNOWN_FORMATS: Final = (
    KnownFormat(
        "nifti1", AssetKind.VOLUME, "NIfTI-1, plain or gzipped", (".nii", ".nii.gz"), ("application/x-nifti", _GZIP)
    ),
    KnownFormat(
        "nifti2", AssetKind.VOLUME, "NIfTI-2, plain or gzipped", (".nii", ".nii.gz"), ("application/x-nifti", _GZIP)
    ),
    KnownFormat(
        "nrrd",
        AssetKind.VOLUME,
        "NRRD; with detached data as a zip of both files",
        (".nrrd", ".zip"),
        ("application/x-nrrd", _ZIP),
    ),
    KnownFormat(
        "metaimage",
        AssetKind.VOLUME,
        "MetaImage; header and raw data as a zip of both files",
        (".mha", ".zip"),
        ("application/x-metaimage", _ZIP),
    ),
    KnownFormat(
        "dicom", AssetKind.VOLUME, "A DICOM file; a series is several of them", (".dcm",), ("application/dicom",)
    ),
    KnownFormat("dicom-zip", AssetKind.VOLUME, "A DICOM series as a zip", (".zip",), (_ZIP,)),
    KnownFormat("obj", AssetKind.MESH, "Wavefront OBJ", (".obj",), ("model/obj",)),
    KnownFormat("ply", AssetKind.MESH, "PLY, text or binary", (".ply",), ("application/x-ply",)),
    KnownFormat("stl", AssetKind.MESH, "STL, text or binary", (".stl",), ("model/stl",)),
    KnownFormat("off", AssetKind.MESH, "OFF as text", (".off",), ("application/x-off",)),
    KnownFormat("glb", AssetKind.MESH, "Binary glTF 2.0", (".glb",), ("model/gltf-binary",)),
    KnownFormat(
        "npz",
        AssetKind.SEQUENCE,
        "A mesh sequence: arrays `vertices` (frames, n, 3) and `faces` (m, 3)",
        (".npz",),
        ("application/x-npz",),
    ),
    KnownFormat("mesh-zip", AssetKind.SEQUENCE, "A mesh sequence as a zip of one mesh per frame", (".zip",), (_ZIP,)),
    KnownFormat("smc", AssetKind.MOTION, "A compressed motion", (".smc",), ("application/x-shapery-motion",)),
)
"""In the order in which they are told of."""

"""Recognition of files from their content."""

from __future__ import annotations

import contextlib
import gzip
import io
import json
import struct
import subprocess
import sys
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import pytest

from shapery_contracts.errors import InvalidInput, UserError
from shapery_contracts.formats import AssetKind, FileFormat, sniff
from shapery_contracts.formats.table import KNOWN_FORMATS


def gzipped(data: bytes) -> bytes:
    return gzip.compress(data, mtime=0)


def short(value: object) -> str | None:
    """Name a test by everything but its file's bytes, which hold times in archives and differ between processes."""
    return "file" if isinstance(value, bytes) else None


def told(data: bytes) -> FileFormat:
    return sniff(io.BytesIO(data), len(data))


def refused(data: bytes) -> UserError:
    with pytest.raises(UserError) as caught:
        told(data)
    return caught.value


def nifti1(shape: tuple[int, ...] = (4, 3, 2), datatype: int = 2, data: bytes | None = None, **fields: Any) -> bytes:
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, len(shape), *shape, *[1] * (7 - len(shape)))
    struct.pack_into("<2h", head, 70, datatype, fields.get("bitpix", 8))
    struct.pack_into("<8f", head, 76, 1, 0.5, 1.5, 2.5, 1, 1, 1, 1)
    struct.pack_into("<f", head, 108, fields.get("offset", 352))
    struct.pack_into("<b", head, 123, 2)
    head[344:348] = fields.get("magic", b"n+1\0")
    count = 1
    for n in shape:
        count *= n
    return bytes(head) + (bytes(count) if data is None else data)


def nifti2(shape: tuple[int, ...] = (4, 3, 2)) -> bytes:
    head = bytearray(544)
    struct.pack_into("<i8s2h8q", head, 0, 540, b"n+2\0\r\n\x1a\n", 2, 8, len(shape), *shape, *[1] * (7 - len(shape)))
    struct.pack_into("<8d", head, 104, 1, 0.5, 1.5, 2.5, 1, 1, 1, 1)
    struct.pack_into("<q", head, 168, 544)
    return bytes(head) + bytes(24)


def zip_of(**entries: bytes) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries.items():
            archive.writestr(name, data)
    return stream.getvalue()


def npy(shape: tuple[int, ...], dtype: str = "<f4", data: bytes | None = None, descr: str | None = None) -> bytes:
    text = f"{{'descr': {descr or repr(dtype)}, 'fortran_order': False, 'shape': {shape!r}, }}\n".encode()
    count = 1
    for n in shape:
        count *= n
    return (
        b"\x93NUMPY\x01\x00"
        + struct.pack("<H", len(text))
        + text
        + (bytes(count * int(dtype[2:])) if data is None else data)
    )


def npz(**arrays: bytes) -> bytes:
    return zip_of(**{f"{name}.npy": data for name, data in arrays.items()})


def dicom(*elements: tuple[int, int, bytes, bytes], syntax: bytes = b"1.2.840.10008.1.2.1\0") -> bytes:
    def explicit(group: int, number: int, vr: bytes, value: bytes) -> bytes:
        if vr in (b"OW", b"OB", b"SQ", b"UN"):
            return struct.pack("<2H2sHL", group, number, vr, 0, len(value)) + value
        return struct.pack("<2H2sH", group, number, vr, len(value)) + value

    meta = explicit(2, 0x10, b"UI", syntax)
    meta = explicit(2, 0, b"UL", struct.pack("<L", len(meta))) + meta
    return bytes(128) + b"DICM" + meta + b"".join(explicit(*element) for element in elements)


IMAGE = (
    (0x0008, 0x0060, b"CS", b"MR"),
    (0x0010, 0x0010, b"PN", b"Doe^Jane"),
    (0x0028, 0x0010, b"US", struct.pack("<H", 5)),
    (0x0028, 0x0011, b"US", struct.pack("<H", 7)),
    (0x7FE0, 0x0010, b"OW", bytes(70)),
)

OBJ = b"# a tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
OFF = b"OFF\n# counts\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"
PLY = (
    b"ply\nformat ascii 1.0\ncomment x\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    b"element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
)
FACET = b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
STL = b"solid a\n" + FACET + b"endsolid a\n"
BINARY_STL = bytes(80) + struct.pack("<L", 2) + bytes(100)
NRRD = b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nspacings: 1 2 3\nencoding: raw\n\n" + bytes(24)
MHA = b"ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + bytes(24)
MHD = MHA[:-24].replace(b"LOCAL", b"v.raw")


def glb(document: dict[str, Any] | bytes | None = None, length: int | None = None, version: int = 2) -> bytes:
    standard = {
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"count": 4}, {"count": 12}],
    }
    text = document if isinstance(document, bytes) else json.dumps(document or standard).encode()
    text += b" " * (-len(text) % 4)
    total = 20 + len(text)
    return b"glTF" + struct.pack("<3L", version, total if length is None else length, len(text)) + b"JSON" + text


@pytest.mark.parametrize(
    ("data", "kind", "name", "extension", "details"),
    [
        (nifti1(), "volume", "nifti1", ".nii", {"shape": [4, 3, 2], "spacing": [0.5, 1.5, 2.5], "dtype": "uint8"}),
        (gzipped(nifti1()), "volume", "nifti1", ".nii.gz", {"shape": [4, 3, 2]}),
        (nifti2(), "volume", "nifti2", ".nii", {"shape": [4, 3, 2], "spacing": [0.5, 1.5, 2.5]}),
        (gzipped(nifti2()), "volume", "nifti2", ".nii.gz", {"shape": [4, 3, 2]}),
        (NRRD, "volume", "nrrd", ".nrrd", {"shape": [4, 3, 2], "spacing": [1.0, 2.0, 3.0]}),
        (MHA, "volume", "metaimage", ".mha", {"shape": [4, 3, 2], "spacing": [1.0, 1.0, 1.0]}),
        (zip_of(**{"v.mhd": MHD, "v.raw": bytes(24)}), "volume", "metaimage", ".zip", {"shape": [4, 3, 2]}),
        (zip_of(**{"d/v.mhd": MHD, "d/v.raw": bytes(24)}), "volume", "metaimage", ".zip", {"shape": [4, 3, 2]}),
        (
            zip_of(**{"v.nhdr": NRRD[:-25].replace(b"raw", b"raw\ndata file: v.raw"), "v.raw": bytes(24)}),
            "volume", "nrrd", ".zip", {"shape": [4, 3, 2]},
        ),
        (dicom(*IMAGE), "volume", "dicom", ".dcm", {"modality": "MR", "shape": [7, 5, 1]}),
        (zip_of(a=dicom(*IMAGE), b=dicom(*IMAGE), README=b"notes"), "volume", "dicom-zip", ".zip", {"files": 3}),
        (OBJ, "mesh", "obj", ".obj", {}),
        (OFF, "mesh", "off", ".off", {"vertices": 4, "faces": 4}),
        (OFF.replace(b"OFF", b"COFF"), "mesh", "off", ".off", {"vertices": 4}),
        (OFF.replace(b"OFF", b"NOFF"), "mesh", "off", ".off", {"vertices": 4}),
        (OFF.replace(b"OFF\n# counts\n", b"OFF "), "mesh", "off", ".off", {"vertices": 4}),
        (PLY, "mesh", "ply", ".ply", {"vertices": 3, "faces": 1}),
        (PLY.replace(b"\n", b"\r\n"), "mesh", "ply", ".ply", {"vertices": 3, "faces": 1}),
        (STL, "mesh", "stl", ".stl", {}),
        (BINARY_STL, "mesh", "stl", ".stl", {"faces": 2}),
        (b"solid, says this binary file".ljust(80) + BINARY_STL[80:], "mesh", "stl", ".stl", {"faces": 2}),
        (glb(), "mesh", "glb", ".glb", {"vertices": 4, "faces": 4}),
        (npz(vertices=npy((5, 4, 3)), faces=npy((4, 3), "<i4")), "sequence", "npz", ".npz",
         {"frames": 5, "vertices": 4, "faces": 4}),
        (npz(vertices=npy((5, 4, 3)), faces=npy((4, 3), "<i4"), fps=npy((), "<f8")), "sequence", "npz", ".npz",
         {"frames": 5}),
        (zip_of(**{f"f{n}.obj": OBJ for n in range(30)}), "sequence", "mesh-zip", ".zip", {"frames": 30}),
        (zip_of(**{"only.ply": PLY, "notes.txt": b"hello"}), "sequence", "mesh-zip", ".zip", {"frames": 1}),
        (b"SMC1" + bytes(20), "motion", "smc", ".smc", {}),
    ],
    ids=short,
)  # fmt: skip
def test_every_format_is_told(data: bytes, kind: str, name: str, extension: str, details: dict[str, Any]) -> None:
    found = told(data)
    assert (found.kind, found.format, found.extension) == (AssetKind(kind), name, extension)
    assert {key: found.details[key] for key in details} == details
    # The table of formats that documentation and the API schema list says the same.
    listed = next(entry for entry in KNOWN_FORMATS if entry.format == name)
    assert listed.kind == found.kind
    assert extension in listed.extensions
    assert found.media_type in listed.media_types


@pytest.mark.parametrize(
    ("data", "code", "part"),
    [
        (b"", "empty_content", "empty"),
        (b"hello, world\n", "unknown_format", "no format that is known"),
        (bytes(84), "unknown_format", "no format that is known"),
        (b"\x00" * 5000, "unknown_format", "no format"),
        (bytes(range(256)) * 10, "unknown_format", "no format"),
        # text that is no OBJ, whatever its first lines look like
        (b"v 1 2 3\nhello\n", "unknown_format", "no format"),
        (b"v is the velocity\nf is the force\n", "unknown_format", "no format"),
        (b"o\ng\ns\n", "unknown_format", "no format"),
        (b"f 1 2 3\n", "unknown_format", "no format"),
        (b"v,1,2,3\nv,1,2,3\n", "unknown_format", "no format"),
        (b"import os\nv = 1\n", "unknown_format", "no format"),
        (b"1 2 3\n4 5 6\n", "unknown_format", "no format"),
        (b"{}", "unknown_format", "no format"),
        # damaged
        (nifti1((400, 300, 200), data=bytes(100)), "corrupt_file", "asks for 24000352 bytes"),
        (gzipped(nifti1((30000, 30000, 30000), data=b"")), "corrupt_file", "asks for 27000000000352 bytes"),
        (gzipped(nifti1())[:12], "corrupt_file", "cut off"),
        (gzipped(nifti1()[:100]), "corrupt_file", "cut off after 100 bytes"),
        (gzipped(nifti1())[:-9], "corrupt_file", "cut off"),
        (gzipped(b""), "empty_content", "nothing"),
        (b"\x1f\x8b" + b"\xff" * 100, "corrupt_file", "damaged"),
        (nifti1(magic=b"n+1\0", data=b"", shape=(0, 3, 2)), "corrupt_file", "0 × 3 × 2"),
        (nifti2().replace(b"\r\n\x1a\n", b"\n\x1a\n\n"), "corrupt_file", "text mode"),
        (NRRD[:-1], "corrupt_file", "24 bytes of data, and the file has 23"),
        (NRRD[:40], "corrupt_file", "cut off"),
        (NRRD.replace(b"sizes: 4 3 2", b"sizes: 4 3"), "corrupt_file", "dimension '3'"),
        (NRRD.replace(b"sizes: 4 3 2", b"sizes: 4 x 2"), "corrupt_file", "not as numbers"),
        (NRRD.replace(b"sizes: 4 3 2", b"sizes: 10000 10000 10000"), "corrupt_file", "1000000000000 bytes"),
        (NRRD.replace(b"type", b"type: a\ntype"), "corrupt_file", "twice"),
        (NRRD.replace(b"spacings: 1 2 3", b"spacings: 1 2"), "corrupt_file", "2 spacings for 3 axes"),
        (MHA[:-1], "corrupt_file", "24 bytes"),
        (MHA.replace(b"4 3 2", b"4 3"), "corrupt_file", "NDims = 3"),
        (MHA[:60], "corrupt_file", "breaks off"),
        (MHA.replace(b"ElementType", b"ElementSpacing = 1 x 2\nElementType"), "corrupt_file", "ElementSpacing"),
        (dicom(*IMAGE)[:-40], "corrupt_file", "cut off"),
        (dicom(*IMAGE)[:150], "corrupt_file", "does not end"),
        (dicom(*IMAGE, syntax=b"not a uid "), "corrupt_file", "transfer syntax"),
        (PLY.replace(b"end_header", b"no end"), "corrupt_file", "does not end"),
        (PLY.replace(b"element vertex 3", b"element vertex 1000000"), "corrupt_file", "1000001 bytes"),
        (PLY.replace(b"element vertex 3", b"element vertex -3"), "corrupt_file", "element vertex -3"),
        (PLY.replace(b"element vertex", b"element corner"), "corrupt_file", "no vertices"),
        (OFF.replace(b"4 4 6", b"x y z"), "corrupt_file", "counts"),
        (glb(length=10**6), "corrupt_file", "1000000 bytes"),
        (glb(b"{nonsense"), "corrupt_file", "JSON"),
        (glb({"meshes": [{"primitives": [{"attributes": {"POSITION": 99}}]}]}), "corrupt_file", "JSON"),
        (glb({"meshes": 7}), "corrupt_file", "JSON"),
        (glb()[:15], "corrupt_file", "15 bytes"),
        (npz(vertices=npy((5, 4, 3), data=bytes(7)), faces=npy((4, 3), "<i4")), "corrupt_file", "240 bytes"),
        (npz(vertices=b"nothing", faces=npy((4, 3), "<i4")), "corrupt_file", "no array"),
        (npz(vertices=npy((5, 4, 3), descr="(" * 3000), faces=npy((4, 3), "<i4")), "corrupt_file", "damaged"),
        (npz(vertices=npy((-5, 4, 3), data=b""), faces=npy((4, 3), "<i4")), "corrupt_file", "shape"),
        (zip_of(**{"v.mhd": MHD}), "corrupt_file", "v.raw"),
        (zip_of(**{"v.mhd": MHD, "v.raw": bytes(23)}), "corrupt_file", "24 bytes"),
        (zip_of(**{"v.mhd": MHD.replace(b"v.raw", b"../v.raw"), "v.raw": bytes(24)}), "unsafe_archive", "beside"),
        # known, and not read
        (nifti1(magic=b"ni1\0"), "unsupported_format", "NIfTI pair"),
        (nifti1(magic=b"\0\0\0\0"), "unsupported_format", "Analyze"),
        (nifti1(datatype=1), "unsupported_format", "single bits"),
        (nifti1(datatype=1536), "unsupported_format", "128-bit floats"),
        (NRRD.replace(b"encoding: raw", b"encoding: raw\ndata file: v.raw"), "unsupported_format", "detached"),
        (NRRD.replace(b"uchar", b"block"), "unsupported_format", "block"),
        (MHD, "unsupported_format", "v.raw"),
        (MHA.replace(b"LOCAL", b"slice%03d.raw 1 2 1"), "unsupported_format", "one data file per slice"),
        (MHA.replace(b"Image", b"Tube"), "unsupported_format", "Tube"),
        (dicom((8, 0x16, b"UI", b"1.2.840.10008.1.3.10")), "unsupported_format", "DICOMDIR"),
        (dicom((8, 0x16, b"UI", b"1.2.840.10008.5.1.4.1.1.88.22\0")), "unsupported_format", "structured report"),
        (dicom((8, 0x60, b"CS", b"MR")), "unsupported_format", "holds no image"),
        (OFF.replace(b"OFF\n", b"OFF BINARY\n"), "unsupported_format", "binary"),
        (b"OFF BINARY\n" + bytes(20), "unsupported_format", "binary"),
        (OFF.replace(b"OFF", b"4OFF"), "unsupported_format", "dimensions"),
        (PLY.replace(b"ascii", b"utf8"), "unsupported_format", "utf8"),
        (glb(version=1), "unsupported_format", "version 1"),
        (b'{"asset": {"version": "2.0"}, "buffers": []}', "unsupported_format", "glTF"),
        (b"\x89PNG\r\n\x1a\n" + bytes(20), "unsupported_format", "PNG"),
        (b"%PDF-1.4", "unsupported_format", "PDF"),
        (b"# vtk DataFile Version 3.0\n", "unsupported_format", "VTK"),
        (b"\x93NUMPY\x01\x00", "unsupported_format", "NumPy array"),
        (gzipped(NRRD), "unsupported_format", "only NIfTI"),
        (gzipped(OBJ), "unknown_format", "gzipped"),
        (zip_of(**{"v.nii": nifti1()}), "unsupported_format", "v.nii"),
        (zip_of(**{"v.nii.gz": gzipped(nifti1())}), "unsupported_format", "v.nii.gz"),
        (zip_of(**{"v.nrrd": NRRD}), "unsupported_format", "v.nrrd"),
        (zip_of(a=dicom(*IMAGE), b=OBJ), "unsupported_format", "together with other data"),
        (npz(vertices=npy((4, 3)), faces=npy((4, 3), "<i4")), "unsupported_format", "single mesh"),
        (npz(points=npy((5, 4, 3)), faces=npy((4, 3), "<i4")), "unsupported_format", "it has faces, points"),
        (npz(vertices=npy((5, 4, 2)), faces=npy((4, 3), "<i4")), "unsupported_format", "(5, 4, 2)"),
        (npz(vertices=npy((5, 4, 3)), faces=npy((4, 3), "<f4")), "unsupported_format", "<f4"),
        (npz(vertices=npy((5, 4, 3), descr="'|O'"), faces=npy((4, 3), "<i4")), "unsupported_format", "no plain"),
        (zip_of(**{"a.txt": b"hello", "b.txt": b"world"}), "unknown_format", "None of the 2 files"),
        (zip_of(), "empty_content", "no files"),
        (zip_of(**{"a.obj": OBJ})[:-30], "corrupt_file", "truncated"),
    ],
    ids=short,
)  # fmt: skip
def test_what_cannot_be_used_is_refused_with_a_sentence(data: bytes, code: str, part: str) -> None:
    error = refused(data)
    assert error.code == code
    assert part in error.message
    assert error.message.endswith(".")


def test_meshes_larger_than_the_window_are_told() -> None:
    vertices = b"".join(b"v %d 0.5 -1e-3\n" % n for n in range(20_000))
    assert told(vertices).format == "obj"
    # A line that is cut by the window does not count.
    assert told(vertices + b"f 1 2 3\n" * 3).format == "obj"
    assert told(b"# long comment\n" * 2000 + OBJ).format == "obj"


def test_obj_lines_may_be_continued_and_carry_colours() -> None:
    assert told(b"v 0 0 0 1 0 0\nv 1 0 0 0.5 .5 1.\nv 0 1 0 0 0 1\nf 1 \\\n 2 \\\n 3\nusemtl my red\n").format == "obj"
    assert told(OBJ.replace(b"\n", b"\r\n")).format == "obj"
    assert told(b"\xef\xbb\xbf" + OBJ).format == "obj"


def test_sequences_of_dicom_elements_are_walked() -> None:
    def undefined(group: int, number: int, vr: bytes, body: bytes) -> bytes:
        return struct.pack("<2H2sHL", group, number, vr, 0, 0xFFFFFFFF) + body + struct.pack("<2HL", 0xFFFE, 0xE0DD, 0)

    def item(body: bytes, defined: bool) -> bytes:
        if defined:
            return struct.pack("<2HL", 0xFFFE, 0xE000, len(body)) + body
        return struct.pack("<2HL", 0xFFFE, 0xE000, 0xFFFFFFFF) + body + struct.pack("<2HL", 0xFFFE, 0xE00D, 0)

    rows_inside = struct.pack("<2H2sHH", 0x28, 0x10, b"US", 2, 99)
    implicit_inside = struct.pack("<2HLH", 0x28, 0x10, 2, 99)
    nested = item(undefined(8, 0x1140, b"SQ", item(rows_inside, False) + item(rows_inside, True)), False)
    for sequence in (undefined(8, 0x1115, b"SQ", nested), undefined(9, 0x1010, b"UN", item(implicit_inside, False))):
        data = dicom(*IMAGE)
        at = data.index(struct.pack("<2H", 0x10, 0x10))
        assert told(data[:at] + sequence + data[at:]).details["shape"] == [7, 5, 1]


def test_a_dicom_file_may_declare_another_form_than_it_is_written_in() -> None:
    assert told(dicom(*IMAGE, syntax=b"1.2.840.10008.1.2\0")).details["shape"] == [7, 5, 1]
    implicit = b"".join(struct.pack("<2HL", g, n, len(value)) + value for g, n, _, value in IMAGE)
    for syntax in (b"1.2.840.10008.1.2.1\0", b"1.2.840.10008.1.2\0"):
        assert told(dicom(syntax=syntax) + implicit).details["shape"] == [7, 5, 1]


def test_nothing_of_the_patient_is_told() -> None:
    assert "Doe" not in told(dicom(*IMAGE)).model_dump_json()


def test_names_in_a_zip_decide_nothing() -> None:
    assert told(zip_of(**{"a.dcm": OBJ, "b.dcm": OBJ})).format == "mesh-zip"
    assert told(zip_of(**{"a.obj": dicom(*IMAGE), "b.ply": dicom(*IMAGE)})).format == "dicom-zip"


def test_a_few_meshes_are_found_among_many_other_files() -> None:
    entries = {f"texture{n:03d}.png": b"\x89PNG\r\n\x1a\n" for n in range(100)}
    found = told(zip_of(**entries, **{f"z{n}.ply": PLY for n in range(3)}))
    assert (found.format, found.details["frames"]) == ("mesh-zip", 3)


class _Counting(io.BytesIO):
    taken = 0

    def read(self, size: int | None = -1) -> bytes:
        data = super().read(size)
        self.taken += len(data)
        return data


def test_reads_are_bounded_whatever_the_size() -> None:
    large = 40_000_000
    for data in (
        nifti1((400, 400, 250), data=bytes(large)),
        bytes(80) + struct.pack("<L", large // 50) + bytes(large),
        b"v 0.125 0.25 0.5\n" * (large // 17),
        b"x" * large,
        NRRD.replace(b"4 3 2", b"4 3 %d" % (large // 12)) + bytes(large),
    ):
        stream = _Counting(data)
        tracemalloc.start()
        try:
            with contextlib.suppress(InvalidInput):
                sniff(stream, len(data))
            assert stream.taken <= 1 << 20
            # The text of a window, split into lines and words.
            assert tracemalloc.get_traced_memory()[1] < 4_000_000
        finally:
            tracemalloc.stop()


def test_bombs_cost_nothing() -> None:
    bomb = gzipped(bytes(60_000_000))
    inflated = gzipped(nifti1((1000, 1000, 60), data=bytes(60_000_000)))
    packed = zip_of(**{"a.obj": bytes(60_000_000), "b.dcm": bytes(60_000_000)})
    for data, code in ((bomb, "unknown_format"), (inflated, None), (packed, "unknown_format")):
        tracemalloc.start()
        try:
            if code is None:
                assert told(data).format == "nifti1"
            else:
                assert refused(data).code == code
            assert tracemalloc.get_traced_memory()[1] < 2_000_000
        finally:
            tracemalloc.stop()


def test_a_hundred_bytes_that_claim_a_trillion_voxels() -> None:
    nrrd = b"NRRD0004\ntype: float\ndimension: 3\nsizes: 10000 10000 10000\nencoding: gzip\n\n" + bytes(20)
    mha = MHA[:-24].replace(b"4 3 2", b"10000 10000 10000")
    for data in (nrrd, mha, gzipped(nifti1((10000, 10000, 10000), data=b""))):
        assert len(data) < 200
        assert refused(data).code == "corrupt_file"


def test_recognition_needs_no_numerics() -> None:
    code = "import sys, shapery_contracts.formats; print(sorted({'numpy', 'nibabel', 'pydicom'} & set(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


EXPECTED_MESHES = {".obj": "obj", ".ply": "ply", ".stl": "stl", ".off": "off"}


@pytest.mark.data
def test_every_difficult_mesh_is_told(shared_data: Path) -> None:
    files = sorted((shared_data / "meshes" / "difficult").iterdir())
    assert len(files) >= 25
    for path in files:
        with path.open("rb") as stream:
            found = sniff(stream, path.stat().st_size)
        assert (found.kind, found.format) == (AssetKind.MESH, EXPECTED_MESHES[path.suffix.lower()]), path.name


@pytest.mark.data
def test_every_sequence_and_volume_is_told(shared_data: Path) -> None:
    for path in sorted((shared_data / "motion").glob("*.npz")):
        with path.open("rb") as stream:
            found = sniff(stream, path.stat().st_size)
        assert (found.kind, found.format) == (AssetKind.SEQUENCE, "npz")
    formats = {".nrrd": "nrrd", ".mha": "metaimage", ".dcm": "dicom", ".gz": "nifti1", ".nii": "nifti1"}
    paths = [p for p in sorted((shared_data / "volumes").rglob("*")) if p.suffix in formats]
    assert len(paths) > 80
    for path in paths:
        with path.open("rb") as stream:
            found = sniff(stream, path.stat().st_size)
        assert (found.kind, found.format) == (AssetKind.VOLUME, formats[path.suffix]), path.name

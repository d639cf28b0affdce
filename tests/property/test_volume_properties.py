"""Laws of volumes, and of recognition and readers on bytes that nobody meant."""

from __future__ import annotations

import contextlib
import gzip
import io
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import nibabel as nib
import nrrd
import numpy as np
import pytest
import SimpleITK
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from shapery_contracts.archives import open_archive
from shapery_contracts.errors import UserError
from shapery_contracts.formats import sniff
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import ReadLimits, read_volume, write_nifti
from tests.support.volumes import ORIENTATIONS, dicom_slice, phantom, stored_as, write_dicom, write_multiframe

FUZZ = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])


@st.composite
def affines(draw: st.DrawFn, *, sheared: bool = True) -> np.ndarray:
    """Rotations with spacings of six orders of magnitude, left-handed ones and sheared ones among them."""
    angles = draw(st.tuples(*[st.floats(-np.pi, np.pi)] * 3))
    spacing = draw(st.tuples(*[st.floats(1e-2, 1e2)] * 3))
    origin = draw(st.tuples(*[st.floats(-1e4, 1e4)] * 3))
    matrix = np.eye(3)
    for axis, angle in enumerate(angles):
        turn = np.eye(3)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
        matrix = matrix @ turn
    if sheared:
        matrix = matrix @ (np.eye(3) + np.triu(draw(st.floats(-0.5, 0.5)) * np.ones((3, 3)), 1))
    if draw(st.booleans()):
        matrix[:, draw(st.integers(0, 2))] *= -1
    affine = np.eye(4)
    affine[:3, :3] = matrix * spacing
    affine[:3, 3] = origin
    return affine


@given(affines(), st.tuples(*[st.floats(-500, 500)] * 3))
def test_index_to_world_and_back(affine: np.ndarray, ijk: tuple[float, float, float]) -> None:
    volume = Volume(np.zeros((2, 3, 4), np.uint8), affine)
    # Ten digits remain: origins reach 1e4 mm, spacings go down to 1e-2.
    np.testing.assert_allclose(volume.to_index(volume.to_world(ijk)), ijk, rtol=1e-9, atol=1e-8)


@given(affines(), st.sampled_from(ORIENTATIONS))
def test_the_canonical_form_does_not_depend_on_the_order_of_storage(affine: np.ndarray, orientation: tuple) -> None:
    volume = Volume(phantom().data, affine)
    stored = stored_as(volume, *orientation)
    one, _ = volume.canonical()
    other, way = stored.canonical()
    np.testing.assert_array_equal(one.data, other.data)
    np.testing.assert_allclose(one.affine, other.affine, rtol=1e-9, atol=1e-7)
    assert (np.diag(other.affine[:3, :3]) > 0).all()
    back = way.undo(other)
    np.testing.assert_array_equal(back.data, stored.data)
    assert back.affine.tobytes() == stored.affine.tobytes()


@given(affines(), st.sampled_from(ORIENTATIONS))
def test_voxels_keep_their_place_in_the_world(affine: np.ndarray, orientation: tuple) -> None:
    stored = stored_as(Volume(phantom().data, affine), *orientation)
    canonical, _ = stored.canonical()
    value = 137
    one = stored.to_world(np.argwhere(stored.data == value)[0])
    other = canonical.to_world(np.argwhere(canonical.data == value)[0])
    np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-8)


@settings(max_examples=40, deadline=None)
@given(affines(), st.sampled_from(["uint8", "int16", "int32", "float32", "float64"]), st.booleans())
def test_nifti_gives_back_what_was_written(affine: np.ndarray, dtype: str, packed: bool) -> None:
    volume = Volume(phantom().data.astype(dtype), affine)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / ("v.nii.gz" if packed else "v.nii")
        write_nifti(volume, path)
        again = read_volume(path)
        other = nib.load(path)
        np.testing.assert_array_equal(again.data, volume.data)
        assert again.data.dtype == dtype
        np.testing.assert_array_equal(again.affine, affine.astype(np.float32))
        np.testing.assert_array_equal(other.affine, again.affine)


@given(affines(sheared=False), affines(sheared=False))
@settings(max_examples=50, deadline=None)
def test_resampling_there_and_back_keeps_constants(one: np.ndarray, other: np.ndarray) -> None:
    source = Volume(np.full((4, 5, 6), 3.5, np.float32), one)
    moved = source.resampled_to(Volume(np.zeros((3, 4, 5), np.uint8), other), fill=-1)
    inside = source.contains(moved.to_world(np.moveaxis(np.indices(moved.shape), 0, -1)))
    # Points on the very border may fall on either side by rounding.
    assert set(np.unique(moved.data)) <= {np.float32(3.5), np.float32(-1)}
    assert np.count_nonzero((moved.data == 3.5) != inside) <= 2


# ---------------------------------------------------------------------------------------------------------------------


def _files() -> dict[str, bytes]:
    """A sound file of every format, each with data enough for a reader to go wrong in."""
    volume = phantom()
    found: dict[str, bytes] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_nifti(volume, folder / "a.nii")
        write_nifti(volume, folder / "a.nii.gz")
        nib.save(nib.Nifti2Image(volume.data, volume.affine), folder / "a2.nii")
        header = {
            "space": "left-posterior-superior",
            "space directions": np.eye(3),
            "kinds": ["domain"] * 3,
            "space origin": np.zeros(3),
        }
        for encoding in ("raw", "gzip", "bzip2", "ascii"):
            nrrd.write(str(folder / f"{encoding}.nrrd"), volume.data, {**header, "encoding": encoding})
        image = SimpleITK.GetImageFromArray(volume.data)
        SimpleITK.WriteImage(image, str(folder / "a.mha"))
        SimpleITK.WriteImage(image, str(folder / "b.mha"), useCompression=True)
        write_multiframe(folder / "a.dcm", volume)
        for path in list(folder.iterdir()):
            found[path.name] = path.read_bytes()
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w") as archive:
            for k in range(volume.shape[2]):
                slice_path = write_dicom(dicom_slice(volume, k, series="1.2.3"), folder / "s.dcm")
                archive.write(slice_path, f"{k}.dcm")
        found["dicom.zip"] = stream.getvalue()
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
            SimpleITK.WriteImage(image, str(folder / "z.mhd"))
            archive.write(folder / "z.mhd", "z.mhd")
            archive.write(folder / "z.raw", "z.raw")
        found["mhd.zip"] = stream.getvalue()
        stream = io.BytesIO()
        np.savez(stream, vertices=np.zeros((2, 4, 3), np.float32), faces=np.zeros((4, 3), np.int32))
        found["a.npz"] = stream.getvalue()
    found["a.obj"] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    found["a.off"] = b"OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n"
    found["a.ply"] = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n"
    found["a.stl"] = bytes(80) + (2).to_bytes(4, "little") + bytes(100)
    found["a.glb"] = b"glTF" + (2).to_bytes(4, "little") + (22).to_bytes(4, "little") + b"\x02\0\0\0JSON{}"
    return found


FILES = _files()
VOLUMES = {
    name: data
    for name, data in FILES.items()
    if Path(name).suffix not in (".npz", ".obj", ".off", ".ply", ".stl", ".glb")
}


@st.composite
def mutated(draw: st.DrawFn, files: dict[str, bytes]) -> bytes:
    """A sound file with a few of its bytes changed, cut out, doubled, or with its end missing.

    Most changes fall into the first 600 bytes, where headers stand, or into the last 200, where directories end.
    """
    data = bytearray(draw(st.sampled_from(sorted(files.items())))[1])
    unpacked = data[:2] == b"\x1f\x8b" and draw(st.booleans())
    if unpacked:
        data = bytearray(gzip.decompress(bytes(data)))
    for _ in range(draw(st.integers(1, 4))):
        size = len(data)
        if size == 0:
            break
        near = st.integers(0, min(600, size) - 1)
        at = draw(near | st.integers(max(0, size - 200), size - 1) | st.integers(0, size - 1))
        action = draw(st.sampled_from(["byte", "word", "text", "cut", "double", "end"]))
        if action == "byte":
            data[at] = draw(st.integers(0, 255))
        elif action == "word":
            word = draw(
                st.sampled_from([b"\xff\xff\xff\xff", b"\0\0\0\0", b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0\0\xc0\x7f"])
            )
            data[at : at + 4] = word
        elif action == "text":
            data[at : at + 1] = draw(
                st.sampled_from([b"999999999999", b"-1", b"nan", b"inf", b"1e400", b"\n", b"(", b" "])
            )
        elif action == "cut":
            del data[at : at + draw(st.integers(1, 50))]
        elif action == "double":
            data[at:at] = data[at : at + draw(st.integers(1, 50))]
        else:
            del data[at:]
    return gzip.compress(bytes(data), mtime=0) if unpacked else bytes(data)


@FUZZ
@given(st.binary(max_size=2000))
@example(b"")
@example(b"PK\x03\x04")
@example(b"PK\x05\x06" + bytes(18))
@example(b"\x1f\x8b")
@example(b"glTF" + b"\xff" * 16)
@example(bytes(128) + b"DICM")
@example(b"NRRD0004\n")
@example(b"NDims = 3\n")
@example(b"ply\n")
@example(b"OFF")
def test_recognition_of_any_bytes_tells_or_refuses(data: bytes) -> None:
    with contextlib.suppress(UserError):
        sniff(io.BytesIO(data), len(data))


@settings(FUZZ, max_examples=200)
@given(mutated(FILES))
def test_recognition_of_damaged_files_tells_or_refuses(data: bytes) -> None:
    with contextlib.suppress(UserError):
        sniff(io.BytesIO(data), len(data))


@FUZZ
@given(
    st.binary(max_size=300).map(lambda tail: FILES["dicom.zip"][:-100] + tail)
    | mutated({"a": FILES["mhd.zip"], "b": FILES["a.npz"]})
)
def test_archives_give_their_entries_or_are_refused(data: bytes) -> None:
    with contextlib.suppress(UserError):
        archive = open_archive(io.BytesIO(data))
        for entry in archive.entries:
            assert len(archive.read(entry.name)) == entry.size


@settings(FUZZ, max_examples=200)
@given(mutated(VOLUMES))
def test_readers_of_damaged_files_give_a_volume_or_refuse(data: bytes) -> None:
    limits = ReadLimits(voxels=1 << 20, bytes=1 << 24)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "file"
        path.write_bytes(data)
        with contextlib.suppress(UserError):
            volume = read_volume(path, limits=limits)
            assert min(volume.shape) >= 2
            assert np.isfinite(volume.affine).all()
            assert volume.statistics().finite > 0


@pytest.mark.parametrize("name", sorted(FILES))
def test_the_files_that_are_damaged_are_sound(name: str) -> None:
    # Else the tests above would only see files that are refused at once.
    data = FILES[name]
    sniff(io.BytesIO(data), len(data))


def _read(data: bytes, tmp_path: Path) -> Volume:
    (tmp_path / "file").write_bytes(data)
    return read_volume(tmp_path / "file")


@pytest.mark.parametrize("name", sorted(VOLUMES))
def test_the_volumes_that_are_damaged_are_sound(name: str, tmp_path: Path) -> None:
    check: Callable[[bytes, Path], Volume] = _read
    assert check(VOLUMES[name], tmp_path).data.size == 210

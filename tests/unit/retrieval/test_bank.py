"""Banks in a file, the jobs and the commands over them."""

from __future__ import annotations

import json
import sqlite3
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from shapery_client.cli import app
from shapery_contracts.errors import InvalidInput, Unavailable
from shapery_contracts.retrieval import (
    VECTOR_DIMENSION,
    Nearest,
    ShapeFilter,
    ShapeIndexParams,
    ShapeSearchParams,
    ShapeSearchResult,
)
from shapery_geometry.mesh_io import read_mesh, write_mesh
from shapery_retrieval.arg import Arg
from shapery_retrieval.coverage import asked_of, coverage_of
from shapery_retrieval.describe import Description
from shapery_retrieval.job import ShapeIndexHandler, ShapeSearchHandler
from shapery_retrieval.local import LocalBank
from shapery_retrieval.patches import patches_of
from shapery_retrieval.vector import vector_of

from .conftest import egg, torus


class Context:
    """A job's surroundings that only listen."""

    def __init__(self, folder: Path, bank: LocalBank | None = None) -> None:
        self.output = folder / "output"
        self.scratch = folder / "scratch"
        self.output.mkdir()
        self.scratch.mkdir()
        self.bank = bank
        self.stages: list[str] = []
        self.fractions: list[float] = []

    def stage(self, name: str, fraction: float, message: str = "") -> None:
        self.stages.append(name)
        self.fractions.append(fraction)

    def progress(self, fraction: float, message: str = "") -> None:
        self.fractions.append(fraction)

    def check_cancelled(self) -> None:
        pass


@pytest.fixture
def bank(tmp_path: Path, described_egg: Description, described_torus: Description) -> LocalBank:
    bank = LocalBank(tmp_path / "bank.db")
    bank.put("egg", b"egg", described_egg.arg)
    bank.put("torus", b"torus", described_torus.arg)
    yield bank
    bank.close()


def test_a_bank_gives_back_what_was_put_in(bank: LocalBank, described_egg: Description) -> None:
    assert len(bank) == 2
    assert bank.names() == ["egg", "torus"]
    assert bank.args(["egg", "nothing"]) == {"egg": described_egg.arg.to_bytes()}
    assert bank.holds("egg", b"egg")
    assert not bank.holds("egg", b"another")
    with LocalBank(bank.path, must_exist=True) as again:
        assert again.names() == ["egg", "torus"]
    assert bank.remove("egg")
    assert not bank.remove("egg")
    assert bank.names() == ["torus"]


def test_candidates_are_the_nearest_of_the_version(bank: LocalBank, described_egg: Description) -> None:
    vector = vector_of(described_egg.arg)
    assert vector.shape == (VECTOR_DIMENSION,)
    found = bank.candidates(Nearest(vector=vector.tolist(), limit=5))
    assert [candidate.shape_id for candidate in found] == ["egg", "torus"]
    assert found[0].distance == pytest.approx(0, abs=1e-5)
    assert found[1].distance > 0.1
    assert bank.candidates(Nearest(vector=vector.tolist(), limit=1)) == [found[0]]
    assert bank.candidates(Nearest(vector=vector.tolist(), limit=5, version=99)) == []
    with pytest.raises(InvalidInput, match="neither collections nor labels"):
        bank.candidates(Nearest(vector=vector.tolist(), limit=5, only=ShapeFilter(collection="x")))


def test_candidates_for_a_part_are_those_that_cover_it(bank: LocalBank, described_torus: Description) -> None:
    asked = asked_of([patches_of(described_torus.arg)])
    found = bank.candidates(Nearest(vector=asked.tolist(), limit=5, by="parts"))
    assert [candidate.shape_id for candidate in found] == ["torus", "egg"]
    covered = coverage_of(described_torus.arg)
    assert found[0].distance == pytest.approx(np.linalg.norm(covered - asked), rel=1e-5)
    np.testing.assert_array_equal(np.frombuffer(found[0].vector, "<f4"), covered.astype(np.float32))


def test_a_bank_of_a_former_version_is_opened_and_its_shapes_are_left_out(
    tmp_path: Path, described_egg: Description
) -> None:
    path = tmp_path / "former.db"
    with LocalBank(path) as bank:
        bank.put("egg", b"egg", described_egg.arg)
        bank.put("other", b"other", described_egg.arg)
    former = sqlite3.connect(path)
    former.execute("ALTER TABLE shapes DROP COLUMN part_vector")
    former.execute("UPDATE shapes SET index_version = index_version - 1")
    former.commit()
    former.close()
    with LocalBank(path) as bank:
        assert bank.outdated() == 2
        assert bank.args(["egg"]) == {}
        assert bank.candidates(Nearest(vector=coverage_of(described_egg.arg).tolist(), limit=5, by="parts")) == []
        assert not bank.holds("egg", b"egg")
        bank.put("egg", b"egg", described_egg.arg)
        assert bank.outdated() == 1
        (found,) = bank.candidates(Nearest(vector=coverage_of(described_egg.arg).tolist(), limit=5, by="parts"))
        assert (found.shape_id, found.distance) == ("egg", pytest.approx(0, abs=1e-5))


def test_other_files_are_no_banks(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("this is a text that is longer than a header of a database" * 20)
    with pytest.raises(InvalidInput, match="no bank of shapes"):
        LocalBank(tmp_path / "text")
    other = sqlite3.connect(tmp_path / "other.db")
    other.execute("CREATE TABLE mine (x)")
    other.commit()
    other.close()
    with pytest.raises(InvalidInput, match="but no bank of shapes"):
        LocalBank(tmp_path / "other.db")
    with pytest.raises(InvalidInput, match="There is no bank"):
        LocalBank(tmp_path / "nothing.db", must_exist=True)
    assert not (tmp_path / "nothing.db").exists()


def png_size(data: bytes) -> tuple[int, int]:
    """Check the checksums of a PNG file and return its size."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    place, pixels, size = 8, b"", (0, 0)
    while place < len(data):
        length, name = struct.unpack_from(">I4s", data, place)
        body = data[place + 8 : place + 8 + length]
        assert struct.unpack_from(">I", data, place + 8 + length)[0] == zlib.crc32(name + body)
        if name == b"IHDR":
            size = struct.unpack_from(">II", body)
        if name == b"IDAT":
            pixels += body
        place += 12 + length
    raw = np.frombuffer(zlib.decompress(pixels), np.uint8).reshape(size[1], 1 + 4 * size[0])
    opaque = (raw[:, 1:].reshape(size[1], size[0], 4)[..., 3] == 255).mean()
    assert 0.15 < opaque < 0.9, "the shape fills a good part of the picture"
    return size


def test_indexing_leaves_everything_a_viewer_needs(tmp_path: Path, described_egg: Description) -> None:
    write_mesh(egg(), tmp_path / "mesh.ply")
    context = Context(tmp_path)
    result = ShapeIndexHandler().run(ShapeIndexParams(preview_size=64), {"mesh": tmp_path / "mesh.ply"}, context)
    assert context.stages == ["read", "normalise", "describe", "decompose", "views", "patches", "write"]
    assert context.fractions == sorted(context.fractions)
    assert context.fractions[-1] == 1.0
    assert sorted(path.name for path in context.output.iterdir()) == [
        "components.json", "mesh.glb", "preview.png", "report.json", "shape.arg",
    ]  # fmt: skip
    data = (context.output / "shape.arg").read_bytes()
    assert len(data) == result.arg_bytes
    np.testing.assert_allclose(vector_of(Arg.from_bytes(data)), result.vector)
    assert json.loads((context.output / "report.json").read_text()) == result.model_dump(mode="json")
    shown = read_mesh(context.output / "mesh.glb")
    components = json.loads((context.output / "components.json").read_text())
    assert components["vertices"] == len(shown.vertices)
    for level, summary in zip(components["levels"], result.levels, strict=True):
        labels = np.array(level["labels"])
        assert len(labels) == len(shown.vertices)
        assert set(np.unique(labels)) <= set(range(summary.parts))
        assert len(np.unique(labels)) > 0.9 * summary.parts
        assert sum(summary.masses) == pytest.approx(1, abs=1e-3)
    assert png_size((context.output / "preview.png").read_bytes()) == (64, 64)
    assert result.closed
    assert result.genus == 0
    assert result.warnings == []


def test_searching_by_mesh_by_region_and_by_name(tmp_path: Path, bank: LocalBank) -> None:
    write_mesh(torus(48, 24, thickness=0.36), tmp_path / "mesh.ply")
    handler, inputs = ShapeSearchHandler(), {"mesh": tmp_path / "mesh.ply"}
    (tmp_path / "whole").mkdir()
    context = Context(tmp_path / "whole", bank)
    found = handler.run(ShapeSearchParams(), inputs, context)
    assert [hit.shape_id for hit in found.hits] == ["torus", "egg"]
    assert 0 <= found.hits[1].score < found.hits[0].score <= 1
    assert sum(found.cues.values()) == pytest.approx(1, abs=1e-3)
    assert len(found.hits[0].level_scores) == 3
    stored = ShapeSearchResult.model_validate_json((context.output / "results.json").read_text())
    assert stored == found
    # what is matched can be shown: the query's mesh with its parts
    shown = read_mesh(context.output / "mesh.glb")
    parts = json.loads((context.output / "components.json").read_text())
    assert [len(level["labels"]) for level in parts["levels"]] == [len(shown.vertices)] * 3
    assert all(match.query <= max(parts["levels"][hit.level]["labels"]) for hit in found.hits for match in hit.matches)
    # each vertex lies in a cell, and parts consist of cells; which part lies on a cell of a found shape is told
    assert len(parts["cells"]) == len(shown.vertices)
    assert len(set(zip(parts["cells"], parts["levels"][2]["labels"], strict=True))) == len(set(parts["cells"]))
    for hit in found.hits:
        assert len(hit.cells) == len(Arg.from_bytes(bank.args([hit.shape_id])[hit.shape_id]).whole["patch_parts"])
        assert set(hit.cells) <= set(parts["levels"][2]["labels"])

    (tmp_path / "part").mkdir()
    part = handler.run(ShapeSearchParams(region=list(range(900))), inputs, Context(tmp_path / "part", bank))
    assert part.mode == "partial"
    assert part.hits[0].shape_id == "torus"
    assert len(part.hits[0].matches) < 32

    (tmp_path / "name").mkdir()
    named = handler.run(ShapeSearchParams(shape_id="egg", parts=[9, 30, 11]), {}, Context(tmp_path / "name", bank))
    assert [hit.shape_id for hit in named.hits] == ["torus"]
    # parts keep the numbers that they have in the whole shape
    finest = Arg.from_bytes(bank.args(["egg"])["egg"]).levels[2]
    known = {1: set(finest.parents[[9, 11, 30]].tolist()), 2: {9, 11, 30}}
    assert all({match.query for match in hit.matches} <= known[hit.level] for hit in named.hits)
    assert all(set(hit.cells) <= {-1, 9, 11, 30} for hit in named.hits)
    assert [path.name for path in (tmp_path / "name" / "output").iterdir()] == ["results.json"]


def test_searches_that_cannot_be_answered_say_why(tmp_path: Path, bank: LocalBank) -> None:
    handler = ShapeSearchHandler()
    (tmp_path / "a").mkdir()
    context = Context(tmp_path / "a", bank)
    with pytest.raises(InvalidInput, match="Give a mesh, or name a stored shape"):
        handler.run(ShapeSearchParams(), {}, context)
    with pytest.raises(InvalidInput, match="no shape 'nothing'"):
        handler.run(ShapeSearchParams(shape_id="nothing"), {}, context)
    with pytest.raises(InvalidInput, match="32 parts"):
        handler.run(ShapeSearchParams(shape_id="egg", parts=[32]), {}, context)
    context.bank = None
    with pytest.raises(Unavailable, match="no shape database"):
        handler.run(ShapeSearchParams(shape_id="egg"), {}, context)


@pytest.mark.slow
def test_the_commands_from_files_to_a_matrix(tmp_path: Path) -> None:
    write_mesh(egg(), tmp_path / "egg.ply")
    write_mesh(torus(40, 20), tmp_path / "torus.obj")
    (tmp_path / "broken.ply").write_text("ply\nformat ascii 1.0\nelement vertex 0\nend_header\n")
    run, bank = CliRunner(), str(tmp_path / "bank.db")
    first = run.invoke(app, ["index", str(tmp_path), "--bank", bank, "--jobs", "1", "--json"])
    assert first.exit_code == 3
    outcomes = {outcome["name"]: outcome for outcome in json.loads(first.stdout)}
    assert outcomes["egg.ply"]["indexed"]
    assert outcomes["broken.ply"]["error"]["message"].endswith(".")
    again = run.invoke(app, ["index", str(tmp_path / "egg.ply"), "--bank", bank])
    assert again.exit_code == 0
    assert "0 indexed, 1 unchanged" in again.stdout
    found = run.invoke(app, ["search", str(tmp_path / "torus.obj"), "--bank", bank, "--json"])
    assert found.exit_code == 0
    hits = json.loads(found.stdout)["hits"]
    assert [hit["shape_id"] for hit in hits] == ["torus.obj", "egg.ply"]
    assert hits[0]["score"] == pytest.approx(1, abs=1e-4)
    stored = run.invoke(app, ["search", "torus.obj", "--bank", bank, "--json"])
    assert [hit["shape_id"] for hit in json.loads(stored.stdout)["hits"]] == ["egg.ply"]
    by_parts = run.invoke(app, ["search", "egg.ply", "--bank", bank, "--part", "1", "--part", "2", "--json"])
    assert json.loads(by_parts.stdout)["mode"] == "partial"
    assert all(len(hit["matches"]) <= 2 for hit in json.loads(by_parts.stdout)["hits"])
    faces = tmp_path / "faces.txt"
    faces.write_text("\n".join(str(face) for face in range(300)))
    asked = ["search", str(tmp_path / "torus.obj"), "--bank", bank, "--region", str(faces), "--json"]
    assert json.loads(run.invoke(app, asked).stdout)["hits"][0]["shape_id"] == "torus.obj"
    faces.write_text("1 2 three")
    for options, told in (
        (["--region", str(faces)], "no list of the numbers of faces"),
        (["--collection", "bones"], "neither collections nor labels"),
        (["--part", "99"], "32 parts"),
    ):
        refused = run.invoke(app, ["search", "egg.ply", "--bank", bank, *options])
        assert told in str(refused.exception or refused.output)
    for options in ([], ["--rerank"]):
        out = tmp_path / "scores.npz"
        assert run.invoke(app, ["matrix", "--bank", bank, "--out", str(out), *options]).exit_code == 0
        with np.load(out, allow_pickle=False) as stored:
            assert stored["names"].tolist() == ["egg.ply", "torus.obj"]
            assert stored["scores"].shape == (2, 2)
            np.testing.assert_allclose(np.diag(stored["scores"]), 1)

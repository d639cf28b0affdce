"""Uploads survive dropped connections, damaged pieces, and the end of the process that began them."""

from __future__ import annotations

from http.server import BaseHTTPRequestHandler
from pathlib import Path

import pytest

from shapery_client import ApiError, Client, ConnectionFailed
from shapery_client._uploads import UploadJournal
from tests.unit.client.conftest import ASSET, FlakyServer, answer, drop, problem


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "t1c.nii.gz"
    path.write_bytes(bytes(range(256)) * 100)
    return path


def test_a_file_arrives_whole_in_pieces(client: Client, server: FlakyServer, file: Path) -> None:
    seen: list[tuple[int, int]] = []
    asset = client.upload(file, chunk_size=1000, progress=lambda done, size: seen.append((done, size)))
    assert asset.id == ASSET
    assert bytes(server.received) == file.read_bytes()
    assert seen[0] == (0, 25600)
    assert seen[-1] == (25600, 25600)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)


def test_an_empty_file_is_sent_too(client: Client, server: FlakyServer, tmp_path: Path) -> None:
    path = tmp_path / "empty"
    path.touch()
    assert client.upload(path).size == 0
    assert server.length == 0


def test_a_dropped_connection_resumes_where_the_server_stopped(client: Client, server: FlakyServer, file: Path) -> None:
    def half_arrives(handler: BaseHTTPRequestHandler, body: bytes) -> bool:
        server.received += body[: len(body) // 2]
        drop(handler)
        return True

    server.faults = [half_arrives, half_arrives]
    client.upload(file, chunk_size=4096)
    assert bytes(server.received) == file.read_bytes()
    assert server.uploads_made == 1


def test_a_piece_damaged_on_the_way_is_sent_again(client: Client, server: FlakyServer, file: Path) -> None:
    def damaged(handler: BaseHTTPRequestHandler, body: bytes) -> bool:
        problem(handler, 460, "checksum_mismatch")
        return True

    server.faults = [damaged]
    client.upload(file, chunk_size=9999)
    assert bytes(server.received) == file.read_bytes()


def test_another_process_goes_on_with_an_upload_that_was_cut_off(
    client: Client, server: FlakyServer, file: Path, tmp_path: Path
) -> None:
    def away(handler: BaseHTTPRequestHandler, body: bytes) -> bool:
        drop(handler)
        return True

    server.faults = [lambda handler, body: False, *[away] * 20]
    with pytest.raises(ConnectionFailed, match="does not answer"):
        client.upload(file, chunk_size=10000)
    assert len(server.received) == 10000

    server.faults.clear()
    with Client(server.address, journal=UploadJournal(tmp_path / "journal.json")) as another:
        another.upload(file, chunk_size=10000)
    assert bytes(server.received) == file.read_bytes()
    assert server.uploads_made == 1
    assert (tmp_path / "journal.json").read_text() == "{}"


def test_a_file_that_changed_is_sent_anew(client: Client, server: FlakyServer, file: Path) -> None:
    server.faults = [lambda handler, body: (drop(handler), True)[1]] * 20
    with pytest.raises(ConnectionFailed):
        client.upload(file)
    server.faults.clear()
    file.write_bytes(b"something else entirely")
    client.upload(file)
    assert bytes(server.received) == b"something else entirely"
    assert server.uploads_made == 2


def test_an_upload_the_server_forgot_begins_anew(client: Client, server: FlakyServer, file: Path) -> None:
    server.faults = [lambda handler, body: (drop(handler), True)[1]] * 20
    with pytest.raises(ConnectionFailed):
        client.upload(file)
    server.faults.clear()
    server.known = False
    client.upload(file)
    assert bytes(server.received) == file.read_bytes()
    assert server.uploads_made == 2


def test_a_refused_file_is_an_error_with_its_code_and_is_forgotten(
    client: Client, server: FlakyServer, file: Path, tmp_path: Path
) -> None:
    def refuse(handler: BaseHTTPRequestHandler, body: bytes) -> bool:
        problem(handler, 422, "unknown_format")
        return True

    server.faults = [refuse]
    with pytest.raises(ApiError) as caught:
        client.upload(file)
    assert caught.value.code == "unknown_format"
    assert (tmp_path / "journal.json").read_text() == "{}"


def test_an_upload_that_had_finished_is_not_sent_again(client: Client, server: FlakyServer, file: Path) -> None:
    def answer_is_lost(handler: BaseHTTPRequestHandler, body: bytes) -> bool:
        server.received += body
        drop(handler)
        return True

    server.faults = [answer_is_lost]
    client.upload(file)
    assert [method for method, _, _ in server.requests].count("PATCH") == 1


def test_a_cut_journal_does_no_harm(client: Client, server: FlakyServer, file: Path, tmp_path: Path) -> None:
    (tmp_path / "journal.json").write_text('{"http://…')
    client.upload(file)
    assert bytes(server.received) == file.read_bytes()


def test_a_server_without_an_asset_is_not_believed(client: Client, server: FlakyServer, file: Path) -> None:
    def no_asset(handler: BaseHTTPRequestHandler, body: bytes) -> bool:
        answer(handler, 204, Upload_Offset=str(len(body)))
        return True

    server.faults = [no_asset]
    with pytest.raises(Exception, match="names no asset"):
        client.upload(file)

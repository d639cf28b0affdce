"""Assets on both databases."""

from __future__ import annotations

from collections.abc import Callable
from uuid import UUID

import pytest

from shapery_contracts.errors import UserError
from shapery_contracts.formats import AssetKind, FileFormat
from shapery_platform import assets
from shapery_platform.db import Database
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore

MESH = FileFormat(
    kind=AssetKind.MESH,
    format="ply",
    media_type="model/ply",
    extension=".ply",
    details={"vertices": 8, "box": [1.5, 2]},
)


def test_an_asset_is_shown_as_it_was_found(database: Database, local_store: ObjectStore, settings: Settings) -> None:
    blob = local_store.put_bytes(b"ply")
    with database.session() as session:
        made = assets.create_from_upload(
            session, local_store, settings, "ann", blob.sha256, blob.size, "C:\\scans\\vase.ply", MESH
        )
    with database.session(readonly=True) as session:
        view = assets.view(assets.get(session, "ann", made.id))
    assert (view.sha256, view.size, view.filename) == (blob.sha256, 3, "vase.ply")
    assert (view.kind, view.format, view.media_type) == (AssetKind.MESH, "ply", "model/ply")
    assert view.details == {"vertices": 8, "box": [1.5, 2]}
    assert view.content_url == f"/v1/assets/{made.id}/content"


def test_what_the_content_is_decides_and_not_the_name(
    database: Database, local_store: ObjectStore, settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = []

    def sniff(stream: object, size: int) -> FileFormat:
        read.append(stream.read(size))  # type: ignore[attr-defined]
        return MESH

    monkeypatch.setattr(assets, "sniff", sniff)
    blob = local_store.put_bytes(b"solid")
    with database.session() as session:
        made = assets.create_from_upload(session, local_store, settings, "ann", blob.sha256, blob.size, "head.nii.gz")
    assert read == [b"solid"]
    assert (made.kind, made.extension, made.filename) == ("mesh", ".ply", "head.nii.gz")


def test_pages_and_kinds(database: Database, new_asset: Callable[..., UUID]) -> None:
    volumes = [new_asset(data=b"%d" % number) for number in range(5)]
    mesh = new_asset(data=b"mesh", found=MESH)
    new_asset("bob")
    seen: list[UUID] = []
    cursor: str | None = None
    while True:
        with database.session(readonly=True) as session:
            page, cursor = assets.list_assets(session, "ann", cursor, 2)
        seen += [asset.id for asset in page]
        if cursor is None:
            break
    assert seen == [mesh, *volumes[::-1]]
    with database.session() as session:
        assets.delete(session, "ann", volumes[0])
        assert [asset.id for asset in assets.list_assets(session, "ann", kind=AssetKind.MESH)[0]] == [mesh]
        assert len(assets.list_assets(session, "ann", kind=AssetKind.VOLUME)[0]) == 4
        with pytest.raises(UserError) as error:
            assets.delete(session, "ann", volumes[0])
        assert error.value.code == "not_found"


def test_a_name_that_says_nothing_is_replaced(database: Database, local_store: ObjectStore, settings: Settings) -> None:
    blob = local_store.put_bytes(b"ply")
    with database.session() as session:
        made = assets.create_from_upload(session, local_store, settings, "ann", blob.sha256, blob.size, "../..", MESH)
    assert made.filename == "mesh.ply"

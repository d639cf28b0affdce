"""Text, cursors and file names that both databases and browsers can hold."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shapery_contracts.errors import UserError
from shapery_platform.assets import clean_filename
from shapery_platform.db import new_id
from shapery_platform.db.models import Asset
from shapery_platform.db.text import canonical_json, storable
from shapery_platform.paging import Sort, checked_limit, cut_page, parse_sort


@given(st.text(alphabet=st.characters(codec=None)), st.none() | st.integers(1, 50))
def test_storable_text_has_nothing_that_postgresql_refuses(text: str, limit: int | None) -> None:
    stored = storable(text, limit)
    assert "\0" not in stored
    stored.encode()
    assert limit is None or len(stored) <= limit


@given(st.text(max_size=40, alphabet=st.characters(codec="utf-8", exclude_characters="\0")))
def test_sound_text_stays_as_it_is(text: str) -> None:
    assert storable(text, 40) == text


@given(st.text(alphabet=st.characters(codec=None)))
def test_file_names_are_one_component_without_control_characters(name: str) -> None:
    cleaned = clean_filename(name)
    assert not set(cleaned) & set("/\\\0\r\n")
    assert cleaned not in (".", "..")
    assert len(cleaned) <= 255
    cleaned.encode()
    assert clean_filename(cleaned) == cleaned


@pytest.mark.parametrize(
    ("name", "cleaned"),
    [
        ("C:\\scans\\head.nii.gz", "head.nii.gz"),
        ("/etc/passwd", "passwd"),
        ("../../x.ply", "x.ply"),
        ("a\r\nSet-Cookie: x", "aSet-Cookie: x"),
        ("Gefäß 1.ply", "Gefäß 1.ply"),
        ("..", ""),
        ("", ""),
    ],
)
def test_file_names(name: str, cleaned: str) -> None:
    assert clean_filename(name) == cleaned


def test_a_long_file_name_keeps_its_extension() -> None:
    assert clean_filename("x" * 400 + ".nii.gz").endswith("x.nii.gz")


def test_equal_values_have_equal_json() -> None:
    assert canonical_json({"b": [1.5, None], "a": "ä"}) == canonical_json({"a": "ä", "b": [1.5, None]})
    with pytest.raises(ValueError, match="JSON"):
        canonical_json([float("nan")])


BY_NAME = {"name": Asset.filename}


def test_pages_are_cut_and_name_the_next() -> None:
    rows = [SimpleNamespace(id=new_id()) for _ in range(4)]
    assert cut_page(rows, 4, Sort()) == (rows, None)
    page, cursor = cut_page(rows, 3, Sort())
    assert page == rows[:3]
    assert parse_sort(cursor) == Sort(after=rows[2].id)
    assert cut_page([], 3, Sort()) == ([], None)


@pytest.mark.parametrize("order", ["name", "-name"])
def test_cursors_hold_the_value_that_rows_are_ordered_by(order: str) -> None:
    rows = [SimpleNamespace(id=new_id(), filename=name) for name in ("a", "Gefäß 1", "x" * 255, "z")]
    sort = parse_sort(None, order, BY_NAME)
    for count in (1, 2, 3):
        page, cursor = cut_page(rows, count, sort, BY_NAME)
        assert page == rows[:count]
        assert parse_sort(cursor, order, BY_NAME).after == (rows[count - 1].filename, rows[count - 1].id)
    with pytest.raises(UserError, match="order"):
        parse_sort(cursor, "name" if order == "-name" else "-name", BY_NAME)
    with pytest.raises(UserError, match="order"):
        parse_sort(cursor)


@pytest.mark.parametrize("cursor", ["", "x", "0" * 31, "../../x", "\0", "é", "W10=", "e30=", "WyJuYW1lIiwxLCIiXQ=="])
@pytest.mark.parametrize("order", ["created", "name"])
def test_cursors_of_others_are_refused(cursor: str, order: str) -> None:
    with pytest.raises(UserError) as error:
        parse_sort(cursor, order, BY_NAME)
    assert error.value.code == "validation_failed"


def test_limits_of_pages() -> None:
    assert [checked_limit(limit) for limit in (-1, 0, 1, 500, 501)] == [1, 1, 1, 500, 500]
    assert parse_sort(None) == Sort()

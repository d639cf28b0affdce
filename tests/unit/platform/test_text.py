"""Text, cursors and file names that both databases and browsers can hold."""

from __future__ import annotations

from uuid import UUID

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shapery_contracts.errors import UserError
from shapery_platform.assets import clean_filename
from shapery_platform.db import new_id
from shapery_platform.db.text import canonical_json, storable
from shapery_platform.paging import checked_limit, cut_page, parse_cursor


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


def test_pages_are_cut_and_name_the_next() -> None:
    rows = [new_id() for _ in range(4)]
    assert cut_page(rows, 4, lambda row: row) == (rows, None)
    page, cursor = cut_page(rows, 3, lambda row: row)
    assert page == rows[:3]
    assert parse_cursor(cursor) == rows[2]
    assert cut_page([], 3, lambda row: row) == ([], None)


@pytest.mark.parametrize("cursor", ["", "x", "0" * 31, "../../x", "\0"])
def test_cursors_of_others_are_refused(cursor: str) -> None:
    with pytest.raises(UserError) as error:
        parse_cursor(cursor)
    assert error.value.code == "validation_failed"


def test_limits_of_pages() -> None:
    assert [checked_limit(limit) for limit in (-1, 0, 1, 500, 501)] == [1, 1, 1, 500, 500]
    assert parse_cursor(None) is None
    assert isinstance(parse_cursor(str(new_id())), UUID)

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shapery_contracts.errors import UserError
from shapery_gateway.http.storable import MAX_DEPTH, refuse_unstorable

JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(min_codepoint=1, exclude_categories=["Cs"])),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.text(st.characters(min_codepoint=1, exclude_categories=["Cs"]), max_size=3), inner, max_size=3
        )
    ),
    max_leaves=8,
)


@given(JSON)
def test_plain_json_passes(value: object) -> None:
    refuse_unstorable(value, "It")


@pytest.mark.parametrize(
    "value",
    ["a\0", {"a\0": 1}, {"a": ["\ud800"]}, [float("nan")], {"x": {"y": float("inf")}}, (1, "\udfff")],
)
def test_refused(value: object) -> None:
    with pytest.raises(UserError) as caught:
        refuse_unstorable(value, "It")
    assert caught.value.code == "validation_failed"


def test_depth() -> None:
    refuse_unstorable(json.loads("[" * MAX_DEPTH + "]" * MAX_DEPTH), "It")
    with pytest.raises(UserError, match="deeper"):
        refuse_unstorable(json.loads("[" * 900 + "]" * 900), "It")

"""What a handler's process writes down about its end."""

from __future__ import annotations

from pathlib import Path

import pytest

from shapery_worker import outcome
from shapery_worker.outcome import Broken, Failed, Stopped, Succeeded, read_outcome, write_outcome


@pytest.mark.parametrize(
    "ended",
    [
        Succeeded(result={"a": [1, 2.5, None], "ü": "\x00"}),
        Failed(code="no_object_found", message="0 of 3", hint="Send more."),
        Stopped(),
        Broken(reason="it raised"),
    ],
)
def test_an_outcome_is_read_as_it_was_written(tmp_path: Path, ended: outcome.Outcome) -> None:
    write_outcome(tmp_path / "outcome.json", ended)
    assert read_outcome(tmp_path / "outcome.json") == ended
    assert [path.name for path in tmp_path.iterdir()] == ["outcome.json"]


def test_a_result_has_a_largest_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outcome, "MAX_OUTCOME_BYTES", 100)
    with pytest.raises(ValueError, match="more than 100"):
        write_outcome(tmp_path / "outcome.json", Succeeded(result={"long": "x" * 100}))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["", "{", '{"type": "unknown"}', '{"type": "stopped", "more": 1}', "[]"])
def test_what_is_no_outcome_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "outcome.json").write_text(text)
    with pytest.raises(ValueError, match="validation error"):
        read_outcome(tmp_path / "outcome.json")

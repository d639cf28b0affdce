"""Which handlers a worker has."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from typing import Any

import pytest
from pydantic import BaseModel

from shapery_contracts.errors import InvalidInput
from shapery_contracts.kinds import JOB_KINDS, JobKind
from shapery_worker import handlers


class Nothing(BaseModel):
    """No parameters and no result."""


class Installed:
    """A handler that an entry point names."""

    kind = "kind-a"

    def run(self, *_: Any) -> Nothing:
        """Do nothing."""
        return Nothing()


class Misnamed(Installed):
    """A handler under another's name."""

    kind = "kind-x"


@pytest.fixture(autouse=True)
def kinds(monkeypatch: pytest.MonkeyPatch) -> None:
    made = {
        name: JobKind(name=name, service=service, summary="", inputs={}, params=Nothing, result=Nothing)
        for name, service in (("kind-a", "one"), ("kind-b", "one"), ("kind-c", "two"))
    }
    for name, kind in made.items():
        monkeypatch.setitem(JOB_KINDS, name, kind)
    monkeypatch.setattr(handlers, "_registered", {})


def offer(monkeypatch: pytest.MonkeyPatch, **points: str) -> None:
    found = [EntryPoint(name.replace("_", "-"), value, "shapery.jobs") for name, value in points.items()]
    monkeypatch.setattr(handlers, "entry_points", lambda group: [p for p in found if p.group == group])


def test_only_those_of_the_service_are_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    here = f"{__name__}:Installed"
    monkeypatch.setitem(__import__("sys").modules, __name__, __import__("types").SimpleNamespace(Installed=Installed))
    offer(monkeypatch, kind_a=here, kind_c="not.there:Handler")
    assert list(handlers.load_handlers("one")) == ["kind-a"]
    assert handlers.installed_kinds("one") == ["kind-a"]
    assert handlers.installed_kinds("two") == ["kind-c"]
    assert handlers.installed_kinds("three") == []


def test_one_that_cannot_be_loaded_does_not_hinder_the_others(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    module = __import__("types").SimpleNamespace(Installed=Installed, Misnamed=Misnamed)
    monkeypatch.setitem(__import__("sys").modules, "installed_handlers", module)
    offer(monkeypatch, kind_a="installed_handlers:Installed", kind_b="installed_handlers:Misnamed", kind_z="x:Y")
    assert list(handlers.load_handlers("one")) == ["kind-a"]
    assert "calls itself kind-x, not kind-b" in caplog.text
    assert "kind-z" in caplog.text
    offer(monkeypatch, kind_a="not.there:Handler")
    assert handlers.load_handlers("one") == {}
    assert "cannot be loaded" in caplog.text


def test_a_handler_loads_what_it_needs_before_any_job() -> None:
    loaded = []

    class Loading(Installed):
        def load(self) -> None:
            loaded.append(self.kind)

    handlers.register_handler(Loading())
    handlers.load_handlers("two")
    assert loaded == []
    handlers.load_handlers("one")
    assert loaded == ["kind-a"]


def test_a_plugin_goes_before_what_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    offer(monkeypatch, kind_a="not.there:Handler")
    mine = Installed()
    handlers.register_handler(mine)
    handlers.register_handler(mine)
    assert handlers.load_handlers("one") == {"kind-a": mine}
    with pytest.raises(ValueError, match="two handlers"):
        handlers.register_handler(Installed())
    with pytest.raises(InvalidInput, match="no job kind 'kind-x'"):
        handlers.register_handler(Misnamed())

"""Which handlers a worker has: those of the installed services, and those of plugins."""

from __future__ import annotations

import logging
from importlib.metadata import entry_points

from shapery_contracts.handler import AnyHandler
from shapery_contracts.kinds import JOB_KINDS, get_kind

ENTRY_POINT_GROUP = "shapery.jobs"
"""Each entry point is named like its job kind and loads to a handler, or to a class or function that makes one."""

logger = logging.getLogger(__name__)

_registered: dict[str, AnyHandler] = {}


def register_handler(handler: AnyHandler) -> None:
    """Add the handler of a plugin; it goes before an installed one of the same kind.

    Raises
    ------
    UserError
        ``unknown_job_kind``: the kind must be registered first (`shapery_contracts.kinds.register_kind`).
    ValueError
        Another handler was registered for the kind.
    """
    get_kind(handler.kind)
    if handler.kind in _registered and _registered[handler.kind] is not handler:
        raise ValueError(f"two handlers are registered for the job kind {handler.kind!r}")
    _registered[handler.kind] = handler


def load_handlers(service: str) -> dict[str, AnyHandler]:
    """Load the handlers of all kinds of `service`, with everything that they import.

    A handler may have a method ``load()``, which imports what its ``run`` needs: it is called here, before processes
    are forked to run jobs, so that no job has to load it again. It must not start threads.

    A handler that cannot be loaded is left out and logged: the other kinds of the service go on.

    Returns
    -------
    The handlers by kind; empty when the service is not installed here.
    """
    handlers: dict[str, AnyHandler] = {}
    for point in entry_points(group=ENTRY_POINT_GROUP):
        kind = JOB_KINDS.get(point.name)
        if kind is None:
            logger.error("entry point %s of %s names no known job kind", point.name, point.value)
            continue
        if kind.service != service or point.name in _registered:
            continue
        try:
            loaded = point.load()
            handler = loaded if hasattr(loaded, "run") and not isinstance(loaded, type) else loaded()
            _prepare(handler)
        except Exception:
            logger.exception("the handler of %s (%s) cannot be loaded", point.name, point.value)
            continue
        if handler.kind != point.name:
            logger.error("the handler %s calls itself %s, not %s", point.value, handler.kind, point.name)
            continue
        handlers[point.name] = handler
    for name, handler in _registered.items():
        if JOB_KINDS[name].service == service:
            _prepare(handler)
            handlers[name] = handler
    return handlers


def _prepare(handler: AnyHandler) -> None:
    load = getattr(handler, "load", None)
    if load is not None:
        load()


def installed_kinds(service: str) -> list[str]:
    """Return the kinds of `service` that may be served here, without loading any handler."""
    names = {point.name for point in entry_points(group=ENTRY_POINT_GROUP)} | set(_registered)
    return sorted(name for name in names if name in JOB_KINDS and JOB_KINDS[name].service == service)

"""Whether a worker, or the reaper, on this machine does its work: for the health checks of containers."""

from __future__ import annotations

import socket
import time

import redis
from sqlalchemy.exc import SQLAlchemyError

from shapery_contracts.errors import ShaperyError
from shapery_platform import queue, workers
from shapery_platform.db import Database
from shapery_platform.settings import Settings
from shapery_worker.reaper import ALIVE_WITHIN, alive_file


def check_health(settings: Settings, service: str | None, *, reaper: bool = False) -> list[str]:
    """Return what is wrong, a sentence each; nothing when all is well.

    Parameters
    ----------
    settings
        Database and queue to ask.
    service
        The service whose worker must be alive on this machine; None: only database and queue are asked.
    reaper
        Whether a reaper must be alive on this machine.
    """
    faults: list[str] = []
    try:
        queue.ping(settings)
    except (redis.RedisError, OSError) as error:
        faults.append(f"Redis does not answer: {error}.")
    database = Database(settings.database_url, pool_size=1)
    try:
        with database.session(readonly=True) as session:
            here = socket.gethostname()
            alive = {worker.service for worker in workers.live(session, settings) if worker.host == here}
        if service is not None and service not in alive:
            faults.append(
                f"No worker of {service} on {here} has said within {settings.lease_seconds:g} s that it lives."
            )
    except (SQLAlchemyError, ShaperyError) as error:
        faults.append(f"The database does not answer: {error}.")
    finally:
        database.engine.dispose()
    if reaper:
        try:
            age = time.time() - alive_file(settings).stat().st_mtime
        except FileNotFoundError:
            faults.append("No reaper has completed a turn here.")
        else:
            if age > max(ALIVE_WITHIN, 3 * settings.reaper_interval):
                faults.append(f"The reaper has completed no turn for {age:.0f} s.")
    return faults

"""``python -m shapery_platform migrate``: bring the database to the newest version, before a new release starts."""

from __future__ import annotations

import argparse
import sys

from shapery_contracts.errors import ShaperyError
from shapery_platform.db import Database
from shapery_platform.settings import load_settings


def main() -> int:
    """Run a command; returns its exit code."""
    parser = argparse.ArgumentParser(prog="python -m shapery_platform", description=__doc__)
    parser.add_argument("command", choices=["migrate"], help="what to do")
    parser.parse_args()
    try:
        database = Database(load_settings().database_url)
    except ShaperyError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    try:
        database.migrate()
    finally:
        database.engine.dispose()
    return 0


if __name__ == "__main__":
    sys.exit(main())

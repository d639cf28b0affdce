"""``python -m shapery_gateway``: serve what the environment (``SHAPERY_*``) describes."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from shapery_gateway.server import run
from shapery_platform.settings import SettingsError, load_settings


def main() -> int:
    """Parse the few options that the environment has no name for, and serve."""
    parser = argparse.ArgumentParser(prog="python -m shapery_gateway", description=__doc__)
    parser.add_argument("--host", help="address to listen on (SHAPERY_HOST)")
    parser.add_argument("--port", type=int, help="port to listen on, 0 for a free one (SHAPERY_PORT)")
    parser.add_argument("--unix", type=Path, metavar="PATH", help="listen on this Unix socket instead")
    parser.add_argument("--migrate", action="store_true", help="bring the database to the newest version first")
    options = parser.parse_args()
    overrides = {name: value for name in ("host", "port") if (value := getattr(options, name)) is not None}
    try:
        settings = load_settings(**overrides)
    except SettingsError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    # Loaded now that the settings are known to be right: what is wrong with them is said at once.

    run(settings, unix_socket=options.unix, migrate=options.migrate)
    return 0


if __name__ == "__main__":
    sys.exit(main())

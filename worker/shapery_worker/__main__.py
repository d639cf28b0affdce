"""``python -m shapery_worker`` is the command ``shapery-worker``."""

import sys

from shapery_worker.cli import main

sys.exit(main())

"""``python -m shapery_client`` is the ``shapery`` command."""

from shapery_client.cli import main

main()

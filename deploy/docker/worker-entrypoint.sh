#!/bin/sh
# Start a worker command with the compiled kernels where numba may write beside them.
set -eu
if [ ! -d "$NUMBA_CACHE_DIR" ]; then
    cp -R /opt/kernels "$NUMBA_CACHE_DIR"
fi
if [ "${1:-run}" = run ]; then
    shift || true
    set -- run --service "$SHAPERY_SERVICE" "$@"
fi
exec shapery-worker "$@"

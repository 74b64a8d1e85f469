#!/bin/sh
# Creates the virtual environment in FOLDER with the Python named PYTHON, without any package yet.
# Usage: scripts/create_venv.sh PYTHON FOLDER
set -eu

python=$1
folder=$2

fail() {
    printf 'Tril: %s\n' "$*" >&2
    exit 1
}

command -v "$python" >/dev/null 2>&1 || fail "there is no '$python' on the PATH." \
    "Install Python 3.11 or newer, or name one: make run PYTHON=/path/to/python3"
version=$("$python" -c 'import sys; print(".".join(map(str, sys.version_info[:3])))') ||
    fail "'$python' does not start. Name another Python: make run PYTHON=/path/to/python3"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    fail "Python 3.11 or newer is needed, but '$python' is $version." \
        "Install a newer one, or name it: make run PYTHON=python3.12"
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
    fail "'$python' ($version) cannot make virtual environments." \
        "Install its venv module (on Debian and Ubuntu: apt-get install python3-venv)"

printf 'Making a virtual environment in %s with Python %s\n' "$folder" "$version"
"$python" -m venv --clear "$folder"

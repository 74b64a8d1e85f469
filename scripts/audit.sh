#!/bin/sh
# Look for known vulnerabilities of the pinned packages: audit.sh PIP_AUDIT NPM
# Exits with 1 if there are any, with 2 if there are none known but somebody could not be asked.
pip_audit=$1
npm=$2
found=0
unasked=0
limit=${TRIL_AUDIT_TIMEOUT_S:-300}
answer=$(mktemp)
trap 'rm -f "$answer"' EXIT

verdict() { # NAME EXIT_STATUS PATTERN_OF_A_REPORT WHAT_TO_DO
    if ! grep -q "$3" "$answer"; then
        echo "audit: $1 could not be asked. $4"
        unasked=1
    elif [ "$2" -ne 0 ]; then
        echo "audit: $1 knows vulnerabilities:"
        cat "$answer"
        found=1
    else
        echo "audit: $1 knows no vulnerabilities."
    fi
}

echo "audit: Python packages of constraints.txt"
: > "$answer"
timeout "$limit" "$pip_audit" --no-deps --disable-pip --progress-spinner off -f json \
    -r constraints.txt > "$answer"
verdict pip-audit $? '"dependencies"' \
    "Install it (pip install pip-audit, in an environment of its own) and name it with \
PIP_AUDIT=…; it asks a service on the Internet."

echo "audit: the page's packages"
: > "$answer"
# shellcheck disable=SC2086  # a program and its arguments
(cd frontend && timeout "$limit" $npm audit --json) > "$answer"
verdict "npm audit" $? '"vulnerabilities"' "It asks npm's registry on the Internet."

[ "$found" -eq 0 ] || exit 1
[ "$unasked" -eq 0 ] || exit 2

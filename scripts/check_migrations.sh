#!/bin/sh
# Migrates an empty SQLite database to the newest version, then fails if the models say otherwise.
# Usage: scripts/check_migrations.sh ALEMBIC
set -eu

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export TRIL_DATA="$folder" TRIL_DATABASE_URL=""

"$1" upgrade head
"$1" check

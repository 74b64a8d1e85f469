#!/bin/sh
# Run tests, then run those that failed once more, alone: run_tests.sh PYTHON PYTEST_ARGUMENT...
# Exits with 0 if they passed then. The closing lines name them: PASSED failed beside others only.
python=$1
shift

"$python" -m pytest "$@"
status=$?
# Other numbers: interrupted, a wrong argument, no test.
[ "$status" -eq 1 ] || exit "$status"

printf '\n=== Tests failed beside others. Once more, alone: PASSED is flaky, FAILED is broken.\n'
exec "$python" -m pytest "$@" -r pfE --last-failed --last-failed-no-failures none --numprocesses 0

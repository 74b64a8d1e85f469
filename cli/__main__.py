"""Runs the ``tril`` command: ``python -m cli``, as supervised processes are started."""

from cli.supervision.orphans import exit_with_parent

if __name__ == "__main__":
    # Before the imports that take seconds: a parent killed meanwhile is noticed.
    exit_with_parent()
    from cli.main import app

    app()

"""Entry point of ``python -m cli``, the command line of supervised processes."""

from cli.supervision.orphans import exit_with_parent

if __name__ == "__main__":
    # Before the slow imports, to notice a parent killed meanwhile.
    exit_with_parent()
    from cli.main import run

    run()

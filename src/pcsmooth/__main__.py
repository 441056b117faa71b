"""Run the command line as ``python -m pcsmooth``."""

from pcsmooth.cli.main import run

if __name__ == "__main__":
    run()

"""`python -m stribeck` is the command line."""

import sys


def main() -> None:
    """Load the command line and run it; Ctrl-C in between is no traceback either."""
    try:
        from .cli import main as command_line  # noqa: PLC0415 - loading takes a moment
    except KeyboardInterrupt:
        sys.exit(130)
    command_line()


if __name__ == "__main__":
    main()

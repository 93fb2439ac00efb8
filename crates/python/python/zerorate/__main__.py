"""The command ``zerorate``."""

import signal
import sys

from zerorate import _zerorate


def main() -> int:
    """Runs the command that was typed and gives its exit code."""
    # Python's own handler would wait for the interpreter, which is not at work meanwhile; the command has one of its own.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _zerorate.command(["zerorate", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

"""The command line, for the program `mitlplan` and for ``python -m mitlplan``.

Signals come first: the libraries of the command line take a while to load, and Ctrl-C has its answer then.
"""

import signal

from mitlplan.cli_signals import listen


def main() -> None:
    """Run the command line; never returns."""
    listen()
    from mitlplan.cli import main as run

    try:
        run()
    finally:
        # All is said. What is left is Python's own end, which would take an interrupt for a crash.
        signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    main()

"""The command line, for the program `mitlplan` and for ``python -m mitlplan``.

Signals come first: the libraries of the command line take a while to load, and Ctrl-C has its answer then.
When all is said the process ends, without the fifth of a second that Python takes to put every library away,
in which a limit would pass and an interrupt would look like a crash.
"""

import atexit
import os
import sys
from contextlib import suppress

from mitlplan.cli_signals import listen


def main() -> None:
    """Run the command line; never returns."""
    listen()
    code = 1  # as Python after an error that nobody has reported

    def end() -> None:
        for stream in (sys.stdout, sys.stderr):
            # Nobody may be left to read it.
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(code)

    # Registered before any library is loaded, so that it comes after whatever they want to do at the end.
    atexit.register(end)
    from mitlplan.cli import main as run

    try:
        run()
    except SystemExit as answer:
        if isinstance(answer.code, int):
            code = answer.code
        raise


if __name__ == "__main__":
    main()

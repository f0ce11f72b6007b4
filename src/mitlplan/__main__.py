"""``python -m mitlplan``: the command line."""

from mitlplan.cli import main

if __name__ == "__main__":
    main()

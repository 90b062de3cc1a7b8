"""`python -m viewimit` is `viewimit`."""

import sys

from .commands.cli import main

if __name__ == "__main__":
    sys.exit(main())

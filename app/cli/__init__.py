"""Commands of the pages: `viewimit serve`, `lab`, `class`, `exam`, `docs` and `site`."""

import argparse
from typing import Any


def add_repeated(parser: argparse.ArgumentParser, option: str, metavar: str, help: str, **how: Any) -> None:
    """Add an option that may be given more than once. how: as argparse takes it."""
    parser.add_argument(
        option, action="append", default=[], metavar=metavar, help=f"{help}; more than once for more", **how
    )

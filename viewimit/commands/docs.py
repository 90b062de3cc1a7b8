"""viewimit docs: the documentation, as it is built in a clone or published."""

import argparse
import importlib.metadata
import sys
import webbrowser
from pathlib import Path

from . import BadInput
from .options import DONE

PACKAGE = Path(__file__).parents[1]


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--print", action="store_true", dest="only_print", help="only print where it is")


def run(args: argparse.Namespace) -> int:
    built = first_page(PACKAGE.parent)
    where = str(built) if built.is_file() else published()
    if where is None:
        raise BadInput(how_to_build(PACKAGE.parent))
    print(where)
    if not args.only_print and not webbrowser.open(built.as_uri() if built.is_file() else where):
        print("viewimit docs: no browser is found; open that address with one", file=sys.stderr)
    return DONE


def first_page(clone: Path) -> Path:
    """Return where docs/build.py puts the first page of a clone's documentation."""
    return clone / "build" / "site" / "index.html"


def published() -> str | None:
    """Return the public address that the installed package names, if it names one."""
    named = importlib.metadata.metadata("viewimit").get_all("Project-URL") or []
    addresses = dict(one.split(", ", 1) for one in named)
    return addresses.get("Documentation")


def how_to_build(clone: Path) -> str:
    """Return what to run for it."""
    source = clone / "docs" / "build.py"
    if not source.is_file():
        return "an installed package has no documentation; run `python docs/build.py` in a clone of viewimit"
    group = f"{sys.executable} -m pip install --group '{clone / 'pyproject.toml'}:docs'"
    return f"build it first: {group} && {sys.executable} {source}, with pip 25.1 or newer"

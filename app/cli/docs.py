"""viewimit docs: the documentation, as it is built in a clone or published."""

import argparse
import importlib.metadata
import sys
import webbrowser
from pathlib import Path

from viewimit.options import DONE, BadInput

CLONE = Path(__file__).parents[2]
SITE = CLONE / "build" / "site"  # where `viewimit docs` looks for what `viewimit site` wrote


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--print", action="store_true", dest="only_print", help="only print where it is")


def run(args: argparse.Namespace) -> int:
    built = SITE / "docs" / "index.html"
    where = built.as_uri() if built.is_file() else published()
    if where is None:
        raise BadInput(how_to_build(sources() / "build.py", f"viewimit site {SITE}"))
    print(built if built.is_file() else where)
    if not args.only_print and not webbrowser.open(where):
        print("viewimit docs: no browser is found; open that address with one", file=sys.stderr)
    return DONE


def sources() -> Path:
    """Return the folder from which the documentation of a clone is built."""
    return CLONE / "docs"


def published() -> str | None:
    """Return the public address that the installed package names, if it names one."""
    named = importlib.metadata.metadata("viewimit").get_all("Project-URL") or []
    addresses = dict(one.split(", ", 1) for one in named)
    return addresses.get("Documentation")


def how_to_build(build: Path, command: str) -> str:
    """Return what to run for it, of a clone's docs/build.py and the command that calls it."""
    if not build.is_file():
        return f"an installed package has no documentation; run `{command}` in a clone of viewimit"
    group = f"{sys.executable} -m pip install --group '{build.parents[1] / 'pyproject.toml'}:docs'"
    return f"it needs Sphinx: {group} && {command}, with pip 25.1 or newer"

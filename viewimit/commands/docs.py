"""viewimit docs: the documentation, which is part of the wheel."""

import argparse
import sys
import webbrowser
from pathlib import Path

from . import BadInput
from .options import DONE

PACKAGE = Path(__file__).parents[1]
BEGIN = "index.html"


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--print", action="store_true", dest="only_print", help="only print where it is")


def run(args: argparse.Namespace) -> int:
    begin = first_page(PACKAGE)
    print(begin)
    if not args.only_print and not webbrowser.open(begin.as_uri()):
        print("viewimit docs: no browser is found; open that file with one", file=sys.stderr)
    return DONE


def first_page(package: Path) -> Path:
    """Of an installed wheel, or what docs/build.py has made of a clone. Raises BadInput with what makes it."""
    source = package.parent / "docs" / "build.py"
    found = package / "site" / BEGIN if not source.is_file() else package.parent / "build" / "site" / BEGIN
    if found.is_file():
        return found
    if source.is_file():
        python, clone = sys.executable, package.parent
        group = f"{python} -m pip install --group '{clone / 'pyproject.toml'}:docs'"
        raise BadInput(f"not built yet in this clone: {group} && {python} {source}, with pip 25.1 or newer")
    raise BadInput("this installation was made without it; pip install a release of viewimit, or build it in a clone")

"""viewimit site: the lab, the lessons and the documentation as a folder of files, for any web server."""

import argparse
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

from viewimit.options import DONE, BadInput, naming

from .docs import how_to_build, sources

LESSONS, DOCUMENTATION = "learn", "docs"  # folders of the site, beside the lab, which is its first page
UNTOUCHED = ".nojekyll"  # GitHub Pages then leaves names with underscores as they are


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=Path, metavar="DIR", help="a folder that is new or empty")


def run(args: argparse.Namespace) -> int:
    folder: Path = args.folder
    build = sources() / "build.py"
    if not build.is_file() or find_spec("sphinx") is None:
        raise BadInput(how_to_build(build, f"viewimit site {folder}"))
    with naming("DIR"):
        if folder.exists() and any(folder.iterdir()):
            raise BadInput(f"DIR: {folder} is not empty; give a folder that is new or empty")
        write_pages(folder)
        ended = subprocess.run([sys.executable, build, (folder / DOCUMENTATION).resolve()], stdout=subprocess.DEVNULL)
    if ended.returncode:
        raise BadInput(f"the documentation could not be built: {build} says above why")
    print(folder / "index.html")
    return DONE


def write_pages(folder: Path) -> None:
    """Write the lab and the page of all lessons. Raises OSError."""
    from ..lab.lessons.page import lesson_page
    from ..lab.lessons.source import shipped
    from ..lab.page import lab_page
    from ..ways import Ways

    (folder / LESSONS).mkdir(parents=True, exist_ok=True)
    (folder / UNTOUCHED).touch()
    lab, lessons = lab_page(ways=Ways.of_site("")), lesson_page(shipped(), ways=Ways.of_site("../"))
    for path, page in (("index.html", lab), (f"{LESSONS}/index.html", lessons)):
        (folder / path).write_bytes(page.encode())

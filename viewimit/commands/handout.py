"""viewimit handout: a lesson as pages to print."""

import argparse
import sys
from pathlib import Path

from . import BadInput
from .options import DONE, naming

PDF_ADVICE = "PDF needs fpdf2: pip install 'viewimit[pdf]', or write .html and print it from a browser"


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--lesson",
        metavar="NAME",
        default="tour",
        help="a name (ray, tour, limits, jacobian, motion, sign) or the path of a .toml file (tour)",
    )
    parser.add_argument("--solutions", action="store_true", help="with answers and revealed pictures, for the lecturer")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write it there, .html or .pdf (LESSON-handout.html)")


def run(args: argparse.Namespace) -> int:
    from ..app.lab.lessons.handout import handout
    from ..app.lab.lessons.source import find

    with naming("--lesson"):
        name, lesson = find(args.lesson)
    out = args.out or Path(f"{name}-{'solutions' if args.solutions else 'handout'}.html")
    kind = out.suffix.lower()
    if kind not in (".html", ".htm", ".pdf"):
        raise BadInput(f"--out: {out} must end in .html or .pdf")
    try:
        data = handout(lesson, "pdf" if kind == ".pdf" else "html", args.solutions)
    except ModuleNotFoundError as error:
        if error.name != "fpdf":
            raise
        raise BadInput(f"--out: {out}: {PDF_ADVICE}") from None
    with naming("--out"):
        out.write_bytes(data if isinstance(data, bytes) else data.encode())
    print(f"written to {out}: print it on A4, at 100 %", file=sys.stderr)
    return DONE

"""viewimit exam: the eight questions of the lessons as exam items for a learning platform."""

import argparse
import sys
from pathlib import Path

from viewimit.options import DONE, BadInput, naming

SUFFIXES = {"gift": (".gift", ".txt"), "qti": (".zip",)}


def add_options(parser: argparse.ArgumentParser) -> None:
    kinds = "gift: a text that Moodle imports; qti: a package of IMS QTI 2.1 items (gift)"
    parser.add_argument("--format", choices=list(SUFFIXES), default="gift", help=kinds)
    where = "write it there (viewimit-items.gift, viewimit-items.zip)"
    parser.add_argument("--out", type=Path, metavar="FILE", help=where)


def run(args: argparse.Namespace) -> int:
    from ..lab.lessons.exam import exam_items, gift, qti_package

    suffixes = SUFFIXES[args.format]
    out = args.out or Path(f"viewimit-items{suffixes[0]}")
    if out.suffix.lower() not in suffixes:
        raise BadInput(f"--out: {out} must end in {' or '.join(suffixes)}")
    items = exam_items()
    data = gift(items).encode() if args.format == "gift" else qti_package(items)
    with naming("--out"):
        out.write_bytes(data)
    print(f"written to {out}: {len(items)} items, the replies to each answer as feedback", file=sys.stderr)
    return DONE

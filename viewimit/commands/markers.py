"""viewimit markers: a sheet of square markers to print and cut out, for both arms."""

import argparse
import importlib.util
import sys
from pathlib import Path

from ..drawing.markers import marker_sheet
from ..options import DONE, BadInput, between, naming
from ..sensing.detection import FIRST_OF_DEMONSTRATOR


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out", type=Path, default=Path("markers.html"), metavar="FILE", help="a page to print (%(default)s)"
    )
    parser.add_argument(
        "--aruco", default="4X4_50", metavar="DICT", help="OpenCV's dictionary of markers, as of detect (%(default)s)"
    )
    parser.add_argument(
        "--count", type=between(int, 5, 500), default=20, metavar="N", help="markers on each arm (%(default)s)"
    )
    parser.add_argument(
        "--demonstrator-from",
        type=between(int, 1, 9999),
        default=FIRST_OF_DEMONSTRATOR,
        metavar="N",
        help="number of the demonstrator's first marker; the learner's is 0 (%(default)s)",
    )
    parser.add_argument(
        "--size-mm",
        type=between(float, 10, 120),
        default=40.0,
        metavar="MM",
        help="side of a marker without its white rim: 15 pixels or more of your pictures (%(default)g)",
    )


def run(args: argparse.Namespace) -> int:
    if importlib.util.find_spec("cv2") is None:
        raise BadInput("it needs OpenCV: pip install 'viewimit[opencv]'")
    from ..sensing.detection import Fiducials  # loads OpenCV

    if args.out.suffix.lower() != ".html":
        raise BadInput(f"--out: {args.out} must end in .html: a browser prints it, or saves it as PDF")
    with naming("--aruco"):
        fiducials = Fiducials(args.aruco)
    if args.count > args.demonstrator_from:
        raise BadInput(f"--count: {args.count} of the learner reach the demonstrator's first, {args.demonstrator_from}")
    with naming("--count"):
        fiducials.cells(args.demonstrator_from + args.count - 1, 0)
    with naming("--size-mm"):
        page = marker_sheet(fiducials, args.count, args.demonstrator_from, args.size_mm)
    with naming("--out"):
        args.out.write_text(page, "utf-8")
    print(f"written to {args.out}: print it from a browser on A4, at 100 %", file=sys.stderr)
    return DONE

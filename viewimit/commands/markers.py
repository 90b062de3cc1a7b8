"""viewimit markers: a sheet of square markers to print and cut out, for both arms."""

import argparse
import importlib.util
import sys
from pathlib import Path

from ..sensing.detection import FIRST_OF_DEMONSTRATOR
from . import BadInput
from .handout import PDF_ADVICE
from .options import DONE, between, naming

RIM = 1  # cells of white paper around a marker, which the detector needs
LABEL_MM, GAP_MM, HEAD_MM, RULER_MM = 4.5, 4.0, 36.0, 100.0
BLACK, WHITE, CUT = "#000000", "#ffffff", "#b9bec8"
SMALL, HEADING = 8.5, 13.0  # pt


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out", type=Path, default=Path("markers.pdf"), metavar="FILE", help="write it as .pdf or .html (%(default)s)"
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
    from ..app.lab.lessons.sheet import HtmlCanvas, PdfCanvas
    from ..sensing.detection import Fiducials  # loads OpenCV

    kind = args.out.suffix.lower()
    if kind not in (".pdf", ".html"):
        raise BadInput(f"--out: {args.out} must end in .pdf or .html")
    with naming("--aruco"):
        fiducials = Fiducials(args.aruco)
    if args.count > args.demonstrator_from:
        raise BadInput(f"--count: {args.count} of the learner reach the demonstrator's first, {args.demonstrator_from}")
    with naming("--count"):
        fiducials.cells(args.demonstrator_from + args.count - 1, 0)
    try:
        canvas = PdfCanvas() if kind == ".pdf" else HtmlCanvas()
    except ModuleNotFoundError as error:
        if error.name != "fpdf":
            raise
        raise BadInput(f"--out: {args.out}: {PDF_ADVICE}") from None
    for arm, first in (("learner", 0), ("demonstrator", args.demonstrator_from)):
        _draw_arm(canvas, fiducials, arm, first, args)
    data = canvas.finish(f"Markers {fiducials.name} for two arms · viewimit")
    with naming("--out"):
        args.out.write_bytes(data if isinstance(data, bytes) else data.encode())
    print(f"written to {args.out}: print it on A4, at 100 %", file=sys.stderr)
    return DONE


def _draw_arm(canvas, fiducials, arm: str, first: int, args: argparse.Namespace) -> None:
    """Draw the pages of one arm on a `sheet.Canvas`."""
    from ..app.lab.lessons.sheet import HEIGHT, MARGIN, WIDTH

    cells = fiducials.dictionary.markerSize + 2 * (1 + RIM)
    cell = args.size_mm / (cells - 2 * RIM)
    paper = cells * cell
    columns = int((WIDTH - 2 * MARGIN + GAP_MM) // (paper + GAP_MM))
    rows = int((HEIGHT - MARGIN - HEAD_MM + GAP_MM) // (paper + LABEL_MM + GAP_MM))
    if columns < 1 or rows < 1:
        raise BadInput(f"--size-mm: a marker of {args.size_mm:g} mm does not fit on A4")
    for k in range(args.count):
        row, column = divmod(k % (rows * columns), columns)
        if row == column == 0:
            canvas.page()
            _draw_head(canvas, fiducials.name, arm, args)
        x, y = MARGIN + column * (paper + GAP_MM), HEAD_MM + row * (paper + LABEL_MM + GAP_MM)
        canvas.path(_rectangle(x, y, paper, paper + LABEL_MM), stroke=CUT, closed=True)
        canvas.text((x + 1, y + paper + LABEL_MM - 1.3), f"{first + k}  {arm}", SMALL)
        rim = RIM * cell
        canvas.path(_rectangle(x + rim, y + rim, paper - 2 * rim, paper - 2 * rim), stroke="", fill=BLACK, closed=True)
        for line, white in enumerate(fiducials.cells(first + k, cells)[RIM:-RIM, RIM:-RIM].tolist()):
            for begin, end in _runs(white):
                part = _rectangle(x + rim + begin * cell, y + rim + line * cell, (end - begin) * cell, cell)
                canvas.path(part, stroke="", fill=WHITE, closed=True)


def _draw_head(canvas, dictionary: str, arm: str, args: argparse.Namespace) -> None:
    from ..app.lab.lessons.sheet import MARGIN, WIDTH, write

    n = args.demonstrator_from
    canvas.text((MARGIN, 14.0), f"Markers of the {arm}", HEADING, bold=True)
    advice = (
        f"Print at **100 %** and cut along the grey lines. Stick number 0 on the learner where number {n} is on the "
        f"demonstrator, 1 where {n + 1} is, and so on: on the base and on every link, eight or more in sight of both "
        f"cameras. Keep them flat. Detect them with **--aruco {dictionary}**."
    )
    write(canvas, (MARGIN, 17.0), advice, SMALL, WIDTH - 2 * MARGIN)
    canvas.path([(MARGIN, 33.0), (MARGIN + RULER_MM, 33.0)], stroke=BLACK)
    for end in (MARGIN, MARGIN + RULER_MM):
        canvas.path([(end, 32.0), (end, 34.0)], stroke=BLACK)
    canvas.text((MARGIN + RULER_MM + 2, 34.0), "100 mm, if printed at its size", SMALL)


def _rectangle(x: float, y: float, width: float, height: float) -> list[tuple[float, float]]:
    return [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]


def _runs(white: list[bool]) -> list[tuple[int, int]]:
    """Begin and end of each run of white cells."""
    edges = [k for k, (a, b) in enumerate(zip([False, *white], [*white, False])) if a != b]
    return list(zip(edges[::2], edges[1::2]))

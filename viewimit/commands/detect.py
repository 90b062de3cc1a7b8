"""viewimit detect: marked points in a person's own pictures or videos, as CSV."""

import argparse
import importlib.util
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import VIEW_NAMES, VIEWS, view_of
from ..sensing.tracks import Row, write_tidy
from ..simulation.robot import load_markers, marker_names
from . import BadInput
from .json_output import print_json
from .options import (
    DONE,
    MISSED,
    VIEW_OPTIONS,
    add_json_option,
    add_view_options,
    between,
    naming,
    option,
    require_separate_files,
)

Picture = NDArray[np.uint8]
Point = tuple[str, float, float, float]  # name, x, y [px], confidence
Detector = Callable[[Picture], Iterator[Point]]
CERTAIN = 1.0
NAMED = re.compile(r"(?:^|[^A-Za-z])(?:(?P<body>(?i:demo|own))[_-](?P<side>(?i:left|right))|(?P<view>[lrLR]))$")


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "files",
        nargs="*",
        type=Path,
        metavar="FILE",
        help="videos or pictures whose names end in their view: demo_left.mp4, take2_own_right.png; several pictures "
        "of a view are its frames, in the order given",
    )
    add_view_options(parser, "pictures or videos of {}", nargs="+", default=[])
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="write them as .csv")
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument(
        "--markers",
        default="panda",
        metavar="NAME",
        help=f"whose hues to look for: {', '.join(marker_names())}, or the path of a .toml file (%(default)s)",
    )
    kind.add_argument(
        "--aruco",
        metavar="DICT",
        help="look for square markers instead, of this dictionary of OpenCV's: 4X4_50, APRILTAG_36H11, …; points are "
        "named by their numbers",
    )
    parser.add_argument(
        "--middle",
        type=between(float, 0.05, 1.0),
        default=1.0,
        metavar="SHARE",
        help="of a picture's width that is searched, around its centre (%(default)s)",
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    if importlib.util.find_spec("cv2") is None:
        raise BadInput("it needs OpenCV: pip install 'viewimit[opencv]'")
    if args.out.suffix.lower() != ".csv":
        raise BadInput(f"--out: {args.out}: its name must end in .csv")
    files = _files_by_view(args)
    names, detect = _ball_detector(args) if args.aruco is None else _square_detector(args)
    from ..sensing.detection import read_pictures  # loads OpenCV

    rows: dict[str, list[Row]] = {}
    counts = {}
    sizes: dict[tuple[int, ...], str] = {}  # of pictures, and a view of each
    for view, paths in files.items():
        rows[view], frames = [], 0
        with naming(option(VIEW_NAMES[view])):
            for picture in (picture for path in paths for picture in read_pictures(path)):
                rows[view] += [(frames, *point) for point in detect(picture)]
                frames += 1
                sizes.setdefault(picture.shape[1::-1], VIEW_NAMES[view])
        counts[VIEW_NAMES[view]] = {"frames": frames, "points_a_frame": len(rows[view]) / frames}
    if len(sizes) > 1:
        named = ", ".join(f"{width} x {height} px in {view}" for (width, height), view in sizes.items())
        print(f"viewimit detect: pictures of different sizes, {named}: points are in pixels of each", file=sys.stderr)
    markers = len(names) or len({point for each in rows.values() for _, point, *_ in each})
    with naming("--out"):
        write_tidy(args.out, rows)
    if args.json:
        print_json(args, {"markers": markers, "views": counts, "file": str(args.out)})
    else:
        for name, count in counts.items():
            print(f"{name:<10}  {count['frames']} frames, {count['points_a_frame']:.1f} of {markers} points in each")
        print(f"written to {args.out}")
    empty = [VIEW_NAMES[view] for view in files if not rows[view]]
    if empty:
        kind = args.markers if args.aruco is None else args.aruco
        print(f"viewimit detect: no marker of {kind} in any frame of view {', '.join(empty)}", file=sys.stderr)
    return MISSED if empty else DONE


def _ball_detector(args: argparse.Namespace) -> tuple[list[str], Detector]:
    """Names of all points, and the detector. Raises BadInput."""
    with naming("--markers"):
        hue_deg = load_markers(args.markers).hue_deg
    from ..sensing.detection import detect  # loads OpenCV

    def points(picture: Picture) -> Iterator[Point]:
        balls = detect(picture, hue_deg, args.middle)
        for k in np.flatnonzero(balls.found).tolist():
            yield str(k), float(balls.points[k, 0]), float(balls.points[k, 1]), float(balls.confidence[k])

    return [str(k) for k in range(len(hue_deg))], points


def _square_detector(args: argparse.Namespace) -> tuple[list[str], Detector]:
    """No names, because the pictures tell which numbers there are, and the detector. Raises BadInput."""
    from ..sensing.detection import Fiducials  # loads OpenCV

    with naming("--aruco"):
        fiducials = Fiducials(args.aruco)

    def points(picture: Picture) -> Iterator[Point]:
        first = round((1 - args.middle) / 2 * picture.shape[1])
        for number, (x, y) in sorted(fiducials.detect(picture[:, first : picture.shape[1] - first]).items()):
            yield str(number), float(x) + first, float(y), CERTAIN

    return [], points


def _files_by_view(args: argparse.Namespace) -> dict[str, list[Path]]:
    files: dict[str, list[Path]] = {view: list(vars(args)[VIEW_NAMES[view]]) for view in VIEWS}
    for path in args.files:
        named = NAMED.search(path.stem)
        if not named:
            raise BadInput(f"{path}: its name does not end in a view such as _demo_left; name it by {VIEW_OPTIONS}")
        files[named["view"] or view_of(f"{named['body']}_{named['side']}".lower())].append(path)
    require_separate_files(path for paths in files.values() for path in paths)
    found = {view: paths for view, paths in files.items() if paths}
    if not found:
        raise BadInput(f"no pictures: name files, or give them by {VIEW_OPTIONS}")
    return found

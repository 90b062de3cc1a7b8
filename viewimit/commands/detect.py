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
from ..sensing.detection import FIRST_OF_DEMONSTRATOR, PICTURES
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
VIDEOS = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v")
DEMONSTRATOR_VIEWS = VIEWS[:2]
MAX_NUMBER = 9999  # of a marker
BOTH = re.compile(r"(?:^|[^A-Za-z])(?i:(left|right))$")  # a picture of both arms
NAMED = re.compile(r"(?:^|[^A-Za-z])(?:(?P<body>(?i:demo|own))[_-](?P<side>(?i:left|right))|(?P<view>[lrLR]))$")


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "files",
        nargs="*",
        type=Path,
        metavar="FILE",
        help="videos or pictures whose names end in their view: demo_left.mp4, take2_own_right.png; several pictures "
        "of a view are its frames, in the order given. A name that ends in _left or _right alone shows both arms. A "
        "folder stands for all pictures and videos in it, by name",
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
        "--demonstrator-from",
        type=between(int, 1, MAX_NUMBER),
        default=FIRST_OF_DEMONSTRATOR,
        metavar="N",
        help="in pictures of both arms: the demonstrator wears the markers from this number on, N + k where the "
        "learner wears k (%(default)s)",
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
    files, files_of_both = _files_by_view(args)
    if files_of_both and args.aruco is None:
        raise BadInput(
            f"{files_of_both[0]}: its name does not end in a view such as _demo_left; name it by {VIEW_OPTIONS};"
            " both arms in one picture need markers with numbers: give --aruco"
        )
    names, detect = _ball_detector(args) if args.aruco is None else _square_detector(args)
    from ..sensing.detection import read_pictures  # loads OpenCV

    rows: dict[str, list[Row]] = {}
    counts = {}
    sizes: dict[tuple[int, ...], str] = {}  # of pictures, and a view of each
    for view, paths in files.items():
        rows[view], frames = [], 0
        with naming(option(VIEW_NAMES[view])):
            for path, picture in ((each, picture) for each in paths for picture in read_pictures(each)):
                points = detect(picture)
                if path in files_of_both:
                    points = _of_one_arm(points, args.demonstrator_from, view in DEMONSTRATOR_VIEWS)
                rows[view] += [(frames, *point) for point in points]
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


def _of_one_arm(points: Iterator[Point], first_of_demonstrator: int, is_demonstrator: bool) -> Iterator[Point]:
    """Yield the markers of one arm, numbered as the learner's."""
    for name, x, y, confidence in points:
        number = int(name)
        if (number >= first_of_demonstrator) == is_demonstrator:
            yield str(number - first_of_demonstrator if is_demonstrator else number), x, y, confidence


def _in_folder(path: Path) -> list[Path]:
    """Return the pictures and videos of a folder in the order of their names; or the file itself. Raises BadInput."""
    if not path.is_dir():
        return [path]
    found = sorted(each for each in path.iterdir() if each.suffix.lower() in (*PICTURES, *VIDEOS))
    if not found:
        raise BadInput(f"{path}: no picture or video is in this folder")
    return found


def _files_by_view(args: argparse.Namespace) -> tuple[dict[str, list[Path]], list[Path]]:
    """Return the files of each view, and those that show both arms. Raises BadInput."""
    files: dict[str, list[Path]] = {view: list(vars(args)[VIEW_NAMES[view]]) for view in VIEWS}
    of_both = []
    for path in (each for given in args.files for each in _in_folder(given)):
        named, both = NAMED.search(path.stem), BOTH.search(path.stem)
        if named:
            views = [named["view"] or view_of(f"{named['body']}_{named['side']}".lower())]
        elif both:
            views = [view_of(f"{body}_{both[1].lower()}") for body in ("demo", "own")]
            of_both.append(path)
        else:
            raise BadInput(f"{path}: its name does not end in a view such as _demo_left; name it by {VIEW_OPTIONS}")
        for view in views:
            files[view].append(path)
    require_separate_files(path for paths in files.values() for path in paths)
    found = {view: paths for view, paths in files.items() if paths}
    if not found:
        raise BadInput(f"no pictures: name files, or give them by {VIEW_OPTIONS}")
    return found, of_both

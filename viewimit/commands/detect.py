"""viewimit detect: marked points in a person's own pictures or videos, as CSV."""

import argparse
import importlib.util
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import options
from ..estimation.views import VIEW_NAMES, VIEWS, view_of
from ..sensing.detection import FIRST_OF_DEMONSTRATOR, PICTURES
from ..sensing.tracks import Row, write_tidy
from ..simulation.robot import load_markers, marker_names
from .json_output import print_json

Picture = NDArray[np.uint8]
Point = tuple[str, float, float, float]  # name, x, y [px], confidence
LeftOut = dict[str, str]  # why, by the name of the marker
Detector = Callable[[Picture], tuple[list[Point], LeftOut]]
CERTAIN = 1.0
VIDEOS = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v")
DEMONSTRATOR_VIEWS = VIEWS[:2]
BODIES = {"demonstrator": ("demo_left", "demo_right"), "learner": ("own_left", "own_right")}  # and their views
MAX_NUMBER = 9999  # of a marker
MAX_LINES = 10  # about markers that are left out
TIMES = {2: "twice"}
SAME_RATE = 0.01  # relative, as cameras without a trigger differ by less
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
    options.add_view_options(parser, "pictures or videos of {}", nargs="+", default=[])
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
        type=options.between(int, 1, MAX_NUMBER),
        default=FIRST_OF_DEMONSTRATOR,
        metavar="N",
        help="in pictures of both arms: the demonstrator wears the markers from this number on, N + k where the "
        "learner wears k (%(default)s)",
    )
    parser.add_argument(
        "--middle",
        type=options.between(float, 0.05, 1.0),
        default=1.0,
        metavar="SHARE",
        help="of a picture's width that is searched, around its centre (%(default)s)",
    )
    options.add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    if importlib.util.find_spec("cv2") is None:
        raise options.BadInput("it needs OpenCV: pip install 'viewimit[opencv]'")
    if args.out.suffix.lower() != ".csv":
        raise options.BadInput(f"--out: {args.out}: its name must end in .csv")
    files, files_of_both = _files_by_view(args)
    if files_of_both and args.aruco is None:
        raise options.BadInput(
            f"{files_of_both[0]}: its name does not end in a view such as _demo_left; name it by "
            f"{options.VIEW_OPTIONS}; both arms in one picture need markers with numbers: give --aruco"
        )
    names, detect = _ball_detector(args) if args.aruco is None else _square_detector(args)
    from ..sensing.detection import frame_rate, read_pictures  # loads OpenCV

    rows: dict[str, list[Row]] = {}
    counts: dict[str, dict[str, float]] = {}
    left_out: dict[tuple[str, str], dict[str, list[int]]] = {}  # frames by view, of a marker and a reason
    sizes: dict[tuple[int, ...], str] = {}  # of pictures, and a view of each
    for view, paths in files.items():
        rows[view], frames = [], 0
        with options.naming(options.option(VIEW_NAMES[view])):
            for path, picture in ((each, picture) for each in paths for picture in read_pictures(each)):
                points, without = detect(picture)
                if path in files_of_both:
                    points, without = _of_one_arm(points, without, args.demonstrator_from, view in DEMONSTRATOR_VIEWS)
                rows[view] += [(frames, *point) for point in points]
                for marker in without.items():
                    left_out.setdefault(marker, {}).setdefault(VIEW_NAMES[view], []).append(frames)
                frames += 1
                sizes.setdefault(picture.shape[1::-1], VIEW_NAMES[view])
        counts[VIEW_NAMES[view]] = {"frames": frames, "points_a_frame": len(rows[view]) / frames}
    if len(sizes) > 1:
        named = ", ".join(f"{width} x {height} px in {view}" for (width, height), view in sizes.items())
        print(f"viewimit detect: pictures of different sizes, {named}: points are in pixels of each", file=sys.stderr)
    seen = {point for each in rows.values() for _, point, *_ in each}
    markers = len(names) or len(seen | {name for name, _ in left_out})
    with options.naming("--out"):
        write_tidy(args.out, rows)
    if args.json:
        told = [{"marker": name, "why": why, "frames": frames} for (name, why), frames in left_out.items()]
        print_json(args, {"markers": markers, "views": counts, "left_out": told, "file": str(args.out)})
    else:
        for name, count in counts.items():
            print(f"{name:<10}  {count['frames']} frames, {count['points_a_frame']:.1f} of {markers} points in each")
        print(f"written to {args.out}")
    rates = {VIEW_NAMES[view]: [frame_rate(path) for path in paths] for view, paths in files.items()}
    for said in (*_lengths(counts), *_rates(rates), *_left_out(left_out, counts)):
        print(f"viewimit detect: {said}", file=sys.stderr)
    empty = [VIEW_NAMES[view] for view in files if not rows[view]]
    if empty:
        kind = args.markers if args.aruco is None else args.aruco
        print(f"viewimit detect: no marker of {kind} in any frame of view {', '.join(empty)}", file=sys.stderr)
    return options.MISSED if empty else options.DONE


def _ball_detector(args: argparse.Namespace) -> tuple[list[str], Detector]:
    """Names of all points, and the detector. Raises BadInput."""
    with options.naming("--markers"):
        hue_deg = load_markers(args.markers).hue_deg
    from ..sensing.detection import detect  # loads OpenCV

    def points(picture: Picture) -> tuple[list[Point], LeftOut]:
        balls = detect(picture, hue_deg, args.middle)
        found = np.column_stack([balls.points, balls.confidence])
        seen = [(str(k), *found[k].tolist()) for k in np.flatnonzero(balls.found).tolist()]
        return seen, {str(k): why for k, why in balls.left_out.items()}

    return [str(k) for k in range(len(hue_deg))], points


def _square_detector(args: argparse.Namespace) -> tuple[list[str], Detector]:
    """No names, because the pictures tell which numbers there are, and the detector. Raises BadInput."""
    from ..sensing.detection import Fiducials  # loads OpenCV

    with options.naming("--aruco"):
        fiducials = Fiducials(args.aruco)

    def points(picture: Picture) -> tuple[list[Point], LeftOut]:
        first = round((1 - args.middle) / 2 * picture.shape[1])
        found = sorted(fiducials.detect_all(picture[:, first : picture.shape[1] - first]).items())
        seen = [(str(k), float(at[0][0]) + first, float(at[0][1]), CERTAIN) for k, at in found if len(at) == 1]
        return seen, {str(k): f"it is there {TIMES.get(len(at), f'{len(at)} times')}" for k, at in found if len(at) > 1}

    return [], points


def _of_one_arm(
    points: list[Point], left_out: LeftOut, first_of_demonstrator: int, is_demonstrator: bool
) -> tuple[list[Point], LeftOut]:
    """The markers of one arm, numbered as the learner's."""

    def own(name: str) -> str | None:
        number = int(name)
        if (number >= first_of_demonstrator) != is_demonstrator:
            return None
        return str(number - first_of_demonstrator if is_demonstrator else number)

    kept = [(number, x, y, certain) for name, x, y, certain in points if (number := own(name)) is not None]
    return kept, {number: why for name, why in left_out.items() if (number := own(name)) is not None}


def _lengths(counts: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
    """In a line for each body: its two films differ in length."""
    for body, pair in BODIES.items():
        frames = [counts[view]["frames"] for view in pair if view in counts]
        if len(set(frames)) > 1:
            yield (
                f"the {body} has {frames[0]} frames in {pair[0]} and {frames[1]} in {pair[1]}: if one has lost "
                "a frame, left and right are not of the same moment from then on; cut both to the same moments"
            )


def _rates(rates: Mapping[str, list[float | None]]) -> Iterator[str]:
    """In a line for each body: its films show unlike numbers of frames in a second."""
    for body, pair in BODIES.items():
        known = [[rate for rate in rates.get(view, ()) if rate is not None] for view in pair]
        for left, right in zip(*known):
            if abs(left - right) > SAME_RATE * left:
                unlike = f"{left:.4g} frames a second in {pair[0]} and {right:.4g} in {pair[1]}"
                yield (
                    f"the films of the {body} have {unlike}: frames of one number are not of one moment; convert both "
                    "to one rate"
                )
                break


def _left_out(
    left_out: Mapping[tuple[str, str], Mapping[str, list[int]]], counts: Mapping[str, Mapping[str, float]]
) -> Iterator[str]:
    """In a line for each marker and reason: where it is left out."""
    for (name, why), frames in list(left_out.items())[:MAX_LINES]:
        of = {view: f" ({len(at)} of {counts[view]['frames']} frames)" for view, at in frames.items()}
        where = [view + ("" if counts[view]["frames"] == 1 else words) for view, words in of.items()]
        yield f"marker {name} in {', '.join(where)}: {why}" + ("" if "taken" in why else ", and is left out")
    if len(left_out) > MAX_LINES:
        yield f"and {len(left_out) - MAX_LINES} more such markers"


def _in_folder(path: Path) -> list[Path]:
    """Return the pictures and videos of a folder in the order of their names; or the file itself. Raises BadInput."""
    if not path.is_dir():
        return [path]
    found = sorted(each for each in path.iterdir() if each.suffix.lower() in (*PICTURES, *VIDEOS))
    if not found:
        raise options.BadInput(f"{path}: no picture or video is in this folder")
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
            raise options.BadInput(
                f"{path}: its name does not end in a view such as _demo_left; name it by {options.VIEW_OPTIONS}"
            )
        for view in views:
            files[view].append(path)
    options.require_separate_files(path for paths in files.values() for path in paths)
    found = {view: paths for view, paths in files.items() if paths}
    if not found:
        raise options.BadInput(f"no pictures: name files, or give them by {options.VIEW_OPTIONS}")
    return found, of_both

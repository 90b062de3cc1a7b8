"""viewimit evaluate: the estimators on a person's own tracked points; no model of a robot or a camera."""

import argparse
import sys
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..evaluation import conflict
from ..geometry.affine import MIN_POINTS, fit_affine_fundamental, flatness
from ..geometry.distortion import Radial
from ..geometry.rectification import Rectification, rectification_of
from ..perception.tracked import TrackedPoints, read_deeplabcut, read_tidy
from ..rectifying import pooled
from ..settings import Settings
from ..simulation.lens import undistorted
from ..transfer import TRANSFERS
from ..transfer.rectified import fit
from ..views import VIEWS, FourViews
from . import BadInput, evaluate_report
from .json_output import print_json
from .options import DONE, MISSED, add_json_option, add_rectify_option, add_undistort_option, between, lens, naming

PAIRS = tuple(pair for pair in combinations(VIEWS, 2) if pair != ("l", "r"))  # Eq. (4); no constraint is of (l, r)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("points", nargs="?", type=Path, metavar="POINTS.csv", help="frame,view,point,x,y,confidence")
    for view in VIEWS:
        parser.add_argument(f"--{view}", type=Path, metavar="FILE", help=f"instead: DeepLabCut's CSV of view {view}")
    parser.add_argument(
        "--transfer", choices=TRANSFERS, default=Settings().transfer, help="(%(default)s)", metavar="NAME"
    )
    parser.add_argument(
        "--min-confidence",
        type=between(float, 0.0, 1.0),
        default=0.6,
        metavar="SHARE",
        help="points of less were not seen (%(default)s)",
    )
    add_rectify_option(parser)
    add_undistort_option(parser)
    parser.add_argument(
        "--lens", type=lens, metavar="FX,FY,CX,CY", help="of all cameras: focal lengths and centre px, for --undistort"
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="write a report with the points drawn: .html, .png")
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    if args.out:
        with naming("--out"):
            evaluate_report.require_format(args.out)
    tracked = _read(args)
    views = _pinhole(args, tracked.views(args.min_confidence))
    each = [_frame(views, k) for k in range(len(tracked.frames))]
    rectification = None if args.rectify == "off" else rectification_of(*np.split(pooled(each), 2, axis=1))
    frames = [
        evaluate_frame(frame, tracked.points, seen, args.transfer, rectification)
        for frame, seen in zip(tracked.frames, each)
    ]
    rectified = None if rectification is None else {"left": rectification.left, "right": rectification.right}
    result = {"transfer": args.transfer, "rectification": rectified, "points": tracked.points, "frames": frames}
    evaluated = [frame for frame in frames if frame["E"] is not None]
    if args.out and evaluated:
        with naming("--out"):
            evaluate_report.write(args.out, result)
        print(f"written to {args.out}", file=sys.stderr)
    if args.json:
        print_json(args, result)
    else:
        _report(result)
    if not evaluated:
        print(f"viewimit evaluate: no frame has {MIN_POINTS} points in all four views", file=sys.stderr)
    return DONE if evaluated else MISSED


def evaluate_frame(
    frame: int, points: tuple[str, ...], views: FourViews, transfer: str, rectification: Rectification | None = None
) -> dict:
    """What is to say of one frame; all but its number and usable points is None with too few of these."""
    usable = views.usable
    found = {"frame": frame, "usable": [name for name, seen in zip(points, usable) if seen]}
    if usable.sum() < MIN_POINTS:
        return found | dict.fromkeys(("E", "condition", "flatness", "rms_px", "fundamental", "seen", "recovered"))
    seen = views.select(usable)
    fitted = fit(TRANSFERS[transfer], seen, rectification)
    recovered = fitted.recover(seen.demo_left, seen.demo_right)
    image = dict(zip(VIEWS, (seen.demo_left, seen.demo_right, seen.own_left, seen.own_right)))
    fundamental = {}
    for p, q in PAIRS:
        f, f33 = fit_affine_fundamental(image[p], image[q])
        fundamental[f"{p},{q}"] = dict(zip(("f13", "f23", "f31", "f32", "f33"), (*f, f33)))
    return found | {
        "E": float(fitted.conflict(seen)),
        "condition": float(fitted.condition),
        "flatness": flatness(seen.demo),
        "rms_px": float(np.sqrt(conflict(seen.own - recovered))),
        "fundamental": fundamental,
        "seen": image,
        "recovered": {"L": recovered[:, :2], "R": recovered[:, 2:]},
    }


def _pinhole(args: argparse.Namespace, views: FourViews) -> FourViews:
    """The views without the lenses' distortion, if the user knows that. Raises BadInput."""
    if (args.undistort is None) != (args.lens is None):
        raise BadInput("--undistort and --lens go together: a distortion is about a centre, in focal lengths")
    if args.undistort is None:
        return views
    (fx, fy, *centre), by = args.lens, Radial(*args.undistort)

    def pair(images: NDArray) -> NDArray:
        halves = (undistorted(images[..., side], (fx, fy), tuple(centre), by) for side in (slice(2), slice(2, 4)))
        return np.concatenate(list(halves), -1)

    return FourViews(pair(views.demo), pair(views.own), views.visible)


def _frame(views: FourViews, k: int) -> FourViews:
    return FourViews(views.demo[k], views.own[k], views.visible[k])


def _read(args: argparse.Namespace) -> TrackedPoints:
    given = {view: vars(args)[view] for view in VIEWS if vars(args)[view]}
    if args.points and not given:
        with naming("POINTS.csv"):
            return read_tidy(args.points)
    if args.points or len(given) < len(VIEWS):
        raise BadInput("give either POINTS.csv, or DeepLabCut's files of all four views by --l, --r, --L and --R")
    with naming("--l, --r, --L, --R"):
        return read_deeplabcut(given)


def _report(result: dict) -> None:
    how = "" if result["rectification"] is None else ", images rectified"
    print(f"{result['transfer']} transfer{how}, {len(result['points'])} points, {len(result['frames'])} frames")
    print(f"{'frame':>7}{'usable':>8}{'E px²':>12}{'rms px':>9}{'condition':>11}{'flatness':>10}")
    for frame in result["frames"]:
        numbers = [
            "–" if frame[key] is None else f"{frame[key]:{form}}"
            for key, form in (("E", ".4g"), ("rms_px", ".3g"), ("condition", ".3g"), ("flatness", ".3g"))
        ]
        print(
            f"{frame['frame']:>7}{len(frame['usable']):>8}{numbers[0]:>12}{numbers[1]:>9}{numbers[2]:>11}{numbers[3]:>10}"
        )
    first = next((frame for frame in result["frames"] if frame["E"] is not None), None)
    if first is None:
        return
    print(f"affine fundamental matrices of frame {first['frame']}: f13 x + f23 y + f31 x' + f32 y' + f33 = 0")
    for pair, f in first["fundamental"].items():
        print(f"  {pair}  " + "".join(f"{name} {value:9.4f}  " for name, value in f.items()).rstrip())

"""viewimit evaluate: the estimators on a person's own tracked points; no model of a robot or a camera."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import options
from ..analysis.evaluation import TOO_FEW, Frame, evaluate
from ..analysis.results import misfit_json, naming_json, naming_words
from ..analysis.tracked_body import (
    NamedPoints,
    TrackedBody,
    find_misfit,
    gain_words,
    learn_tracked_body,
    name_points,
    observed_in_calibration,
    observed_in_postures,
)
from ..drawing.export import evaluation as evaluate_report
from ..estimation.noise import views_rounding_std
from ..estimation.outliers import find_outliers, select_matches
from ..estimation.transfers import TRANSFERS
from ..estimation.views import VIEW_NAMES, VIEWS, FourViews
from ..geometry.affine import MIN_POINTS
from ..geometry.rectification import fit_rectification
from ..loop.self_calibration import SelfCalibration
from ..sensing.files import MAX_NAME_CHARS, escape
from ..sensing.tracks import TrackedPoints, read_files, read_tidy
from . import lenses
from .json_output import print_json

BODIES = {"demonstrator": "lr", "learner": "LR"}  # and its views
NAMED = 10  # points that --min-confidence removed, in words
MARGIN_RAD = np.radians(30.0)  # beyond the learner's own postures, in which the demonstrator's is looked for


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("points", nargs="?", type=Path, metavar="POINTS.csv", help="frame,view,point,x,y,confidence")
    options.add_view_options(parser, "instead: tracks of {}, as DeepLabCut, SLEAP, … write them")
    for body in BODIES:
        parser.add_argument(f"--{body}", metavar="NAME", help="whose points to take of files with several individuals")
    parser.add_argument(
        "--transfer", choices=TRANSFERS, help=f"{', '.join(TRANSFERS)} ({options.DEFAULT_TRANSFER})", metavar="NAME"
    )
    parser.add_argument(
        "--min-confidence",
        type=options.between(float, 0.0, 1.0),
        default=0.6,
        metavar="SHARE",
        help="points of less count as not seen, and are named; 0 keeps all (%(default)s)",
    )
    rectify = "rectify the pictures where that predicts left-out points better, or never (auto)"
    options.add_settings(parser, "rectify", rectify=rectify)
    lenses.add_options(parser)
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="write a report with the points drawn: .html, .svg, .png, .pdf"
    )
    parser.add_argument(
        "--unmatched",
        action="store_true",
        help="names in l and r are not those in L and R: find out which point is which; needs one of the next two",
    )
    also = "it also shows how the demonstrator's body differs"
    parser.add_argument(
        "--calibration", type=Path, metavar="FILE", help=f"the learner's body, by viewimit rehearse; {also}"
    )
    parser.add_argument(
        "--postures",
        type=Path,
        metavar="FILE",
        help=f"table of the learner's joint angles: frame, then a column of degrees for each joint; {also}",
    )
    options.add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    if args.out:
        with options.naming("--out"):
            evaluate_report.require_format(args.out)
    if args.calibration and args.postures:
        raise options.BadInput("--calibration, --postures: give one of them, as both show the learner's body")
    if args.unmatched and not (args.calibration or args.postures):
        raise options.BadInput(
            "--unmatched: needs --calibration FILE of viewimit rehearse, or --postures FILE with the learner's joint "
            "angles in each frame"
        )
    tracked = _read(args)
    removed = tracked.n_below_confidence(args.min_confidence)
    _say(*_told_of(args, tracked, removed))
    images = tracked.views(args.min_confidence)
    views, points, of_body = _with_body(args, tracked, lenses.without_distortion(args, images))
    found = evaluate(
        views, points, tracked.frames, args.transfer, args.rectify != "off", rounding_px=views_rounding_std(images)
    )
    gains = of_body.get("degrees_per_unit")
    units = None if gains is None else f"--postures: these are not degrees: {gain_words(gains)}; write degrees"
    _say(*_lengths(tracked), *evaluate_report.shift_words(found.time_shift, tracked.frames), units)
    report = evaluate_report.Report(found, of_body, removed)
    if args.out and report.first is not None:
        with options.naming("--out"):
            evaluate_report.write(args.out, report)
        print(f"written to {args.out}", file=sys.stderr)
    if args.json:
        print_json(args, evaluate_report.as_json(report))
    else:
        print("\n".join(evaluate_report.report_lines(report)))
    named = of_body.get("naming")
    if named is not None and not named["accepted"]:
        _say(f"names {naming_words(named)}")
        return options.MISSED
    if all(frame.refused == TOO_FEW for frame in found.frames):
        _say(_too_few(tracked, args.min_confidence))
        return options.MISSED
    _say(*_doubts(found.frames))
    return options.MISSED if report.first is None else options.DONE


def _say(*sentences: str | None) -> None:
    """Print what the reader has to know beside the report, a line each."""
    for said in filter(None, sentences):
        print(f"viewimit evaluate: {said}", file=sys.stderr)


def _told_of(args: argparse.Namespace, tracked: TrackedPoints, removed: dict[str, int]) -> Iterator[str | None]:
    """What was noticed while the files were read."""
    if lost := tracked.n_missing(args.min_confidence):
        at = "at (0, 0), (-1, -1) or the like"
        yield f"{lost} point{'s' if lost > 1 else ''} {at}: counted as lost by the tracker"
    yield from tracked.notes
    yield from tracked.unmatched_names(tuple(BODIES.values()) if args.unmatched else (VIEWS,))
    yield tracked.doubtful_place()
    yield tracked.doubtful_units()
    yield tracked.doubtful_frames()
    if removed:
        yield _removed(tracked, removed, args.min_confidence)


def _with_body(
    args: argparse.Namespace, tracked: TrackedPoints, views: FourViews
) -> tuple[FourViews, tuple[str, ...], dict]:
    """The views and names of the own body's points, if it is learned, and what it tells, as JSON. Raises BadInput."""
    body, names = _learn_body(args, tracked.frames, views), tracked.points
    if body is None:
        return views, names, {}
    points = tuple(names[k] for k in body.points.tolist())
    told: dict = {} if body.gains is None else {"degrees_per_unit": body.gains}
    if args.unmatched:
        matched = name_points(body, views)
        told = {"naming": _naming_json(matched, body, tracked.frames, names), **told}
        views = matched.views
    else:
        views = views.select(body.points)
    told["misfit"] = None
    if (misfit := find_misfit(body, views)) is not None:
        said = misfit_json(misfit[0], range(1, 1 + len(body.lower)), points) or {}
        told["misfit"] = said | {"frame": tracked.frames[misfit[1]]}
    return views, points, told


def _learn_body(args: argparse.Namespace, frames: Sequence[int], views: FourViews) -> TrackedBody | None:
    """Learn the own body from a table of joint angles or a calibration; None without either. views: T frames.

    Raises BadInput.
    """
    if args.postures is None and args.calibration is None:
        return None
    own = np.flatnonzero(views.visible[..., 2:].all(-1).any(0))
    matches, noise_px = select_matches(views), find_outliers(views).noise_px or 0.0
    rectification = None if args.rectify == "off" else fit_rectification(matches[:, :2], matches[:, 2:])
    if args.postures:
        with options.naming("--postures"):
            seen = observed_in_postures(args.postures, frames, views, own)
            limits = seen.displacement.min(0) - MARGIN_RAD, seen.displacement.max(0) + MARGIN_RAD
            return learn_tracked_body(seen, own, limits, noise_px, rectification)
    with options.naming("--calibration"):
        calibration = SelfCalibration.load(args.calibration)
        limits = np.zeros(len(calibration.body.span_deg)), np.radians(calibration.body.span_deg)
        noise_px = max(noise_px, calibration.noise_px)
        seen = observed_in_calibration(calibration, len(own))
        return learn_tracked_body(seen, own, limits, noise_px, rectification, False)


def _naming_json(found: NamedPoints, body: TrackedBody, frames: Sequence[int], points: Sequence[str]) -> dict:
    """What was found, with names of points instead of indices."""
    one = found.naming
    if one is None:
        return {"accepted": False, "frame": None}
    names = [points[k] for k in body.points.tolist()]
    partner = [None if row < 0 or not one.accepted else points[row] for row in one.names]
    return (naming_json(one) or {}) | {
        "frame": frames[found.frame],
        "posture_deg" if body.gains is None else "posture": np.degrees(one.displacement),
        "names": dict(zip(names, partner)),
        "probability": dict(zip(names, one.probability)),
        "certain": dict(zip(names, one.certain)),
        "without_partner": {
            "learner": [name for name, row in zip(names, one.names) if row < 0],
            "demonstrator": [points[row] for row in one.unnamed],
        },
    }


def _doubts(frames: Sequence[Frame]) -> Iterator[str]:
    """In one line each: which frames were refused, which are weak, and why the first is."""
    for key in ("refused", "weak", "mirrored"):
        those = [frame for frame in frames if getattr(frame, key)]
        if those:
            first = those[0]
            why = evaluate_report.MIRRORED if key == "mirrored" else getattr(first, key)
            yield f"{len(those)} of {len(frames)} frames {key}: frame {first.number}: {why}"


def _lengths(tracked: TrackedPoints) -> Iterator[str]:
    """In a line for each body: its tracks begin or end at other frames in the left view than in the right one."""
    seen: NDArray[np.bool_] = np.any(tracked.views().visible, axis=1)  # (T, 4)
    for body, pair in zip(BODIES, ((0, 1), (2, 3))):
        ends = [(tracked.frames[at[0]], tracked.frames[at[-1]]) for k in pair if len(at := np.flatnonzero(seen[:, k]))]
        if len(ends) == len(pair) and ends[0] != ends[1]:
            left, right = (f"{first} to {last} in {VIEW_NAMES[VIEWS[k]]}" for k, (first, last) in zip(pair, ends))
            yield (
                f"the {body} has frames {left}, but {right}: if one camera has lost a frame, left and right are not "
                "of the same moment from then on; cut both to the same moments"
            )


def _read(args: argparse.Namespace) -> TrackedPoints:
    given = {view: vars(args)[name] for view, name in VIEW_NAMES.items() if vars(args)[name]}
    options.require_separate_files(given.values())
    if args.points and not given and args.points.suffix.lower() not in (".csv", ".tsv", ".txt", ""):
        raise options.BadInput(
            f"{args.points}: POINTS.csv is a table of all four views; give others by {options.VIEW_OPTIONS}"
        )
    named = [body for body in BODIES if vars(args)[body] is not None]
    if args.points and not given and named:
        raise options.BadInput(
            f"--{named[0]}: {args.points} is a table of all four views, which say whose points are whose"
        )
    if args.points and not given:
        with options.naming("POINTS.csv"):
            return read_tidy(args.points)
    if args.points or len(given) < len(VIEWS):
        raise options.BadInput(f"give either POINTS.csv, or a file of each of the four views by {options.VIEW_OPTIONS}")
    individuals = {view: vars(args)[body] for body, views in BODIES.items() for view in views if vars(args)[body]}
    with options.naming(options.VIEW_OPTIONS):
        return read_files(given, individuals)


def _too_few(tracked: TrackedPoints, least_confidence: float) -> str:
    """What no frame has."""
    seen_in = tracked.views(least_confidence).visible.any(0)  # (N, 4)
    if seen_in.any(0).all() and not seen_in.all(-1).any():
        return "no point has the same name in all four views: points are matched by name"
    if apart := tracked.no_common_frame():
        return apart
    none = f"no frame has {MIN_POINTS} points in all four views"
    if (tracked.views().usable.sum(-1) >= MIN_POINTS).any():
        return f"{none} of confidence {least_confidence:g} or more: lower it, --min-confidence 0 keeps all points"
    return none


def _removed(tracked: TrackedPoints, removed: dict[str, int], least_confidence: float) -> str:
    """By number and name, those of which most is gone first."""
    most = sorted(removed, key=lambda name: -removed[name])
    named = ", ".join(f"{escape(name, MAX_NAME_CHARS)} ({removed[name]})" for name in most[:NAMED])
    more = f" and {len(most) - NAMED} more names" if len(most) > NAMED else ""
    whole = f"{sum(removed.values()):,} of {tracked.n_image_points():,} image points"
    return f"--min-confidence {least_confidence:g} removed {whole}: {named}{more}"

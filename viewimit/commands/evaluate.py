"""viewimit evaluate: the estimators on a person's own tracked points; no model of a robot or a camera."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..analysis.leave_one_out import leave_one_out
from ..analysis.timing import TimeShift, find_time_shift
from ..estimation.noise import views_rounding_std
from ..estimation.outliers import find_outliers, select_matches
from ..estimation.rectification import fit_transfer
from ..estimation.residuals import conflict
from ..estimation.transfers import TRANSFERS, TransferMethod, default_transfer
from ..estimation.transfers.registry import FLAT, FLATNESS, ILL_CONDITIONED, PROJECTIVE_MIN_POINTS
from ..estimation.views import VIEW_NAMES, VIEWS, FourViews, extents, why_degenerate
from ..geometry.affine import MIN_POINTS, fit_affine_fundamental
from ..geometry.handedness import Handedness, principal_axes
from ..geometry.rectification import Rectification
from ..sensing.files import MAX_NAME_CHARS, escape
from ..sensing.tracks import TrackedPoints, read_files, read_tidy
from . import BadInput, evaluate_body, evaluate_report, lenses
from .json_output import print_json
from .options import (
    DEFAULT_TRANSFER,
    DONE,
    MISSED,
    VIEW_OPTIONS,
    add_json_option,
    add_settings,
    add_view_options,
    between,
    naming,
    naming_words,
    require_separate_files,
)

BODIES = {"demonstrator": "lr", "learner": "LR"}  # and its views
FIGURES = ("E", "condition", "flatness", "rms_px", "fundamental", "seen", "recovered", "refused", "weak", "mirrored")
TOO_FEW = f"no {MIN_POINTS} points are seen in all four views"
NAMED = 10  # points that --min-confidence removed, in words
TOGETHER = 2000  # frames at a time, for memory's sake
MIN_SPREAD = 6.0  # of σ₁/σ₄: noise alone gives 5 at most in 95 % of frames, arms give 24 and more at 1 px


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("points", nargs="?", type=Path, metavar="POINTS.csv", help="frame,view,point,x,y,confidence")
    add_view_options(parser, "instead: tracks of {}, as DeepLabCut, SLEAP, … write them")
    for body in BODIES:
        parser.add_argument(f"--{body}", metavar="NAME", help="whose points to take of files with several individuals")
    parser.add_argument(
        "--transfer", choices=TRANSFERS, help=f"{', '.join(TRANSFERS)} ({DEFAULT_TRANSFER})", metavar="NAME"
    )
    parser.add_argument(
        "--min-confidence",
        type=between(float, 0.0, 1.0),
        default=0.6,
        metavar="SHARE",
        help="points of less were not seen, which is said; 0 keeps all (%(default)s)",
    )
    rectify = "rectify the images where that predicts points better that are left out of the fit, or never (auto)"
    add_settings(parser, "rectify", rectify=rectify)
    lenses.add_options(parser)
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="write a report with the points drawn: .html, .svg, .png, .pdf"
    )
    evaluate_body.add_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    if args.out:
        with naming("--out"):
            evaluate_report.require_format(args.out)
    evaluate_body.require_options(args)
    tracked = _read(args)
    if lost := tracked.n_missing(args.min_confidence):
        says = f"{lost} point{'s' if lost > 1 else ''} at (0, 0) or (-1, -1): taken for lost by the tracker, not seen"
        print(f"viewimit evaluate: {says}", file=sys.stderr)
    unnamed = tracked.unmatched_names(tuple(BODIES.values()) if args.unmatched else (VIEWS,))
    for said in (*tracked.notes, *unnamed, tracked.doubtful_units(), tracked.doubtful_frames()):
        if said:
            print(f"viewimit evaluate: {said}", file=sys.stderr)
    removed = tracked.n_below_confidence(args.min_confidence)
    if removed:
        print(f"viewimit evaluate: {_removed(tracked, removed, args.min_confidence)}", file=sys.stderr)
    images = tracked.views(args.min_confidence)
    views, points, named = lenses.without_distortion(args, images), tracked.points, None
    body = evaluate_body.learn_body(args, tracked.frames, views)
    if body is not None and args.unmatched:
        views, points, named = evaluate_body.named(body, tracked.frames, points, views)
    elif body is not None:
        own = body.points
        views = FourViews(views.demo[:, own], views.own[:, own], views.visible[:, own])
        points = tuple(points[k] for k in own.tolist())
    shift = _time_shift(tracked, views)
    for said in filter(None, (*_lengths(tracked), *_shift_words(shift, tracked.frames))):
        print(f"viewimit evaluate: {said}", file=sys.stderr)
    if body is not None and body.gains is not None:
        said = f"--postures: these are no degrees: {evaluate_body.gain_words(body.gains)}; write degrees"
        print(f"viewimit evaluate: {said}", file=sys.stderr)
    transfer = args.transfer or default_transfer(_usual_count(views))
    found = find_outliers(views, rounding_px=views_rounding_std(images))
    without = found.corrected(views)
    compared = leave_one_out(without, args.rectify != "off")
    rectification = compared.rectification
    frames = evaluate_frames(tracked.frames, points, views, transfer, rectification)
    if found.noise_px is not None:
        _find_mirrored(frames, select_matches(without), rectification, found.noise_px)
    rectified = None if rectification is None else {"left": rectification.left, "right": rectification.right}
    result = {
        "transfer": transfer,
        "rectification": rectified,
        "points": points,
        **({} if named is None else {"naming": named}),
        **({} if body is None or body.gains is None else {"degrees_per_unit": body.gains}),
        **({} if body is None else {"misfit": evaluate_body.misfit_of(body, tracked.frames, points, views)}),
        "removed_by_confidence": removed,
        "time_shift": _shift_json(shift, tracked.frames),
        "leave_one_out": evaluate_report.transfers_json(compared),
        "suspects": evaluate_report.suspects_json(found, points, tracked.frames),
        "undecided": found.undecided,
        "frames": frames,
    }
    evaluated = [frame for frame in frames if frame["E"] is not None]
    if args.out and evaluated:
        with naming("--out"):
            evaluate_report.write(args.out, result | {"first": evaluate_report.named_coefficients(evaluated[0])})
        print(f"written to {args.out}", file=sys.stderr)
    if args.json:
        print_json(args, result | {"frames": map(evaluate_report.named_coefficients, frames)})
    else:
        evaluate_report.print_report(result)
    if named is not None and not named["accepted"]:
        print(f"viewimit evaluate: names {naming_words(named)}", file=sys.stderr)
        return MISSED
    if all(frame["refused"] == TOO_FEW for frame in frames):
        print(f"viewimit evaluate: {_too_few(tracked, args.min_confidence)}", file=sys.stderr)
        return MISSED
    for said in _doubts(frames):
        print(f"viewimit evaluate: {said}", file=sys.stderr)
    return DONE if evaluated else MISSED


def evaluate_frames(
    numbers: Sequence[int],
    points: Sequence[str],
    views: FourViews,
    transfer: str,
    rectification: Rectification | None = None,
) -> list[dict]:
    """Evaluate T frames, (T, N, …). One that no transfer can be fitted to has the reason; its other values are None."""
    frames: list[dict] = [{} for _ in numbers]
    patterns, of = np.unique(views.usable, axis=0, return_inverse=True)
    for k, usable in enumerate(patterns):
        names = [name for name, seen in zip(points, usable) if seen]
        alike = np.flatnonzero(of.ravel() == k)
        for at in np.array_split(alike, -(-len(alike) // TOGETHER)):
            some = _frames(views, at).select(usable)
            why = why_degenerate(some) if len(names) >= MIN_POINTS else [TOO_FEW] * len(at)
            good = np.array([not words for words in why])
            results = iter(_evaluated(_frames(some, good), transfer, rectification) if good.any() else ())
            for index, words in zip(at.tolist(), why):
                found = dict.fromkeys(FIGURES) | {"refused": words} if words else next(results)
                frames[index] = {"frame": numbers[index], "usable": names} | found
    return frames


def _evaluated(seen: FourViews, transfer: str, rectification: Rectification | None) -> Iterator[dict]:
    """Of frames whose points are all seen, and no degenerate ones."""
    method = TRANSFERS[transfer]
    fitted = fit_transfer(method, seen, rectification)
    recovered = fitted.recover(seen.demo_left, seen.demo_right)
    image = dict(zip(VIEWS, (seen.demo_left, seen.demo_right, seen.own_left, seen.own_right)))
    pairs = [fit_affine_fundamental(image[p], image[q]) for p, q in evaluate_report.PAIRS]
    F = np.stack([np.concatenate([f, f33[..., None]], -1) for f, f33 in pairs], -2)
    demo, own = extents(seen.demo), extents(seen.own)
    flat, condition = demo[:, 0] / demo[:, 2], np.broadcast_to(fitted.condition, len(F))
    E, rms = fitted.conflict(seen), np.sqrt(conflict(seen.own - recovered))
    for k in range(len(F)):
        yield {
            "E": float(E[k]),
            "condition": float(condition[k]),
            "flatness": float(flat[k]),
            "rms_px": float(rms[k]),
            "fundamental": F[k],
            "seen": {VIEW_NAMES[view]: points[k] for view, points in image.items()},
            "recovered": {VIEW_NAMES["L"]: recovered[k, :, :2], VIEW_NAMES["R"]: recovered[k, :, 2:]},
            "refused": None,
            "weak": _weak(method, seen.own.shape[-2], float(condition[k]), demo[k], own[k]),
            "mirrored": None,
        }


def _find_mirrored(
    frames: Sequence[dict], matches: NDArray, rectification: Rectification | None, noise_px: float
) -> None:
    """Fill in whether each frame's fit is a reflection, None where the points are too flat to tell.

    matches: (M, 4) px of both bodies; noise_px: of an image coordinate, standard deviation.
    """
    rectified = (lambda images: images) if rectification is None else rectification.apply
    axes = principal_axes(rectified(matches))
    for frame in frames:
        if frame["refused"]:
            continue
        views = FourViews.from_images(*(frame["seen"][name] for name in VIEW_NAMES.values()))
        handedness = Handedness.from_images(rectified(views.demo), axes, noise_px)
        if handedness is not None:
            frame["mirrored"] = handedness.is_mirrored(rectified(views.own))


def _weak(method: TransferMethod, count: int, condition: float, demo: NDArray, own: NDArray) -> str | None:
    """What speaks against the result of a frame of `count` points. demo, own: their extents, (4,) px each."""
    if method is TRANSFERS["projective"] and count < PROJECTIVE_MIN_POINTS:
        return f"{count} points: fewer than {PROJECTIVE_MIN_POINTS} fit the projective transfer wherever the arms are"
    if condition >= ILL_CONDITIONED:
        return f"{method.condition_name} {condition:.3g}: {method.degenerate_message}"
    for of, sigma in (("", demo), (" of [L R]", own)):
        if sigma[0] >= ILL_CONDITIONED * sigma[2]:
            return f"{FLATNESS}{of} {sigma[0] / sigma[2]:.3g}: {FLAT}"
        if sigma[0] < MIN_SPREAD * sigma[3]:
            return f"σ₁/σ₄{of} {sigma[0] / sigma[3]:.3g}: the spread is little more than noise, E may mislead"
    return None


def _usual_count(views: FourViews) -> int:
    """How many points are usable in half of the frames that have enough of them for a transfer; 0 without any."""
    counts = views.usable.sum(-1)
    enough = counts[counts >= MIN_POINTS]
    return int(np.median(enough)) if len(enough) else 0


def _doubts(frames: Sequence[dict]) -> Iterator[str]:
    """In one line each: which frames were refused, which are weak, and why the first is."""
    for key in ("refused", "weak", "mirrored"):
        those = [frame for frame in frames if frame[key]]
        if those:
            first = those[0]
            why = evaluate_report.MIRRORED if key == "mirrored" else first[key]
            yield f"{len(those)} of {len(frames)} frames {key}: frame {first['frame']}: {why}"


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


def _time_shift(tracked: TrackedPoints, views: FourViews) -> TimeShift | None:
    """Of both bodies together, as one head sees both, or else of one that moves."""
    steps = np.diff(tracked.frames)
    if len(steps) == 0 or (steps != steps[0]).any():
        return None
    seen = [views.demo, views.own]
    tried = (np.concatenate(seen, 1), *seen)  # NaN, where a point is not seen
    return next(filter(None, map(find_time_shift, tried)), None)


def _shift_json(shift: TimeShift | None, frames: Sequence[int]) -> dict | None:
    if shift is None:
        return None
    parts = [{"from_frame": frames[first], "frames": late} for first, late in shift.parts]
    return {"parts": parts, "rms_px": shift.rms_px, "shifted_px": shift.shifted_px}


def _shift_words(shift: TimeShift | None, frames: Sequence[int]) -> Iterator[str]:
    """In a line: the cameras are not in time, and the shift that mends that."""
    if shift is None:
        return
    by = [
        f"{abs(late):.1f} frames {'later' if late > 0 else 'earlier'}"
        + (f" from frame {frames[first]} on" if len(shift.parts) > 1 else "")
        for first, late in shift.parts
    ]
    yield (
        "left and right contradict each other the more the faster the points move: the cameras are not in time. Pair "
        f"each left frame with the right one {', '.join(by)}: the rms misfit falls from "
        f"{shift.rms_px:.2g} to {shift.shifted_px:.2g} px"
    )


def _frames(views: FourViews, which: NDArray | int) -> FourViews:
    return FourViews(views.demo[which], views.own[which], views.visible[which])


def _read(args: argparse.Namespace) -> TrackedPoints:
    given = {view: vars(args)[name] for view, name in VIEW_NAMES.items() if vars(args)[name]}
    require_separate_files(given.values())
    if args.points and not given and args.points.suffix.lower() not in (".csv", ".tsv", ".txt", ""):
        raise BadInput(f"{args.points}: POINTS.csv is a table of all four views; give others by {VIEW_OPTIONS}")
    named = [body for body in BODIES if vars(args)[body] is not None]
    if args.points and not given and named:
        raise BadInput(f"--{named[0]}: {args.points} is a table of all four views, which say whose points are whose")
    if args.points and not given:
        with naming("POINTS.csv"):
            return read_tidy(args.points)
    if args.points or len(given) < len(VIEWS):
        raise BadInput(f"give either POINTS.csv, or a file of each of the four views by {VIEW_OPTIONS}")
    individuals = {view: vars(args)[body] for body, views in BODIES.items() for view in views if vars(args)[body]}
    with naming(VIEW_OPTIONS):
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

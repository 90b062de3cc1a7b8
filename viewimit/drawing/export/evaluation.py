"""What `evaluate` reports of tracked points: parts of its JSON, text, one HTML file, or a picture."""

import html
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...analysis.evaluation import Evaluation, Frame
from ...analysis.leave_one_out import JUDGE, MAX_RATIO, LeaveOneOut
from ...analysis.results import naming_words, posture
from ...analysis.timing import TimeShift
from ...estimation.outliers import Outlier
from ...estimation.views import VIEW_NAMES
from ...geometry.affine import MIN_POINTS
from ...sensing.files import MAX_NAME_CHARS, escape
from ..images.tracked import draw_view, draw_views
from . import figures


@dataclass(frozen=True)
class Report:
    """What is reported: of the points, of the body as JSON has it, of what was left out."""

    found: Evaluation
    of_body: dict
    removed: dict[str, int]

    @property
    def first(self) -> Frame | None:
        """The first frame that has an E."""
        return next((frame for frame in self.found.frames if frame.E is not None), None)


MIRRORED = (
    "the fit is a reflection, and one head sees no body as its own mirror image, so that a small E is no good fit; "
    "left and right may stand in each other's place in the views of one body"
)
MAX_NAMED_FRAMES = 6  # frames that are named in words
COEFFICIENTS = ("f13", "f23", "f31", "f32", "f33")
Points = Mapping[str, NDArray[np.float64]]  # (n, 2) px by view
FORMATS = (".html", *figures.PICTURES)
STYLE = """body { font: 15px system-ui, sans-serif; margin: 2em auto; max-width: 70em; color: var(--ink) }
svg.vi { display: inline-block; width: 48%; border: 1px solid var(--rule); margin: 0.4% }
pre { overflow-x: auto }"""
LEGEND = """<span style="color:var(--demonstrator)">●</span> <span style="color:var(--learner)">●</span> seen,
<span style="color:var(--recovered)">◇ recovered from [l], [r]</span>,
<span style="color:var(--residual)">→ residual e</span>"""


def require_format(path: Path) -> None:
    """Raises ValueError before any work is done."""
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise ValueError(f"{path}: unknown extension {suffix!r}; there are {', '.join(FORMATS)}")
    figures.require_renderer(path, ".html")


def write(path: Path, report: Report) -> None:
    """The first frame that has an E is drawn; HTML lists all. Raises OSError."""
    frame = report.first
    assert frame is not None and frame.seen is not None and frame.recovered is not None
    if path.suffix.lower() in figures.PICTURES:
        heading = f"frame {frame.number}, {report.found.transfer} transfer, E = {_E(frame)} px²"
        drawing = draw_views(frame.seen, frame.recovered, frame.usable, heading)
        figures.write(path, figures.standalone(drawing, heading))
    else:
        path.write_text(_page(report, frame, frame.seen, frame.recovered), encoding="utf-8")


def _page(report: Report, frame: Frame, seen: Points, recovered: Points) -> str:
    panels = [draw_view(name, seen[name], recovered.get(name), frame.usable) for name in VIEW_NAMES.values()]
    lines = [f"residuals of frame {frame.number}, px"]
    for k, name in enumerate(frame.usable):
        away = [f"{view} {np.linalg.norm(seen[view][k] - recovered[view][k]):.3f}" for view in recovered]
        lines.append(f"  {escape(name, MAX_NAME_CHARS)}: {', '.join(away)}")
    count = sum(bool(one.mirrored) for one in report.found.frames)
    mirrored = f"<p>{count} of {len(report.found.frames)} frames mirrored: {MIRRORED}.</p>" if count else ""
    return f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>viewimit evaluate</title>
<style>{figures.used_rules("".join(panels))}
{figures.with_light_colours(STYLE)}</style>
<h1>Tracked points, {report.found.transfer} transfer</h1>
<p>Frame {frame.number}: {figures.with_light_colours(LEGEND)}. Pixels; E = {_E(frame)} px².</p>
{mirrored}{"".join(panels)}
<p>Compare E only between frames in which the arms are as large in their images.</p>
<pre>{html.escape(chr(10).join([*report_lines(report), *lines]))}</pre>
</html>
"""


def _E(frame: Frame) -> str:
    """With a mark if the fit reflects."""
    return f"{frame.E:.4g}" + (" (mirrored)" if frame.mirrored else "")


def _matrices(frame: Frame) -> dict[str, dict[str, float]]:
    """The fundamental matrices by pair and coefficient."""
    return {
        f"{VIEW_NAMES[p]},{VIEW_NAMES[q]}": dict(zip(COEFFICIENTS, f.tolist()))
        for (p, q), f in (frame.fundamental or {}).items()
    }


def as_json(report: Report) -> dict:
    """The whole report for programs."""
    found, rectification = report.found, report.found.rectification
    return {
        "transfer": found.transfer,
        "rectification": rectification and {"left": rectification.left, "right": rectification.right},
        "points": found.points,
        **report.of_body,
        "removed_by_confidence": report.removed,
        "time_shift": _shift_json(found.time_shift, [frame.number for frame in found.frames]),
        "leave_one_out": _left_out_json(found.left_out),
        "suspects": [_suspect_json(one, found) for one in found.outliers.found],
        "undecided": found.outliers.undecided,
        "frames": map(_frame_json, found.frames),
    }


def _frame_json(frame: Frame) -> dict:
    matrices = None if frame.fundamental is None else _matrices(frame)
    fields = {"frame": frame.number, **vars(frame), "fundamental": matrices}
    del fields["number"]
    return fields


def _suspect_json(one: Outlier, found: Evaluation) -> dict:
    """An outlier by names and frames. Only swapped points have E, E_swapped."""
    return {
        "kind": one.kind,
        "points": [found.points[k] for k in one.points],
        "views": [VIEW_NAMES[view] for view in one.views],
        "frames": [found.frames[k].number for k in one.frames],
        "score": one.score,
        **({"E": one.E, "E_swapped": one.E_swapped} if one.kind == "swapped" else {}),
    }


def _left_out_json(found: LeaveOneOut) -> dict | None:
    """Errors by transfer, px rms; None if nothing was predicted."""
    if not found.error_px:
        return None
    return {
        "error_px": dict(found.error_px),
        "rectified_px": None if found.rectified_px is None else dict(found.rectified_px),
        "rectified_ratio": found.ratio,
        "rectified_ratio_bound": found.ratio_bound,
        "predictions": found.predictions,
        "of_predictions": found.of_predictions,
        "frames": found.frames,
        "of_frames": found.of_frames,
        "sampled": found.sampled,
    }


def _suspect_in_words(suspect: dict, frames: int) -> tuple[str, str, str]:
    named, where = " and ".join(suspect["points"]), " or ".join(suspect["views"])
    if suspect["kind"] == "swapped":
        falls = f"E {suspect['E']:.3g} px², {suspect['E_swapped']:.3g} px² permuted: falls {suspect['score']:.3g} times"
        return named, f"swapped in {where.replace(' or ', ', ')}", falls
    seen = suspect["frames"]
    those = ", ".join(map(str, seen[:MAX_NAMED_FRAMES])) + (" …" if len(seen) > MAX_NAMED_FRAMES else "")
    which = f"frame {those}" if len(seen) == 1 else f"{len(seen)} of {frames} frames: {those}"
    return named, f"misplaced in {where}", f"{suspect['score']:.3g} standard deviations of the others off; {which}"


def _left_out_lines(found: LeaveOneOut) -> Iterator[str]:
    """A heading, names of the columns, then a row a transfer."""
    predictions, frames = _of(found.predictions, found.of_predictions), _of(found.frames, found.of_frames)
    sampled, plural = ", evenly spaced" if found.sampled else "", "" if found.of_frames == 1 else "s"
    yield f"leave-one-out error, rms px: {predictions} predictions in {frames} frame{plural}{sampled}"
    columns = [found.error_px] if found.rectified_px is None else [found.error_px, found.rectified_px]
    rows = {name: [f"{column[name]:.3g}" for column in columns] for name in found.error_px}
    for name, cells in {"transfer": ["images as they are", "rectified"][: len(columns)], **rows}.items():
        yield f"  {name:<11}" + "".join(f"{cell:>20}" for cell in cells)


def _rectification_verdict(found: Evaluation) -> str | None:
    """Whether images are rectified, and why. None if that was not asked, or there is nothing to rectify."""
    left_out, rectified = found.left_out, found.rectification is not None
    if left_out.rectified_px is None or not left_out.error_px:
        return "images rectified: their matches ask for it" if rectified else None
    how = "rectified" if rectified else "left as they are"
    if left_out.ratio is None:
        large = "errors this large are of arms in different postures, or of magnified noise"
        return f"images {how}, as their matches ask; {large}"
    what = f"{JUDGE} is {left_out.ratio:.2g} times as far off if rectified, {left_out.ratio_bound:.2g} at most"
    return f"images {how}: {what}; less than {MAX_RATIO:g} asks for it"


def _of(count: int, whole: int) -> str:
    return f"{count:,}" if count == whole else f"{count:,} of {whole:,}"


def report_lines(report: Report) -> Iterator[str]:
    """The report for people."""
    found, named = report.found, report.of_body.get("naming")
    how = "" if found.rectification is None else ", images rectified"
    count = len(found.frames)
    yield f"{found.transfer} transfer{how}, {len(found.points)} points, {count} frame{'' if count == 1 else 's'}"
    if named:
        yield f"names: {naming_words(named)}"
        if named["accepted"]:
            yield f"  {', '.join(f'{own} = {demo}' for own, demo in named['names'].items() if demo is not None)}"
            bare = ", ".join(f"{angle:.4g}" for angle in named.get("posture", ()))
            at = posture(named["posture_deg"]) if "posture_deg" in named else f"({bare}) in the unit of --postures"
            yield f"  the demonstrator of frame {named['frame']} is at {at}"
    if misfit := report.of_body.get("misfit"):
        yield f"misfit: {misfit['text']} (frame {misfit['frame']})"
    yield found.table()
    if not found.left_out.error_px:
        yield f"leave-one-out error: none, as no frame has {MIN_POINTS + 1} points that tell a transfer"
    else:
        yield from _left_out_lines(found.left_out)
    if said := _rectification_verdict(found):
        yield f"  {said}"
    suspects = [_suspect_in_words(_suspect_json(one, found), count) for one in found.outliers.found]
    yield "suspects" if suspects else "suspects: none"
    for points, what, score in suspects:
        yield f"  {escape(points, 2 * MAX_NAME_CHARS)}  {what}: {score}"
    yield from (f"  undecided: {why}" for why in found.outliers.undecided)
    if (first := report.first) is not None:
        yield f"affine fundamental matrices of frame {first.number}: f13 x + f23 y + f31 x' + f32 y' + f33 = 0"
        for pair, f in _matrices(first).items():
            yield f"  {pair:<20}  " + "".join(f"{name} {value:9.4f}  " for name, value in f.items()).rstrip()


def _shift_json(shift: TimeShift | None, frames: Sequence[int]) -> dict | None:
    if shift is None:
        return None
    parts = [{"from_frame": frames[first], "frames": late} for first, late in shift.parts]
    return {"parts": parts, "rms_px": shift.rms_px, "shifted_px": shift.shifted_px}


def shift_words(shift: TimeShift | None, frames: Sequence[int]) -> Iterator[str]:
    """Yield a line: the cameras are not in time, and the shift that mends that."""
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

"""What `evaluate` reports of tracked points: parts of its JSON, text, one HTML file, or a picture."""

import html
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np

from ..analysis.leave_one_out import JUDGE, MAX_RATIO, LeaveOneOut
from ..drawing.export import figures
from ..drawing.images.tracked import draw_view, draw_views
from ..estimation.outliers import OutlierReport
from ..estimation.views import VIEW_NAMES, VIEWS
from ..geometry.affine import MIN_POINTS
from ..sensing.files import MAX_NAME_CHARS, escape
from .options import naming_words, posture

MIRRORED = (
    "the fit is a reflection, and one head sees no body as its own mirror image, so that a small E is no good fit; "
    "left and right may stand in each other's place in the views of one body"
)
PAIRS = tuple(pair for pair in combinations(VIEWS, 2) if pair != ("l", "r"))  # Eq. (4); no constraint is of (l, r)
COEFFICIENTS = ("f13", "f23", "f31", "f32", "f33")
FORMATS = (".html", *figures.PICTURES)
STYLE = """body { font: 15px system-ui, sans-serif; margin: 2em auto; max-width: 70em; color: var(--ink) }
svg.vi { display: inline-block; width: 48%; border: 1px solid var(--rule); margin: 0.4% }
table { border-collapse: collapse; margin: 1em 0 } td, th { padding: 0.2em 0.8em; text-align: right }
tr:nth-child(even) { background: var(--card) }"""
LEGEND = """<span style="color:var(--demonstrator)">●</span> <span style="color:var(--learner)">●</span> seen,
<span style="color:var(--recovered)">◇ recovered from [l], [r]</span>,
<span style="color:var(--residual)">→ residual e</span>"""


def require_format(path: Path) -> None:
    """Raises ValueError before any work is done."""
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise ValueError(f"{path}: unknown extension {suffix!r}; there are {', '.join(FORMATS)}")
    figures.require_renderer(path, ".html")


def write(path: Path, result: dict) -> None:
    """`first`, the first frame that has an E, is drawn; HTML lists all. Raises OSError."""
    frame = result["first"]
    if path.suffix.lower() in figures.PICTURES:
        heading = f"frame {frame['frame']}, {result['transfer']} transfer, E = {_E(frame)} px²"
        drawing = draw_views(frame["seen"], frame["recovered"], frame["usable"], heading)
        figures.write(path, figures.standalone(drawing, heading))
    else:
        path.write_text(_page(result, frame), encoding="utf-8")


def _page(result: dict, frame: dict) -> str:
    names, seen, recovered = tuple(VIEW_NAMES.values()), frame["seen"], frame["recovered"]
    panels = [draw_view(name, seen[name], recovered.get(name), frame["usable"]) for name in names]
    heads = ("frame", "usable points", "E (px²)", "rms (px)", "condition", "flatness")
    rows = [[str(each["frame"]), str(len(each["usable"])), *_numbers(each)] for each in result["frames"]]
    residuals = []
    for k, name in enumerate(frame["usable"]):
        away = [np.linalg.norm(seen[view][k] - recovered[view][k]) for view in names[2:]]
        residuals.append([html.escape(name), *(f"{px:.3f}" for px in away)])
    matrices = [[pair, *(f"{value:.5g}" for value in f.values())] for pair, f in frame["fundamental"].items()]
    return f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>viewimit evaluate</title>
<style>{figures.used_rules("".join(panels))}
{figures.with_light_colours(STYLE)}</style>
<h1>Tracked points, {result["transfer"]} transfer</h1>
<p>Frame {frame["frame"]}: {figures.with_light_colours(LEGEND)}. Pixels; E = {_E(frame)} px².</p>
{_mirrored(result["frames"])}{"".join(panels)}
<h2>Transfers</h2>{_transfers(result)}
<h2>Suspects</h2>{_suspects(result)}
<h2>Frames</h2>{_table(heads, rows)}
<p>Compare E only between frames in which the arms are as large in their images.</p>
<h2>Residuals of frame {frame["frame"]} (px)</h2>{_table(("point", *names[2:]), residuals)}
<h2>Affine fundamental matrices of frame {frame["frame"]}</h2>
{_table(("pair", "f13", "f23", "f31", "f32", "f33 (px)"), matrices)}
</html>
"""


def _transfers(result: dict) -> str:
    """How far each is off at points that it was not fitted to."""
    found = result["leave_one_out"]
    if found is None:
        return "<p>No leave-one-out error: too few points.</p>"
    heads, *rows = transfers_rows(found)
    said = rectification_verdict(found, result["rectification"] is not None)
    table = _table(heads, [list(row) for row in rows])
    return f"<p>{html.escape(transfers_heading(found))}.</p>{table}" + (f"<p>{said}.</p>" if said else "")


def _suspects(result: dict) -> str:
    """Points that are likely wrong, and kinds of errors about which no decision is possible."""
    found = [suspect_in_words(suspect, len(result["frames"])) for suspect in result["suspects"]]
    rows = [[html.escape(words) for words in each] for each in found]
    undecided = "".join(f"<p>Undecided: {html.escape(why)}.</p>" for why in result["undecided"])
    return (_table(("points", "likely", "score"), rows) if rows else "<p>None.</p>") + undecided


def _mirrored(frames: Sequence[dict]) -> str:
    """How many frames have fits that reflect, and what that means; nothing if none has."""
    count = sum(bool(frame["mirrored"]) for frame in frames)
    return f"<p>{count} of {len(frames)} frames mirrored: {MIRRORED}.</p>\n" if count else ""


def _numbers(frame: dict) -> list[str]:
    keys = "rms_px", "condition", "flatness"
    return [_E(frame), *("–" if frame[key] is None else f"{frame[key]:.4g}" for key in keys)]


def _E(frame: dict) -> str:
    """With a mark if the fit reflects."""
    if frame["E"] is None:
        return "–"
    return f"{frame['E']:.4g}" + (" (mirrored)" if frame["mirrored"] else "")


def _table(heads: tuple[str, ...], rows: list[list[str]]) -> str:
    head = "".join(f"<th>{cell}</th>" for cell in heads)
    return (
        f"<table><tr>{head}</tr>"
        + "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
        + "</table>"
    )


def named_coefficients(frame: dict) -> dict:
    """With the fundamental matrices by pair and coefficient."""
    if frame["fundamental"] is None:
        return frame
    named = {
        f"{VIEW_NAMES[p]},{VIEW_NAMES[q]}": dict(zip(COEFFICIENTS, f.tolist()))
        for (p, q), f in zip(PAIRS, frame["fundamental"])
    }
    return frame | {"fundamental": named}


MAX_NAMED_FRAMES = 6  # frames that are named in words


def suspects_json(report: OutlierReport, points: Sequence[str], numbers: Sequence[int]) -> list[dict]:
    """The outliers as JSON has them. points: names; numbers: of the frames. Only swapped points have E, E_swapped."""
    return [
        {
            "kind": one.kind,
            "points": [points[k] for k in one.points],
            "views": [VIEW_NAMES[view] for view in one.views],
            "frames": [numbers[k] for k in one.frames],
            "score": one.score,
            **({"E": one.E, "E_swapped": one.E_swapped} if one.kind == "swapped" else {}),
        }
        for one in report.found
    ]


def suspect_in_words(suspect: dict, frames: int) -> tuple[str, str, str]:
    """Describe suspected points, their fault and the evidence. frames: their number."""
    named, where = " and ".join(suspect["points"]), " or ".join(suspect["views"])
    if suspect["kind"] == "swapped":
        falls = f"E {suspect['E']:.3g} px², {suspect['E_swapped']:.3g} px² permuted: falls {suspect['score']:.3g} times"
        return named, f"swapped in {where.replace(' or ', ', ')}", falls
    seen = suspect["frames"]
    those = ", ".join(map(str, seen[:MAX_NAMED_FRAMES])) + (" …" if len(seen) > MAX_NAMED_FRAMES else "")
    which = f"frame {those}" if len(seen) == 1 else f"{len(seen)} of {frames} frames: {those}"
    return named, f"misplaced in {where}", f"{suspect['score']:.3g} standard deviations of the others off; {which}"


def transfers_json(found: LeaveOneOut) -> dict | None:
    """As JSON has it, px rms by transfer; None if nothing was predicted."""
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


def transfers_heading(found: dict) -> str:
    """Of the table below."""
    predictions, frames = (_of(found[what], found[f"of_{what}"]) for what in ("predictions", "frames"))
    sampled = ", evenly spaced" if found["sampled"] else ""
    plural = "" if found["of_frames"] == 1 else "s"
    return f"leave-one-out error, rms px: {predictions} predictions in {frames} frame{plural}{sampled}"


def transfers_rows(found: dict) -> Iterator[tuple[str, ...]]:
    """Names of the columns, then a row a transfer."""
    columns = [found["error_px"]] if found["rectified_px"] is None else [found["error_px"], found["rectified_px"]]
    yield ("transfer", "images as they are", "rectified")[: 1 + len(columns)]
    for name in found["error_px"]:
        yield name, *(f"{column[name]:.3g}" for column in columns)


def rectification_verdict(found: dict | None, rectified: bool) -> str | None:
    """Whether images are rectified, and why. None if that was not asked, or there is nothing to rectify."""
    if found is None or found["rectified_px"] is None:
        return "images rectified: their matches ask for it" if rectified else None
    how, ratio = "rectified" if rectified else "left as they are", found["rectified_ratio"]
    if ratio is None:
        large = "errors this large are of arms in different postures, or of magnified noise"
        return f"images {how}, as their matches ask; {large}"
    what = f"{JUDGE} is {ratio:.2g} times as far off if rectified, {found['rectified_ratio_bound']:.2g} at most"
    return f"images {how}: {what}; less than {MAX_RATIO:g} asks for it"


def _of(count: int, whole: int) -> str:
    return f"{count:,}" if count == whole else f"{count:,} of {whole:,}"


def print_report(result: dict) -> None:
    how = "" if result["rectification"] is None else ", images rectified"
    count = len(result["frames"])
    print(
        f"{result['transfer']} transfer{how}, {len(result['points'])} points, {count} frame{'' if count == 1 else 's'}"
    )
    if named := result.get("naming"):
        print(f"names: {naming_words(named)}")
        if named["accepted"]:
            print(f"  {', '.join(f'{own} = {demo}' for own, demo in named['names'].items() if demo is not None)}")
            at = posture(named["posture_deg"]) if "posture_deg" in named else _without_unit(named["posture"])
            print(f"  the demonstrator of frame {named['frame']} is at {at}")
    if misfit := result.get("misfit"):
        print(f"misfit: {misfit['text']} (frame {misfit['frame']})")
    width = max(7, *(2 + len(str(frame["frame"])) for frame in result["frames"]))
    print(f"{'frame':>{width}}{'usable':>8}{'E px²':>12}{'rms px':>9}{'condition':>11}{'flatness':>10}")
    for frame in result["frames"]:
        numbers = [
            "–" if frame[key] is None else f"{frame[key]:{form}}"
            for key, form in (("E", ".4g"), ("rms_px", ".3g"), ("condition", ".3g"), ("flatness", ".3g"))
        ]
        print(
            f"{frame['frame']:>{width}}{len(frame['usable']):>8}{numbers[0]:>12}{numbers[1]:>9}{numbers[2]:>11}{numbers[3]:>10}"
            + ("  mirrored" if frame["mirrored"] else "")
        )
    _report_transfers(result)
    _report_suspects(result)
    first = next((frame for frame in result["frames"] if frame["E"] is not None), None)
    if first is None:
        return
    print(f"affine fundamental matrices of frame {first['frame']}: f13 x + f23 y + f31 x' + f32 y' + f33 = 0")
    for pair, f in named_coefficients(first)["fundamental"].items():
        print(f"  {pair:<20}  " + "".join(f"{name} {value:9.4f}  " for name, value in f.items()).rstrip())


def _without_unit(angles: Sequence[float]) -> str:
    return f"({', '.join(f'{angle:.4g}' for angle in angles)}) in the unit of --postures"


def _report_transfers(result: dict) -> None:
    found = result["leave_one_out"]
    if found is None:
        print(f"leave-one-out error: none, as no frame has {MIN_POINTS + 1} points that tell a transfer")
    else:
        print(transfers_heading(found))
        for name, *cells in transfers_rows(found):
            print(f"  {name:<11}" + "".join(f"{cell:>20}" for cell in cells))
    if said := rectification_verdict(found, result["rectification"] is not None):
        print(f"  {said}")


def _report_suspects(result: dict) -> None:
    found = [suspect_in_words(suspect, len(result["frames"])) for suspect in result["suspects"]]
    print("suspects" if found else "suspects: none")
    for named, what, score in found:
        print(f"  {escape(named, 2 * MAX_NAME_CHARS)}  {what}: {score}")
    for why in result["undecided"]:
        print(f"  undecided: {why}")

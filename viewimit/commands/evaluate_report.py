"""A report of tracked points: one HTML file without any other, or a PNG."""

import html
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..drawing.export import figures
from ..drawing.images.tracked import draw_view, draw_views
from ..estimation.views import VIEW_NAMES
from . import evaluate_suspects, evaluate_transfers

MIRRORED = (
    "the fit is a reflection, and one head sees no body as its own mirror image, so that a small E is no good fit; "
    "left and right may stand in each other's place in the views of one body"
)
FORMATS = (".html", ".png")
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
    if suffix == ".png":
        figures.require_renderer(path, ".html")


def write(path: Path, result: dict) -> None:
    """`first`, the first frame that has an E, is drawn; HTML lists all. Raises OSError."""
    frame = result["first"]
    if path.suffix.lower() == ".png":
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
    heads, *rows = evaluate_transfers.rows(found)
    said = evaluate_transfers.verdict(found, result["rectification"] is not None)
    table = _table(heads, [list(row) for row in rows])
    return f"<p>{html.escape(evaluate_transfers.heading(found))}.</p>{table}" + (f"<p>{said}.</p>" if said else "")


def _suspects(result: dict) -> str:
    """Points that are likely wrong, and of what nothing is told."""
    found = [evaluate_suspects.in_words(suspect, len(result["frames"])) for suspect in result["suspects"]]
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

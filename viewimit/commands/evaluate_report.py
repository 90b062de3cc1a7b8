"""A report of tracked points: one HTML file without any other, or a PNG by matplotlib."""

import html
import importlib.util
from pathlib import Path

import numpy as np

from ..views import VIEWS

FORMATS = (".html", ".png")
TITLES = {"l": "[l] demonstrator", "r": "[r] demonstrator", "L": "[L] learner", "R": "[R] learner"}
SEEN, RECOVERED, RESIDUAL = "#0072b2", "#007f5c", "#d55e00"
MARGIN = 0.08  # of the points' extent around them
STYLE = """body { font: 15px system-ui, sans-serif; margin: 2em auto; max-width: 70em; color: #1b2430 }
svg { width: 48%; border: 1px solid #dde1e7; margin: 0.4%; vertical-align: top }
table { border-collapse: collapse; margin: 1em 0 } td, th { padding: 0.2em 0.8em; text-align: right }
tr:nth-child(even) { background: #f4f6f9 }"""


def require_format(path: Path) -> None:
    """Raises ValueError before any work is done."""
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise ValueError(f"{path}: unknown extension {suffix!r}; there are {', '.join(FORMATS)}")
    if suffix == ".png" and importlib.util.find_spec("matplotlib") is None:
        raise ValueError(f"{path}: .png needs matplotlib: pip install 'viewimit[plot]'")


def write(path: Path, result: dict) -> None:
    """The first frame that has an E is drawn; HTML lists all. Raises OSError."""
    frame = next(frame for frame in result["frames"] if frame["E"] is not None)
    if path.suffix.lower() == ".png":
        _draw(path, result, frame)
    else:
        path.write_text(_page(result, frame), encoding="utf-8")


def _page(result: dict, frame: dict) -> str:
    panels = "".join(_panel(frame, view) for view in VIEWS)
    heads = ("frame", "usable points", "E (px²)", "rms (px)", "condition", "flatness")
    rows = [[str(each["frame"]), str(len(each["usable"])), *_numbers(each)] for each in result["frames"]]
    residuals = []
    for k, name in enumerate(frame["usable"]):
        away = [np.linalg.norm(frame["seen"][view][k] - frame["recovered"][view][k]) for view in ("L", "R")]
        residuals.append([html.escape(name), *(f"{px:.3f}" for px in away)])
    matrices = [[pair, *(f"{value:.5g}" for value in f.values())] for pair, f in frame["fundamental"].items()]
    return f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>viewimit evaluate</title>
<style>{STYLE}</style>
<h1>Tracked points, {result["transfer"]} transfer</h1>
<p>Frame {frame["frame"]}: <span style="color:{SEEN}">● seen</span>, <span style="color:{RECOVERED}">+ recovered from
[l], [r]</span>, <span style="color:{RESIDUAL}">residual e</span>. Pixels; E = {frame["E"]:.4g} px².</p>
{panels}
<h2>Frames</h2>{_table(heads, rows)}
<h2>Residuals of frame {frame["frame"]} (px)</h2>{_table(("point", "in [L]", "in [R]"), residuals)}
<h2>Affine fundamental matrices of frame {frame["frame"]}</h2>
{_table(("pair", "f13", "f23", "f31", "f32", "f33 (px)"), matrices)}
</html>
"""


def _numbers(frame: dict) -> list[str]:
    keys = "E", "rms_px", "condition", "flatness"
    return ["–" if frame[key] is None else f"{frame[key]:.4g}" for key in keys]


def _table(heads: tuple[str, ...], rows: list[list[str]]) -> str:
    head = "".join(f"<th>{cell}</th>" for cell in heads)
    return (
        f"<table><tr>{head}</tr>"
        + "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
        + "</table>"
    )


def _panel(frame: dict, view: str) -> str:
    seen, recovered = frame["seen"][view], frame["recovered"].get(view)
    everything = seen if recovered is None else np.concatenate([seen, recovered])
    low, high = everything.min(0), everything.max(0)
    margin = MARGIN * max(*(high - low), 1.0)
    (x, y), (width, height) = low - margin, high - low + 2 * margin
    unit = max(width, height) / 100
    drawn = [f'<text x="{x + unit:.2f}" y="{y + 5 * unit:.2f}" font-size="{4 * unit:.2f}">{TITLES[view]}</text>']
    for k, name in enumerate(frame["usable"]):
        u, v = seen[k]
        if recovered is not None:
            a, b = recovered[k]
            drawn.append(_line(u, v, a, b, RESIDUAL, unit / 2))
            drawn.append(_line(a - unit, b, a + unit, b, RECOVERED, unit / 3))
            drawn.append(_line(a, b - unit, a, b + unit, RECOVERED, unit / 3))
        drawn.append(f'<circle cx="{u:.2f}" cy="{v:.2f}" r="{0.8 * unit:.2f}" fill="{SEEN}"/>')
        at = f'x="{u + unit:.2f}" y="{v - unit:.2f}" font-size="{3 * unit:.2f}"'
        drawn.append(f"<text {at}>{html.escape(name)}</text>")
    return f'<svg viewBox="{x:.2f} {y:.2f} {width:.2f} {height:.2f}">{"".join(drawn)}</svg>\n'


def _line(x: float, y: float, a: float, b: float, colour: str, width: float) -> str:
    ends = f'x1="{x:.2f}" y1="{y:.2f}" x2="{a:.2f}" y2="{b:.2f}"'
    return f'<line {ends} stroke="{colour}" stroke-width="{width:.2f}"/>'


def _draw(path: Path, result: dict, frame: dict) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 7), layout="constrained")
    figure.suptitle(f"frame {frame['frame']}, {result['transfer']} transfer, E = {frame['E']:.4g} px²")
    for axes, view in zip(figure.subplots(2, 2).ravel(), VIEWS):
        seen, recovered = frame["seen"][view], frame["recovered"].get(view)
        axes.plot(*seen.T, "o", color=SEEN, label="seen")
        if recovered is not None:
            axes.plot(*np.stack([seen, recovered]).transpose(2, 0, 1), color=RESIDUAL)
            axes.plot(*recovered.T, "+", color=RECOVERED, markersize=9, label="recovered")
        for name, (u, v) in zip(frame["usable"], seen):
            axes.annotate(name, (u, v), xytext=(4, 4), textcoords="offset points", fontsize=7)
        axes.set(title=TITLES[view], xlabel="x (px)", ylabel="y (px)", aspect="equal")
        axes.invert_yaxis()
        axes.legend(fontsize=7)
    figure.savefig(path, dpi=150)

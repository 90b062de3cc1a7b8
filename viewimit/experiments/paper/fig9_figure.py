"""Fig. 9 on the page: joint angles and E over the motions, on a logarithmic axis, for one law takes 9 and one 3000."""

import numpy as np
from numpy.typing import NDArray

from ...drawing import svg
from ...drawing.plots import Axes, Style, decade_ticks, decades, figure, log10, sentence, style_of
from ...servo import SERVOS
from ...simulation.scene import Scene
from .fig9 import BESIDE, MOTIONS, PAPERS_LAWS, Fig9, Run

SENTENCE = (
    "Three laws, seven starts each: which",
    "arrive at the demonstrator's posture,",
    "and after how many motions?",
)
LEFT, RIGHT, LEGEND = 36, 276, 288  # px
ANGLES, CONFLICT = (30, 106), (130, 194)  # px from top to bottom
TICKS = [(motions, str(motions)) for motions in (0, 1, 3, 10, 30, 100, 300, 1000, 3000)]
VERTICES, FAINT_VERTICES = 160, 40
SMALLEST_E, LARGEST_E = 1.0, 100.0  # px² that the axis shows in any case
FLOOR_E = 1e-3  # px² below which it is drawn as this: nobody could see that conflict


def draw(scene: Scene, found: Fig9 | None = None) -> str:
    """found: what is there so far."""
    angles, conflict = _plots(scene, found)
    parts = [_frames(scene, angles, conflict, found)]
    if found is None:
        return figure(None, "".join(parts) + sentence(SENTENCE, (LEFT + RIGHT) / 2, 68) + _legend(None))
    parts += [angles.level(angle, "vi-line-demo") for angle in found.settings.demonstrator_deg or ()]
    if found.E_demo > 0:
        parts.append(conflict.level(max(found.E_demo, FLOOR_E), "vi-line-demo"))
    runs = [(k, run) for law in found.laws for k, run in enumerate(found.of(law))]
    near = found.near_deg
    for k, run in sorted(runs, key=lambda ranked: ranked[0] == 0):  # those from the first start lie over the others
        parts.append(_run(angles, conflict, run, bool(run.error_deg[-1] <= near), faint=k > 0))
    parts.append(_values(conflict, [run for k, run in runs if k == 0]))
    return figure(found.settings, "".join(parts) + _legend(found))


def _plots(scene: Scene, found: Fig9 | None) -> tuple[Axes, Axes]:
    low, high = np.min(scene.range_deg), np.max(scene.range_deg)
    E = np.concatenate([run.E for run in found.runs]) if found and found.runs else np.empty(0)
    if found is not None:
        E = np.maximum(np.append(E, found.E_demo), FLOOR_E)
    x = (0.0, float(max(MOTIONS, *(len(run.E) - 1 for run in (found.runs if found else ())), 0)))
    return (
        Axes((LEFT, ANGLES[0], RIGHT, ANGLES[1]), x, (float(low), float(high)), np.log1p),
        Axes((LEFT, CONFLICT[0], RIGHT, CONFLICT[1]), x, decades(E, SMALLEST_E, LARGEST_E), np.log1p, log10),
    )


def _frames(scene: Scene, angles: Axes, conflict: Axes, found: Fig9 | None) -> str:
    names = [svg.joint_symbol(joint) for joint in scene.moving_joints]
    if found and len(names) <= 3:
        names = [f"{name} {svg.number(angle, 0)}°" for name, angle in zip(names, found.settings.demonstrator_deg or ())]
    low, high = angles.y
    degrees = [(angle, svg.number(angle, 0) + "°") for angle in np.arange(90 * np.ceil(low / 90), high + 1, 90)]
    return (
        angles.frame("Joint angles", f"dashed = demonstrator, {', '.join(names)}", (), degrees)
        + conflict.frame("Conflict E", "px², log; dashed = in its posture", TICKS, decade_ticks(*conflict.y, 3))
        + svg.text(RIGHT + 20, CONFLICT[1] + 13, "motions, log", "vi-2nd")
    )


def _run(angles: Axes, conflict: Axes, run: Run, arrived: bool, faint: bool) -> str:
    style = _style(run.law)
    kept = _thinned(len(run.E), FAINT_VERTICES if faint else VERTICES)
    classes = style.line + (" vi-x-faint" if faint else "")
    lines = [(angles, angle) for angle in run.theta_deg.T] + [(conflict, np.maximum(run.E, FLOOR_E))]
    drawn = "".join(plot.line(kept, values[kept], classes) for plot, values in lines)
    if not faint:
        ends = np.concatenate([plot.place(kept[-1:], values[-1:]) for plot, values in lines])
        drawn += _ends(style, ends, arrived)
    return drawn


def _style(law: str) -> Style:
    """What stands beside the paper's laws has the plainest line."""
    return style_of(law if law in PAPERS_LAWS else BESIDE, (BESIDE, *PAPERS_LAWS[::-1]))


def _ends(style: Style, places: NDArray, good: bool) -> str:
    """What has not arrived ends in crosses."""
    if good:
        return style.marks(places)
    places = places[np.isfinite(places).all(-1)]
    form = "M%.1f %.1fm-3.5-3.5l7 7m0-7l-7 7" * len(places)
    return f'<path class="vi-x-off-mark" d="{form % tuple(places.ravel().tolist())}"/>'


def _values(conflict: Axes, runs: list[Run]) -> str:
    """E where the runs ended, beside the plot."""
    ended = sorted(
        (float(conflict.place(0, max(run.E[-1], FLOOR_E))[1]), k) for k, run in enumerate(runs) if run.E[-1] > 0
    )
    parts, above = [], -np.inf
    for rank, (y, k) in enumerate(ended):
        above = max(min(y, conflict.bottom - 13 * (len(ended) - 1 - rank)), above + 13)
        style, words = _style(runs[k].law), f"E {svg.short_E(runs[k].E[-1], 10)} px²"
        parts.append(svg.text(LEGEND, above, words, f"vi-x-of-{style.role}"))
    return "".join(parts)


def _legend(found: Fig9 | None) -> str:
    """A law: its line, from how many starts it came near, and how soon; or how far off it is still."""
    parts = []
    for k, law in enumerate(found.laws if found else (*PAPERS_LAWS, BESIDE)):
        y, runs = ANGLES[0] + 4 + 31 * k, found.of(law) if found else []
        parts.append(_style(law).sample(LEGEND, y))
        parts.append(svg.text(LEGEND + 27, y + 4, SERVOS[law].title, "vi-b"))
        for words, classes in [_outcome(runs, found.near_deg)] if found and runs else []:
            parts.append(svg.text(LEGEND + 27, y + 18, words, classes))
    return "".join(parts)


def _outcome(runs: list[Run], near: float) -> tuple[str, str]:
    counts = [run.motions_until(near) for run in runs]
    reached = [count for count in counts if count is not None]
    if not reached:
        off = np.min([run.error_deg[-1] for run in runs])
        return f"0 of {len(runs)}, best {svg.number(off, 0)}° off", "vi-x-off"
    return f"{len(reached)} of {len(runs)}, median {np.median(reached):.0f}", "vi-2nd"


def _thinned(count: int, limit: int) -> NDArray:
    """Motions at even distances of the logarithmic axis."""
    return np.unique(np.expm1(np.linspace(0, np.log1p(count - 1), limit)).round().astype(int))

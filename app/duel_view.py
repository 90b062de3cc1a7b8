"""The tab Duel: both learners' landscapes with their paths, their errors over the motions, who arrived first."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from viewimit.scene import Scene
from viewimit.session import Session
from viewimit.snapshot import Snapshot

from . import svg
from .duel import ARRIVED_DEG, Standing
from .methods import SERVO_NOTES, TRANSFER_NOTES
from .plots import Plot, Style, decade_ticks, decades, log10
from .posture_plane import PosturePlane
from .small_landscape import WIDTH as COLUMN
from .small_landscape import Studied, draw_small, small_plane

GAP = 10
WIDTH = 2 * COLUMN + GAP
TOP, MOST_HIGH = 19, 86  # px of the plots
BELOW = 30  # px from the plots to the words beneath
HEIGHT = TOP + MOST_HIGH + BELOW + 43
ROLES = ("learner", "opponent")
STYLES = (Style("learner", "solid", "circle"), Style("opponent", "dashed", "square"))
LEAST_DEG = 1e-3  # of the axis of errors
LIMIT = 240  # vertices of a curve or path
STATES = {"ready": "at the start", "moving": "still moving"}
SENTENCE = "Two learners, one start, one demonstrator: which method arrives first?"
WHY = "Choose the opponent's transfer and servo, then begin. Both are stepped motion for motion."


def draw_ground(scene: Scene, studied: Sequence[Studied], theta_demo: NDArray) -> str:
    """HTML of what lies under the paths. studied: the learner's and the opponent's transfer, none while computed."""
    parts = []
    for k in range(2):
        plane = small_plane(scene, MOST_HIGH)
        inside = plane.frame("vi-plane") + plane.message("computing …") + plane.ends()
        if studied:
            inside = draw_small(plane, studied[k], theta_demo)
        parts.append(_column(k, inside))
    return _wrap("".join(parts))


def draw_empty_ground() -> str:
    """Under a plot of errors, where there are no landscapes."""
    return _wrap("")


def draw_empty() -> str:
    """Before a duel."""
    y = HEIGHT / 2
    words = svg.text(WIDTH / 2, y - 12, SENTENCE, "vi-mid vi-b") + svg.text(WIDTH / 2, y + 8, WHY, "vi-2nd vi-mid")
    return _wrap(words)


def draw_race(scene: Scene, sessions: Sequence[Session], standings: Sequence[Standing]) -> str:
    """HTML over the ground: names, paths or errors, standings, the sentence."""
    plane, parts = small_plane(scene, MOST_HIGH), []
    for k, standing in enumerate(standings):
        inside = _path(plane, sessions[k], k) if plane.has_plane else ""
        parts.append(_column(k, inside) + _words(standing, k))
    if not plane.has_plane:
        parts.append(draw_errors(standings))
    parts.append(svg.text(0, HEIGHT - 3, verdict(standings), "vi-b"))
    return f'<div class="vi-over">{_wrap("".join(parts))}</div>'


def draw_errors(standings: Sequence[Standing]) -> str:
    """Largest joint error over the motions, both in one plot."""
    errors = [np.array(standing.errors_deg) for standing in standings]
    everything = np.maximum(np.concatenate(errors), LEAST_DEG)
    low, high = decades(everything, 0.1, 10.0)
    last = max(4, *(len(each) - 1 for each in errors))
    plot = Plot(36, TOP + 14, WIDTH - 8, TOP + MOST_HIGH + 2, (0, last), (low, high), up=log10)
    ticks = sorted({0, last // 2, last})
    parts = [
        plot.frame(
            "Largest joint error",
            f"degrees, log; dashed rule: {ARRIVED_DEG:g}°",
            [(tick, str(tick)) for tick in ticks],
            [(value, f"{words}°") for value, words in decade_ticks(low, high, 3)],
            36,
        ),
        plot.level(ARRIVED_DEG, "vi-cursor"),
    ]
    for k in (1, 0):
        kept = svg.thinned(len(errors[k]), LIMIT)
        x, y = np.array(kept, float), np.maximum(errors[k][list(kept)], LEAST_DEG)
        parts.append(plot.line(x, y, STYLES[k].line))
        parts.append(STYLES[k].marks(plot.place(x[-1:], y[-1:])))
    return f'<g transform="translate(0 -14)">{"".join(parts)}</g>'


def draw_errors_alone(standings: Sequence[Standing]) -> str:
    """HTML, beneath the landscapes where there is room."""
    top = TOP - 14
    inside = f'<g transform="translate(0 {-top})">{draw_errors(standings)}</g>'
    return f'<div class="vi-panel"><svg class="vi" viewBox="0 0 {WIDTH} {MOST_HIGH + 20}">{inside}</svg></div>'


def verdict(standings: Sequence[Standing]) -> str:
    """Who came within ARRIVED_DEG first. It is the viewer's: a learner cannot know."""
    own, other = (standing.arrived for standing in standings)
    within = f"within {ARRIVED_DEG:g}° of the demonstrator"
    if own is None and other is None:
        if all(_rests(standing.snapshot) for standing in standings):
            return f"Neither came {within}."
        return f"Nobody is {within} yet."
    if own is not None and other is not None:
        if own == other:
            return f"A tie: both were {within} after {_motions(own)}."
        first, early, late = ("The learner", own, other) if own < other else ("The opponent", other, own)
        return f"{first} was {within} first: after {_motions(early)} against {late}."
    first, early, k = ("The learner", own, 1) if other is None else ("The opponent", other, 0)
    rest = "never came" if _rests(standings[k].snapshot) else "is not"
    loser = "the opponent" if k else "the learner"
    return f"{first} was {within} after {_motions(early)}; {loser} {rest}{' there' if rest == 'is not' else ''}."


def _words(standing: Standing, k: int) -> str:
    """Title above a column; motions, error, E and state beneath."""
    snapshot, x = standing.snapshot, k * (COLUMN + GAP)
    settings = snapshot.settings
    name = f"{TRANSFER_NOTES[settings.transfer].name} · {SERVO_NOTES[settings.servo].name}"
    y = TOP + MOST_HIGH + BELOW
    first = f"{_motions(snapshot.motion)}, {_state(snapshot)}"
    second = f"largest error {_short(standing.errors_deg[-1])}°, E {_short(snapshot.E)} px²"
    return (
        STYLES[k].sample(x, 8)
        + svg.text(x + 28, 12, name, f"vi-x-of-{ROLES[k]} vi-b")
        + svg.text(x, y, first, "vi-b")
        + svg.text(x, y + 15, second)
    )


def _path(plane: PosturePlane, session: Session, k: int) -> str:
    """The motions up to the present, with the mark of that learner at their end."""
    kept = svg.thinned(session.cursor + 1, LIMIT)
    points = plane.place(np.degrees(np.array([session.history[i].theta for i in kept])))
    (x, y), line = points[-1], ("vi-line-own", "vi-line-opponent")[k]
    now = f'<circle class="vi-now" cx="{x:.1f}" cy="{y:.1f}" r="4.6"/>'
    if k:
        now = f'<rect class="vi-now-opponent" x="{x - 4.2:.1f}" y="{y - 4.2:.1f}" width="8.4" height="8.4"/>'
    return f'<path class="{line}" d="{svg.path(points)}"/>{now}'


def _column(k: int, inside: str) -> str:
    return f'<g transform="translate({k * (COLUMN + GAP)} {TOP})">{inside}</g>'


def _wrap(inside: str) -> str:
    return f'<div class="vi-panel"><svg class="vi vi-duel" viewBox="0 0 {WIDTH} {HEIGHT}">{inside}</svg></div>'


def _rests(snapshot: Snapshot) -> bool:
    return snapshot.status in ("converged", "stalled", "stopped")


def _state(snapshot: Snapshot) -> str:
    return STATES.get(snapshot.status, snapshot.status)


def _motions(count: int) -> str:
    return "1 motion" if count == 1 else f"{count} motions"


def _short(value: float) -> str:
    return svg.number(value, 2 if value < 10 else 1 if value < 100 else 0)

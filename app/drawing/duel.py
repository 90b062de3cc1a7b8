"""The tab Duel: both learners' landscapes with their paths, their errors over the motions, and who arrived first."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.landscape import Landscape
from viewimit.drawing import svg
from viewimit.drawing.landscape import SMALL_WIDTH as COLUMN
from viewimit.drawing.landscape import draw_small, small_plane
from viewimit.drawing.plots import Axes, Style, decade_ticks, decades, log10
from viewimit.drawing.posture_plane import PosturePlane
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot
from viewimit.servo import SERVOS, ServoStatus, verdicts
from viewimit.simulation.scene import Scene
from viewimit.wording import sentences

GAP = 10
WIDTH = 2 * COLUMN + GAP
TOP, MAX_HEIGHT = 32, 86  # px of the plots
BELOW = 28  # px from the plots to the words below
COLUMNS = (0, 54, 136)  # px of the numbers below
HEIGHT = TOP + MAX_HEIGHT + BELOW + 78
ROLES = ("learner", "opponent")
STYLES = (Style("learner", "solid", "circle"), Style("opponent", "dashed", "square"))
LEFT = 44  # px of the plot of errors
MIN_ERROR_DEG = 1e-3  # on the axis of errors
MAX_VERTICES = 240  # of a curve or path
ONE_DIGIT_TO = 100  # numbers below have no decimals from here, so that they do not touch
CLASSES = ("own", "opponent")
NAMES = ("Learner", "Opponent")
ON_ITS_WAY = (ServoStatus.REHEARSING, ServoStatus.MOVING)
SENTENCE = "Two learners, one start, one demonstrator: which method arrives first?"
WHY = "Choose the opponent's transfer and servo above, then begin.\nBoth start at the same place and move step by step."
ARRIVED_DEG = 1.0  # largest joint error of a learner that has arrived


@dataclass(frozen=True)
class Standing:
    """How one learner stands in the race."""

    snapshot: Snapshot
    errors_deg: Sequence[float]  # largest joint error after each motion
    arrived: int | None  # motions until it was first within ARRIVED_DEG; None if it has not been


def draw_ground(scene: Scene, found: Sequence[Landscape], theta_demo: NDArray[np.float64]) -> str:
    """Draw what lies under the paths, as HTML. found: landscapes of both transfers; empty while they are computed."""
    parts = []
    for k in range(2):
        plane = small_plane(scene, MAX_HEIGHT)
        inside = plane.frame("vi-plane") + plane.message("computing …") + plane.ends()
        if found:
            inside = draw_small(plane, found[k], found[k].minimum[None], theta_demo)
        parts.append(_column(k, inside))
    return wrap("".join(parts))


def draw_empty() -> str:
    """Draw the tab before a duel."""
    y = HEIGHT / 2
    why = (svg.text(WIDTH / 2, y + 15 * k, line, "vi-2nd vi-mid") for k, line in enumerate(WHY.split("\n")))
    return wrap(svg.text(WIDTH / 2, y - 22, SENTENCE, "vi-mid vi-b") + "".join(why))


def draw_race(scene: Scene, racers: Sequence[Session], standings: Sequence[Standing], playing: bool = True) -> str:
    """Draw what lies over the ground, as HTML: names, paths or errors, standings, and the verdict, large."""
    plane, parts = small_plane(scene, MAX_HEIGHT), []
    for k, standing in enumerate(standings):
        inside = _path(plane, racers[k], k) if plane.has_plane else ""
        parts.append(_column(k, inside) + _words(standing, k))
    if not plane.has_plane:
        parts.append(draw_errors(standings))
    for k, line in enumerate(verdict(standings, playing)):
        parts.append(svg.text(0, HEIGHT - 22 + 18 * k, line, "" if k else "vi-verdict"))
    return f'<div class="vi-over">{wrap("".join(parts))}</div>'


def draw_errors(standings: Sequence[Standing]) -> str:
    """Draw the largest joint errors of both over the motions."""
    errors = [np.array(standing.errors_deg) for standing in standings]
    everything = np.maximum(np.concatenate(errors), MIN_ERROR_DEG)
    low, high = decades(everything, 0.1, 10.0)
    last = max(4, *(len(each) - 1 for each in errors))
    plot = Axes(LEFT, TOP + 19, WIDTH - 8, TOP + MAX_HEIGHT, (0, last), (low, high), up=log10)
    steps = [(tick, str(tick)) for tick in sorted({0, last // 2, last})]
    degrees = [(value, f"{words}°") for value, words in decade_ticks(low, high, 3)]
    parts = [plot.frame("Largest joint error", "log, over the steps", steps, degrees, LEFT)]
    parts.append(plot.level(ARRIVED_DEG, "vi-cursor"))
    for k in (1, 0):
        kept = svg.thinned(len(errors[k]), MAX_VERTICES)
        x, y = np.array(kept, float), np.maximum(errors[k][list(kept)], MIN_ERROR_DEG)
        parts.append(plot.line(x, y, STYLES[k].line))
        parts.append(STYLES[k].marks(plot.place(x[-1:], y[-1:])))
    return "".join(parts)


def draw_errors_alone(standings: Sequence[Standing]) -> str:
    """Draw the errors as HTML, to stand below the landscapes."""
    inside = f'<g transform="translate(0 {-TOP})">{draw_errors(standings)}</g>'
    return f'<div class="vi-panel"><svg class="vi" viewBox="0 0 {WIDTH} {MAX_HEIGHT + 20}">{inside}</svg></div>'


def verdict(standings: Sequence[Standing], playing: bool = True) -> tuple[str, str]:
    """Say who came within ARRIVED_DEG first, and how the other fared; no learner can know it."""
    own, other = (standing.arrived for standing in standings)
    aim = f"within {ARRIVED_DEG:g}°"
    if own is None and other is None:
        have_ended = all(standing.snapshot.status.has_ended for standing in standings)
        words = f"came {aim} of the demonstrator" if have_ended else f"is {aim} of the demonstrator yet"
        return f"Neither {words}.", _whereabouts(standings, (0, 1), playing)
    if own is not None and own == other:
        return f"A tie: both were {aim} of the demonstrator after {svg.count_motions(own)}.", ""
    first = 0 if other is None or (own is not None and own < other) else 1
    soonest = min(count for count in (own, other) if count is not None)
    won = f"The {NAMES[first].lower()} was first {aim}, after {svg.count_motions(soonest)}."
    late = standings[1 - first].arrived
    if late is None:
        return won, _whereabouts(standings, (1 - first,), playing)
    return won, f"The {NAMES[1 - first].lower()} followed after {svg.count_motions(late)}."


def _whereabouts(standings: Sequence[Standing], which: Sequence[int], playing: bool) -> str:
    said = []
    for k in which:
        status = standings[k].snapshot.status
        label = verdicts()[status].label if playing or status not in ON_ITS_WAY else "Paused"
        said.append(f"{NAMES[k]}: {label}, {svg.short(standings[k].errors_deg[-1], ONE_DIGIT_TO)}° off.")
    return sentences(*said)


def _words(standing: Standing, k: int) -> str:
    """Draw the title above a column, and motions, error and E below."""
    snapshot, x = standing.snapshot, k * (COLUMN + GAP)
    settings, y = snapshot.settings, TOP + MAX_HEIGHT + BELOW
    figures = (
        ("steps", str(snapshot.motion), ""),
        ("largest error", svg.short(standing.errors_deg[-1], ONE_DIGIT_TO), "°"),
        ("E", svg.short(snapshot.E, ONE_DIGIT_TO), " px²"),
    )
    parts = [
        STYLES[k].sample(x, 8),
        svg.text(x + 28, 12, f"{NAMES[k]}: {TRANSFERS[settings.transfer].title}", f"vi-of-{CLASSES[k]}"),
        svg.text(x + 28, 26, SERVOS[settings.servo].title, "vi-2nd"),
    ]
    for left, (label, value, unit) in zip(COLUMNS, figures):
        parts.append(svg.text(x + left, y, label, "vi-2nd"))
        number = f'<tspan class="vi-big">{value}</tspan><tspan class="vi-2nd">{unit}</tspan>'
        parts.append(f'<text x="{x + left}" y="{y + 20}">{number}</text>')
    return "".join(parts)


def _path(plane: PosturePlane, racer: Session, k: int) -> str:
    """Draw the motions up to the present, with the learner's mark at their end."""
    kept = svg.thinned_between(racer.cursor + 1, MAX_VERTICES, racer.cursor)
    points = plane.place(np.degrees(np.array([racer.history[i].theta for i in kept])))
    (x, y), line = points[-1], ("vi-line-own", "vi-line-opponent")[k]
    now = f'<circle class="vi-now" cx="{x:.1f}" cy="{y:.1f}" r="4.6"/>'
    if k:
        now = f'<rect class="vi-now-opponent" x="{x - 4.2:.1f}" y="{y - 4.2:.1f}" width="8.4" height="8.4"/>'
    return f'<path class="{line}" d="{svg.path(points)}"/>{now}'


def _column(k: int, inside: str) -> str:
    return f'<g transform="translate({k * (COLUMN + GAP)} {TOP})">{inside}</g>'


def wrap(inside: str) -> str:
    """Build a drawing of the tab, as HTML."""
    return f'<div class="vi-panel"><svg class="vi vi-duel" viewBox="0 0 {WIDTH} {HEIGHT}">{inside}</svg></div>'

"""The four image planes: their sizes, the arms in them, and the construction of the chosen point.

An arm covers a small part of its image, so a window shows the arm's whole range instead of the whole frame.

The construction is drawn completely, or stage by stage. If the transfer intersects epipolar lines, the stages are: the
point in l, its line, the point in r, the second line, the intersection, and the arrow to the own point. Other transfers
repeat the steps from the points' centroid.
"""

from base64 import b64encode
from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...analysis.construction import Construction
from ...estimation.views import FourViews
from ...geometry.arrays import Floats
from ...simulation.appearance import ArmImages
from .. import svg
from ..theme import RECOVERED

# width and height of each view's drawing, px, by whether whole frames are shown; two of l are as high as one of L
SIZES = {
    False: {"l": (80, 117), "r": (80, 117), "L": (150, 240), "R": (150, 240)},
    True: dict.fromkeys("lrLR", (210, 79)),
}
MARGIN = 12  # px of the drawing around the points, so that the edge cuts no ring
MIN_DIFFERENCE = 0.02  # in the share of points by which one corner is worse than another


class Window(NamedTuple):
    """The shown part of an image."""

    x: float  # px of the image, as y, w and h
    y: float
    w: float
    h: float
    scale: float  # px of the drawing per px of the image
    locator_left: bool  # whether the locator is in the left upper corner, as the arm is seen less there
    readout_left: bool  # whether the chosen point's residual is in the left lower corner


Windows = dict[bool, dict[str, Window]]


def image_windows(reach: Mapping[str, Floats], frame: tuple[int, int]) -> Windows:
    """Choose the windows of the four views, by whether whole frames are shown. reach: where points can be, (k, 2) px by
    view; frame: width and height of the images, px."""
    windows: Windows = {False: {}, True: {}}
    for whole, boxes in SIZES.items():
        for pair in ("lr", "LR"):
            spans = {view: np.array([(0, 0), frame], float) for view in pair}
            for view in pair:
                if not whole and len(reach[view]):
                    spans[view] = np.array([reach[view].min(0), reach[view].max(0)])
            around = 0 if whole else 2 * MARGIN
            rooms = ((np.array(boxes[view]) - around) / np.maximum(np.ptp(spans[view], 0), 1.0) for view in pair)
            scale = min(room.min() for room in rooms)
            sizes = {view: np.array(boxes[view]) / scale for view in pair}
            corners = {view: (low + high - sizes[view]) / 2 for view, (low, high) in spans.items()}
            free = _free_corners({view: (reach[view] - corners[view]) / sizes[view] for view in pair})
            for view in pair:
                x, y = corners[view].tolist()
                width, height = sizes[view].tolist()
                windows[whole][view] = Window(x, y, width, height, float(scale), *free)
    return windows


def holds(windows: Windows, points: Mapping[str, Floats]) -> bool:
    """Say whether the windows show all these points, (k, 2) px by view."""
    shown = windows[False]
    places = [(seen - shown[view][:2]) / shown[view][2:4] for view, seen in points.items()]
    return not any(((place < 0) | (place > 1)).any() for place in places)  # a hidden point, NaN, is nowhere else


def _free_corners(places: dict[str, Floats]) -> tuple[bool, bool]:
    """Say whether a pair's locator and readout are left. places: points, (k, 2), 0 … 1 over each window."""
    x, y = np.concatenate(list(places.values())).T
    share = lambda where: np.count_nonzero(where) / len(x)
    left, right, top, bottom = x < 0.35, x > 0.65, y < 0.1, y > 0.9
    locator = share(left & top) < share(right & top) - MIN_DIFFERENCE
    return bool(locator), bool(share(left & bottom) < share(right & bottom) + MIN_DIFFERENCE)


def image_points(views: FourViews) -> Floats:
    """Return all points by view, in the order lrLR, (4, N, 2) px."""
    return np.concatenate([views.demo, views.own], 1).reshape(-1, 4, 2).swapaxes(0, 1)


def placed(images: Floats, windows: Mapping[str, Window], views: str) -> Floats:
    """Convert points of images, (views, ..., 2) px, to px of each view's drawing."""
    corner, scale = _corners_and_scales(tuple([windows[view] for view in views]))
    shape = (len(views),) + (1,) * (images.ndim - 2)
    return (images - corner.reshape(shape + (2,))) * scale.reshape(shape + (1,))


@lru_cache(64)
def _corners_and_scales(windows: tuple[Window, ...]) -> tuple[Floats, Floats]:
    return np.array([window[:2] for window in windows]), np.array([window.scale for window in windows])


def draw_arm(arm: ArmImages, windows: Windows, whole: bool, views: str) -> dict[str, tuple[str, str]]:
    """Write path data of an arm's hulls and skeleton by view. The last result is cached with the arm."""
    kept = arm.memory.get(whole)
    if kept and kept[0] is windows:
        return kept[1]
    hulls, bones = placed(arm.hulls, windows[whole], views), placed(arm.origins, windows[whole], views)
    paths = dict(zip(views, zip(svg.polygons(hulls), svg.paths(bones))))
    arm.memory[whole] = windows, paths
    return paths


def photograph(jpeg: bytes, window: Window, frame: tuple[int, int]) -> str:
    """Place a picture of the whole frame, (width, height) px, so that the window's part fills the drawing."""
    k = window.scale
    return (
        f'<image class="vi-photograph" x="{-window.x * k:.2f}" y="{-window.y * k:.2f}" width="{frame[0] * k:.2f}"'
        f' height="{frame[1] * k:.2f}" preserveAspectRatio="none" decoding="sync"'
        f' href="data:image/jpeg;base64,{b64encode(jpeg).decode()}"/>'
    )


def plane(view: str, window: Window, whole: bool, frame: tuple[int, int], content: str) -> str:
    """Draw one image: background, the frame's border, clipped content, name, locator."""
    below, above = _plane(view, window, whole, frame)
    return f"{below}{content}{above}</svg>"


@lru_cache(256)
def _plane(view: str, window: Window, whole: bool, frame: tuple[int, int]) -> tuple[str, str]:
    """Draw the parts below the content and above it."""
    w, h = SIZES[whole][view]
    k = window.scale
    below = (
        f'<svg class="vi vi-at-{view}" viewBox="0 0 {w} {h}"><rect class="vi-plane" x=".5" y=".5" width="{w - 1}"'
        f' height="{h - 1}" rx="4"/><rect class="vi-rule" x="{-window.x * k:.1f}" y="{-window.y * k:.1f}"'
        f' width="{frame[0] * k:.1f}" height="{frame[1] * k:.1f}"/>'
    )
    name_x, end = (w - 5, " vi-end") if window.locator_left else (5, "")
    above = f'<text class="vi-name vi-halo{end}" x="{name_x}" y="15">{view}</text>'
    if not whole and view in "LR":
        above += _locator(window, w, frame)
    return below, above


def _locator(window: Window, w: float, frame: tuple[int, int]) -> str:
    """Draw the whole frame, small, with the part that the window shows."""
    k = 38 / frame[0]
    x, y, height = (5 if window.locator_left else w - 43), 5, frame[1] * k
    left, top = max(window.x, 0), max(window.y, 0)
    right, bottom = min(window.x + window.w, frame[0]), min(window.y + window.h, frame[1])
    return (
        f'<rect class="vi-plane" x="{x}" y="{y}" width="38" height="{height:.1f}" rx="1.5"/>'
        f'<rect class="vi-lens" x="{x + left * k:.1f}" y="{y + top * k:.1f}" width="{(right - left) * k:.1f}"'
        f' height="{(bottom - top) * k:.1f}"/>'
    )


EYES = {view: f'<i class="vi-eye">{view}</i>' for view in "lrLR"}  # as on the pictures: a plain l reads as I
CROSSED = (
    ("l", "This is point {point} in {l}."),
    ("left", "Its epipolar lines in {L} and {R}: the point is somewhere on them."),
    ("r", "This is point {point} in {r}."),
    ("right", "It gives a second line in each picture."),
    ("recovered", "The diamond is where the two lines cross."),
    ("own", "The arrow is the residual, from there to the learner's own point {point}."),
)
REPEATED = (
    ("l", "This is point {point} in {l} and {r}."),
    ("steps", "Three steps lead to it from the middle of all points."),
    ("repeated", "The same steps are made in {L} and {R}."),
    ("recovered", "The diamond is where they lead."),
    ("own", "The arrow is the residual, from there to the learner's own point {point}."),
)
LINE_NAMES = {"": "line of l", " vi-from-right": "line of r", " vi-partner": "other eye"}  # by class of a line
STEPS_SAMPLE = '<path class="vi-steps" d="M0 0H20"/><path class="vi-stop" d="M10 0h0"/>'
WITH = {"r": "l"}  # a part without a stage of its own → the stage it appears in
MAX_HALF_AXIS = 400.0  # px: a longer one looks the same


def line_sample(kind: str) -> str:
    """Draw a piece of an epipolar line. kind: of LINE_NAMES."""
    return f'<path class="vi-line{kind}" d="M0 0H20"/>'


def last_stage(crossed: bool) -> int:
    """Return the index of the last stage. crossed: whether the transfer intersects epipolar lines."""
    return len(CROSSED if crossed else REPEATED) - 1


def is_shown(stage: int | None, crossed: bool, what: str) -> bool:
    """Say whether a part is shown at a stage; None for the complete construction."""
    names = [name for name, __ in (CROSSED if crossed else REPEATED)]
    return stage is None or names.index(what if what in names else WITH[what]) <= stage


def describe_construction(construction: Construction | None, point: int, stage: int | None, crossed: bool) -> str:
    """Write the words of a stage, or of the complete construction, as HTML."""
    name = f"<b>{point}</b>"
    if stage is not None:
        words = (CROSSED if crossed else REPEATED)[stage][1]
        return f"<i>{stage + 1}/{last_stage(crossed) + 1}</i> {words.format(point=name, **EYES)}"
    if construction is None:
        return f"Point {name} is not visible in all four pictures."
    if construction.angle is None:
        return f"Point {name}: transferred by the steps {svg.sample(STEPS_SAMPLE, 0, 20)}."
    left, right = (f"{svg.number(angle, 0)}°" for angle in np.degrees(construction.angle))
    angles = left if left == right else f"{left}, {right}"
    of_l, of_r = (svg.sample(line_sample(kind), 0, 20) for kind in list(LINE_NAMES)[:2])
    text = "Point {point}: its lines of {l} {line_l} and {r} {line_r} cross at angles of {angles}"
    return text.format(point=name, line_l=of_l, line_r=of_r, angles=angles, **EYES)


def draw_construction(
    construction: Construction, windows: dict[str, Window], stage: int | None, own: Floats, gain: float
) -> dict[str, str]:
    """Draw the construction by view.

    stage: the last one to draw; None for all. Stages repeat the recovered point and its arrow, as other marks are
    faint; own: the learner's own point in L and R, (2, 2) px; gain: how many times longer than the residual its arrow
    is.
    """
    crossed, drawn = construction.steps is None, dict.fromkeys("lrLR", "")
    if construction.steps is not None:
        path = placed(construction.steps, windows, "lrLR")
        for k, view in enumerate("lrLR"):
            if is_shown(stage, crossed, "steps" if view in "lr" else "repeated"):
                drawn[view] += f'<path class="vi-steps" d="{svg.path(path[k])}"/>'
                drawn[view] += f'<path class="vi-stop" d="{svg.dots(path[k, :-1])}"/>'
    if not is_shown(stage, crossed, "recovered"):
        return drawn
    centres = placed(construction.recovered[:, None], windows, "LR")[:, 0]
    for k, view in enumerate("LR"):
        drawn[view] += _ellipse(centres[k], construction.half_axes[k], construction.direction[k], windows[view].scale)
        if stage is not None:
            drawn[view] += f'<path class="vi-found" d="{svg.diamonds(centres[k : k + 1], RECOVERED)}"/>'
    if stage is not None and is_shown(stage, crossed, "own"):
        tips = centres + gain * (placed(own[:, None], windows, "LR")[:, 0] - centres)
        for k, view in enumerate("LR"):
            drawn[view] += f'<path class="vi-e" d="{svg.segments(centres[k : k + 1], tips[k : k + 1])}"/>'
    return drawn


def _ellipse(centre: Floats, half_axes: Floats, direction: float, scale: float) -> str:
    """Draw an ellipse. centre: (2,) px of the drawing; half_axes: (2,) px of the image; direction: rad."""
    turn = f"translate({centre[0]:.1f} {centre[1]:.1f})rotate({np.degrees(direction):.1f})"
    long, short = np.minimum(scale * half_axes, MAX_HALF_AXIS).tolist()
    return f'<ellipse class="vi-spread" rx="{long:.1f}" ry="{short:.1f}" transform="{turn}"/>'

"""The landscape of E over two joints with the learner's path on it, and the cost of noise at each joint.

The picture with shading and contours is drawn once per landscape. Path and labels are a separate element over it, so
that a motion resends only these.

For other numbers of joints, bars show how 1 px of noise disturbs each joint. std_per_px: (m,) rad/px, the standard
error of each joint per px of noise. joints: their numbers, from 1.
"""

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np

from ..analysis.landscape import Landscape
from ..analysis.observability import unobservable_joints, weak_joints
from ..geometry.arrays import Floats
from ..loop.settings import Settings
from ..loop.snapshot import Snapshot
from ..servo.certificate import MAX_STD_PER_PX
from ..simulation.scene import Scene
from ..wording import listed
from . import relief, svg
from .labels import CHARACTER, Label, led
from .plots import figure
from .posture_plane import NOW, PathLabels, PosturePlane
from .theme import OBSERVED

WIDTH, HEIGHT = 424, 229  # px of the drawing that replaces a landscape
LEFT, RIGHT = 34, 60  # px beside the bars
ROW, BAR = 24, 11  # px
TITLE = "Joint error per pixel of noise"
NOTE = "in the learner's pictures, at the demonstrator's pose; from the curvature of E"


def draw_observability(joints: Sequence[int], std_per_px: Floats) -> str:
    """Draw title, a bar per joint, and the sentence."""
    head = f'<text x="0" y="12"><tspan class="vi-b">{TITLE}</tspan></text>' + svg.text(0, 27, NOTE, "vi-2nd")
    row = min(ROW, (HEIGHT - 96) / len(joints))
    bars = f'<g transform="translate(0 38)">{draw_bars(joints, std_per_px, WIDTH, row)}</g>'
    y = 38 + row * len(joints) + 20
    said = enumerate(describe_weakness(joints, std_per_px))
    return head + bars + "".join(svg.text(0, y + 15 * k, line, "" if k else "vi-b") for k, line in said)


def draw_bars(joints: Sequence[int], std_per_px: Floats, width: float, row: float) -> str:
    """Draw a row per joint: its name, a bar, its degrees. Rows are `row` px high, the drawing `width` px wide.

    Bars of weakly observable joints are amber with a diamond; those of unobservable ones take the whole width.
    """
    degrees, unobservable, weak = np.degrees(std_per_px), unobservable_joints(std_per_px), weak_joints(std_per_px)
    largest, longest = np.max(np.delete(degrees, unobservable), initial=1e-9), width - LEFT - RIGHT
    parts, thick = [], min(BAR, row - 3)
    for k, (joint, value) in enumerate(zip(joints, degrees)):
        y, amber = row * (k + 0.5), k in weak or k in unobservable
        length = longest if k in unobservable else longest * value / largest
        words, x = _cost(value), LEFT + 6 if k in unobservable else LEFT + length + 6
        kind = "vi-amber" if amber else "vi-bar-cost"
        parts.append(
            svg.text(LEFT - 8, y + 4, svg.joint_symbol(joint), "vi-end")
            + f'<rect class="{kind}" x="{LEFT}" y="{y - thick / 2:.1f}" width="{length:.1f}" height="{thick:.1f}"/>'
            + svg.text(x, y + 4, words, f"vi-b{' vi-halo' if k in unobservable else ''}" if amber else "")
        )
        if amber:
            mark = np.array([[max(LEFT + length + 8, x + 6 + 6.4 * len(words)), y]])
            parts.append(f'<path class="vi-amber" d="{svg.diamonds(mark, 4.5)}"/>')
    return "".join(parts)


def describe_weakness(joints: Sequence[int], std_per_px: Floats) -> list[str]:
    """Say in short lines which joints are unobservable or weakly observable."""
    degrees, unobservable = np.degrees(std_per_px), unobservable_joints(std_per_px)
    weak = [k for k in weak_joints(std_per_px) if k not in unobservable]
    rest = np.delete(degrees, [*unobservable, *weak])
    most = _cost(rest.max()) if len(rest) else ""
    if unobservable:
        others = np.delete(degrees, unobservable)
        subject, be, them = ("Joint", "is", "it") if len(unobservable) == 1 else ("Joints", "are", "them")
        ending = "It could be at any angle."
        if len(others):
            ending = f"1 px of noise shifts the others by {_cost(others.max())} at most."
        named = f"{subject} {_listed(joints, unobservable)}"
        return [f"{named} {be} unobservable: the pictures hardly show {them}.", ending]
    if not weak:
        if len(joints) == 1:
            return [f"1 px of noise shifts it by {most}."]
        return [f"No joint is much harder to see: 1 px of noise shifts each by {most} at most."]
    subject, be, them = ("Joint", "is", "it") if len(weak) == 1 else ("Joints", "are", "them")
    angles = listed([_cost(degrees[k]) for k in weak])
    found = f"{subject} {_listed(joints, weak)} {be} hard to see:"
    return [found, f"1 px of noise shifts {them} by {angles}, and the others by {most} at most."]


def describe_costs(joints: Sequence[int], std_per_px: Floats, are_worst: bool = False) -> str:
    """Write the degrees of all joints in a few words, for a caption. are_worst: whether others have smaller ones."""
    unobservable, degrees = unobservable_joints(std_per_px), np.degrees(std_per_px)
    seen = [f"{svg.joint_symbol(joints[k])} {_cost(degrees[k])}" for k in range(len(joints)) if k not in unobservable]
    names = ", ".join(svg.joint_symbol(joints[k]) for k in sorted(unobservable))
    costs = f"noise of 1 px: {'at most ' if are_worst else ''}{', '.join(seen)}" if seen else ""
    words = f"{names} unobservable" if unobservable else ""
    return "; ".join(filter(None, (costs, words)))


def _listed(joints: Sequence[int], indices: Sequence[int]) -> str:
    return listed([str(joints[k]) for k in indices])


def _cost(degrees: float) -> str:
    return "unobservable" if degrees >= np.degrees(MAX_STD_PER_PX) else svg.number(degrees) + "°"


CLOSE_DEG, INSET = 6.0, 74  # if demonstrator and smallest E are closer: an inset of ±CLOSE_DEG, INSET px wide
MAX_VERTICES, MAX_DOTS = 180, 60  # of the path; longer paths have no dots
INSET_MOTIONS = 30  # the last ones, which the inset shows
CONTOURS = {"projected": "E in px²", "rendered": "E, projected"}  # no pictures are taken for all postures
CAPTION = 14  # px above a picture that stands alone
HINT = "click: the learner starts there"  # on a page, in the corner that the picture leaves free for it
HINT_PLACE = 6, 14  # px from the plot's left top to the left end of its baseline
SMALL_WIDTH = 207  # px of a small landscape
SMALL_MARGINS = (31, 3, 0, 14)  # px: left, right, top, bottom


class LandscapePicture:
    """A landscape as a drawing, `html`. `draw_path` returns what lies over it.

    The learner does not know the demonstrator's mark in it. landscape: E over the postures; None while it is computed,
    or if `problem` says why there is none; snapshot: gives start, demonstrator's posture and kind of camera;
    std_per_px: for the note below; contours: the quantity whose contours are drawn, instead of CONTOURS.
    """

    def __init__(
        self,
        landscape: Landscape | None,
        scene: Scene,
        snapshot: Snapshot,
        problem: str = "computing …",
        std_per_px: Floats | None = None,
        contours: str | None = None,
    ):
        self._plane = plane = PosturePlane(scene)
        self._above = ""  # marks, over the path
        self._inset_ground = ""  # of the enlargement, over the path that would cross it
        self._labels: list[Label] = []  # of marks and contours
        self._zoom: tuple[Floats, Floats] | None = None  # centre of the inset, px and degrees
        joints = scene.moving_joints
        if not plane.has_plane and std_per_px is not None:
            self.html = plane.wrap(draw_observability(joints, std_per_px))
            return
        if landscape is None:
            inside = plane.message(problem)
        elif np.isnan(landscape.E).all():
            inside = plane.message("In no pose do all four pictures show five points.")
        else:
            inside = self._draw(landscape, snapshot)
        note = describe_costs(joints, std_per_px) if std_per_px is not None else ""
        warns = std_per_px is not None and bool(unobservable_joints(std_per_px))
        axes = plane.axes(note, contours or CONTOURS[snapshot.settings.sensor], warns=warns)
        self._ground = plane.frame("vi-plane") + inside + axes
        self.html = plane.wrap(self._ground)
        self._path_labels = PathLabels(plane, self._labels)

    def draw_alone(self, settings: Settings) -> str:
        """Draw the picture without a path, captioned with its settings."""
        labels = self._plane.labels.copy().draw(self._labels)
        inside = f'<g transform="translate(0 {CAPTION})">{self._ground}{self._inset_ground}{self._above}{labels}</g>'
        return figure(settings, inside, height=self._plane.height + CAPTION)

    def draw_path(self, history: Sequence[Snapshot], cursor: int, theta: Floats | None = None) -> str:
        """Draw the motions up to the cursor, later ones faint. theta: (m,) rad, shown while the arm moves."""
        if not self._plane.has_plane:
            return self._plane.wrap("", "vi-over")
        kept = svg.thinned_between(len(history), MAX_VERTICES, cursor)
        snapshots = history[:]  # a list gives single snapshots faster
        points = self._plane.place(np.degrees(np.concatenate([snapshots[k].theta for k in kept]).reshape(-1, 2)))
        done = bisect_right(kept, cursor)
        shown = history[cursor].theta if theta is None else theta
        now = self._plane.place(np.degrees(shown))
        line = np.concatenate([points[: done - 1], now[None]])
        parts = []
        if done < len(points):
            parts.append(f'<path class="vi-line-own vi-later" d="{svg.path(points[done - 1 :])}"/>')
        parts.append(f'<path class="vi-line-own" d="{svg.path(line)}"/>')
        if len(history) <= MAX_DOTS:
            probe = np.array([snapshot.probe for snapshot in history[: done - 1]], bool)
            parts.append(f'<path class="vi-dot-own" d="{svg.dots(points[: done - 1][~probe])}"/>')
            if probe.any():
                parts.append(f'<path class="vi-probe-own" d="{svg.circles(points[: done - 1][probe], 2.6)}"/>')
        words = self._path_labels.draw(history, cursor, theta, points)
        parts += [self._inset_ground, _dot(now), self._in_inset(line), self._above, words]
        return self._plane.wrap("".join(parts), "vi-over")

    def _draw(self, landscape: Landscape, snapshot: Snapshot) -> str:
        plane, labels = self._plane, self._plane.labels
        grid = plane.grid(landscape.axes)
        demo, lowest = np.degrees(snapshot.theta_demo), np.degrees(landscape.minimum)
        marks = plane.place(np.stack([demo, lowest]))
        start = plane.place(np.array(snapshot.settings.start_deg))
        labels.take_points(marks, 8)
        left, top, *__ = plane.box
        hint = left, top, left + HINT_PLACE[0] + len(HINT) * CHARACTER, top + HINT_PLACE[1] + 6
        labels.take(hint)
        fine = max(np.degrees(np.diff(axis)).max() for axis in landscape.axes) <= CLOSE_DEG / 2
        room = min(plane.box[2:]) > 2 * INSET
        if fine and room and np.max(np.abs(demo - lowest)) < CLOSE_DEG:
            busy = [*marks, (start + marks[1]) / 2, start, np.array(hint[:2])]
            self._inset_ground = self._inset(landscape, demo, lowest, busy)
        self._above = _marks(marks) + self._above
        left_first = bool(marks[0, 0] <= marks[1, 0] + 1)
        named = (("demonstrator", demo, "vi-lead-demo"), ("smallest E", lowest, "vi-lead"))
        for k, (text, posture, kind) in enumerate(named):
            words = f"{text} ({svg.number(posture[0], 0)}°, {svg.number(posture[1], 0)}°)"
            x, y = marks[k].tolist()
            self._labels.append(led(x, y, words, kind, (k == 0) == left_first))
        self._labels += relief.level_labels(grid, landscape.E, labels.bounds, marks[1])
        return relief.shading(grid, landscape.E, plane.box) + relief.contours(grid, landscape.E)

    def _inset(self, landscape: Landscape, demo: Floats, lowest: Floats, busy: list[Floats]) -> str:
        """Enlarge the plot around both marks in the corner of the plot farthest from `busy` places, px."""
        side, (x, y, w, h) = INSET / 2, self._plane.box
        corners = [np.array([a, b]) for a in (x + side + 4, x + w - side - 4) for b in (y + side + 4, y + h - side - 4)]
        middle = max(corners, key=lambda corner: min(np.hypot(*(corner - point)) for point in busy))
        centre = (demo + lowest) / 2
        self._zoom = middle, centre
        self._plane.labels.take_points(middle, side + 3)
        off = [np.abs(np.degrees(axis) - c) for axis, c in zip(landscape.axes, centre)]
        first, second = near = [np.flatnonzero(one < CLOSE_DEG + 1.5) for one in off]
        columns, rows = self._plane.grid((landscape.axes[0][first], landscape.axes[1][second]))
        x0, y0 = self._plane.place(centre)
        grid = middle[0] + (columns - x0) * self._enlargement, middle[1] + (rows - y0) * self._enlargement
        contours = relief.fine_contours(grid, landscape.E[np.ix_(*near)])
        self._above = f'<g class="vi-detail">{_marks(self._zoomed(self._plane.place(np.stack([demo, lowest]))))}</g>'
        left, top = middle - side
        size = f'width="{INSET - 1}" height="{INSET - 1}" rx="3"'
        frame = f'<rect class="vi-inset" x="{left + 0.5:.1f}" y="{top + 0.5:.1f}" {size}/>'
        note = svg.text(left + 5, top + INSET - 5, f"±{CLOSE_DEG:g}°", "vi-2nd vi-halo")
        return self._clipped(frame + contours + note)

    def _in_inset(self, line: Floats) -> str:
        """Draw the last motions in the inset. line: (k, 2) px of the plot."""
        if self._zoom is None:
            return ""
        near = self._zoomed(line[-INSET_MOTIONS:])
        if np.abs(near[-1] - self._zoom[0]).max() > INSET / 2 - 3:
            return ""
        return self._clipped(f'<path class="vi-line-own" d="{svg.path(near)}"/>{_dot(near[-1])}')

    @property
    def _enlargement(self) -> float:
        return INSET / (2 * CLOSE_DEG * self._plane.scale)

    def _zoomed(self, points: Floats) -> Floats:
        """Convert px of the plot to px of the inset."""
        assert self._zoom is not None
        middle, centre = self._zoom
        return middle + (points - self._plane.place(centre)) * self._enlargement

    def _clipped(self, inside: str) -> str:
        assert self._zoom is not None
        left, top = self._zoom[0] - INSET / 2
        place = f'x="{left:.1f}" y="{top:.1f}" width="{INSET}" height="{INSET}"'
        return f'<svg class="vi-detail" {place} viewBox="{left:.1f} {top:.1f} {INSET} {INSET}">{inside}</svg>'


def _dot(place: Floats) -> str:
    return f'<circle class="vi-now" cx="{place[0]:.1f}" cy="{place[1]:.1f}" r="{NOW}"/>'


def _marks(points: Floats) -> str:
    """Draw the demonstrator's diamond and the cross of the smallest E, of sizes that do not hide each other."""
    return f'<path class="vi-seen" d="{svg.diamonds(points[:1], OBSERVED + 1)}"/>' + svg.cross(points[1], 6)


def small_plane(scene: Scene, max_height: float) -> PosturePlane:
    """Make the plane of a small landscape. max_height: of the plot, px."""
    return PosturePlane(scene, SMALL_WIDTH, max_height, SMALL_MARGINS)


def draw_small(plane: PosturePlane, found: Landscape, minima: Floats, theta_demo: Floats) -> str:
    """Draw a small landscape with the demonstrator's diamond and a cross at each minimum.

    plane: from `small_plane`; found: E over the postures; minima: (k, 2) rad, the lowest first, whose cross is larger;
    theta_demo: (2,) rad. Returns inside of an `<svg>`.
    """
    parts = [plane.frame("vi-plane")]
    E = found.E
    if np.isnan(E).all():
        parts.append(plane.message("Nowhere are five points visible."))
    else:
        grid = plane.grid(found.axes)
        parts += [relief.shading(grid, E, plane.box), relief.contours(grid, E)]
    demo = plane.place(np.degrees(theta_demo))
    parts.append(f'<path class="vi-seen" d="{svg.diamonds(demo[None], OBSERVED + 1)}"/>')
    for k, place in enumerate(plane.place(np.degrees(minima[np.isfinite(minima).all(1)]))):
        parts.append(svg.cross(place, 5.5 if k == 0 else 3.0))
    return "".join(parts) + plane.ends()

"""The landscape of E over two joints, and the path of the learner on it.

The picture with shading and contours is made once a landscape; the path and all labels, which keep off it, are an
element of its own that lies over it, so that a motion resends only that.
"""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..analysis.landscape import Landscape
from ..settings import Settings
from ..simulation.scene import Scene
from ..snapshot import Snapshot
from . import relief, svg
from .labels import Labels, Rectangle, line_taken, text_at
from .observability import described, draw_observability
from .plots import figure
from .posture_plane import PosturePlane
from .theme import OBSERVED

CLOSE_DEG, INSET = 6.0, 74  # when demonstrator and smallest E are nearer than that: an inset of ±CLOSE_DEG, px wide
PATH_LIMIT, DOT_LIMIT = 90, 60  # vertices of the path; motions up to which each has a dot
INSET_MOTIONS = 30  # the last ones, which the inset shows
CONTOURS = {"points": "E in px²", "rendered": "E, projected"}  # no pictures are taken for all postures
CAPTION = 14  # px above a picture that stands alone
NOW = 5.8  # px, radius of the big dot
STAYS = 100  # motions for which labels that nothing covers stay; what a path takes of the plot grows with each
CLEAR = 3.0  # px on both sides of the path that labels leave free
AHEAD = 4.0  # px around the big dot that labels leave free for the next motions when they are placed


@dataclass
class Placed:
    """Labels over a path. since: the motion for which they were placed; about: the path's moments and its cursor;
    present: the last of it; path: what that and the marks take; line: with the big dot, wherever it has been since;
    labels: what the labels but the learner's own take, with their leaders; others: where these labels stand; own,
    words: the drawings of both."""

    since: int
    about: tuple[int, int]
    present: Snapshot
    path: Labels
    line: Labels
    labels: list[Rectangle]
    others: Labels
    own: str
    words: str

    @cached_property
    def free(self) -> Labels:
        """With the line and these labels taken. Mostly the next motion covers one before it is asked for."""
        free = self.line.copy()
        free.take(*self.labels)
        return free

    def take(self, rectangles: Sequence[Rectangle]) -> None:
        """By the line."""
        self.line.take(*rectangles)
        if "free" in vars(self):
            self.free.take(*rectangles)


class LandscapePicture:
    """html: the picture; draw_path: what lies over it. landscape: None while it is computed, or if `problem` says why
    there is none.

    The demonstrator's mark is the truth, for the viewer. contours: what they are of, in place of CONTOURS.
    """

    def __init__(
        self,
        landscape: Landscape | None,
        scene: Scene,
        snapshot: Snapshot,
        problem: str = "computing …",
        spread: NDArray | None = None,
        contours: str | None = None,
    ):
        self._plane = plane = PosturePlane(scene)
        self._above = ""  # marks, over the path
        self._named: list[tuple[NDArray, str, str, bool]] = []  # marks to be led to: px, words, class, from the left
        self._levels: list[relief.Level] = []
        self._placed: Placed | None = None
        self._zoom: tuple[NDArray, NDArray] | None = None  # centre of the inset, px and degrees
        joints = scene.moving_joints
        if not plane.has_plane and spread is not None:
            self.html = plane.wrap(draw_observability(joints, spread))
            return
        if landscape is None:
            inside = plane.message(problem)
        elif np.isnan(landscape.E).all():
            inside = plane.message("nowhere are five points seen in all four images")
        else:
            inside = self._draw(landscape, snapshot)
        note = described(joints, spread) if spread is not None else ""
        self._ground = (
            plane.frame("vi-plane") + inside + plane.axes(note, contours or CONTOURS[snapshot.settings.camera])
        )
        self.html = plane.wrap(self._ground)

    def draw_alone(self, settings: Settings) -> str:
        """The picture without a path, with the words of what it was made."""
        labels = self._labels(self._plane.labels.copy())
        inside = f'<g transform="translate(0 {CAPTION})">{self._ground}{self._above}{labels}</g>'
        return figure(settings, inside, height=self._plane.height + CAPTION)

    def draw_path(self, history: Sequence[Snapshot], cursor: int, theta: NDArray | None = None) -> str:
        """The motions up to the cursor, later ones faint. theta: (m,) rad, where the arm is seen while it moves."""
        if not self._plane.has_plane:
            return self._plane.wrap("", "vi-over")
        kept = svg.thinned(len(history), PATH_LIMIT, cursor)
        moments = history[:]  # a list, of which each is found sooner
        points = self._plane.place(np.degrees(np.concatenate([moments[k].theta for k in kept]).reshape(-1, 2)))
        done = bisect_right(kept, cursor)
        shown = history[cursor].theta if theta is None else theta
        now = self._plane.place(np.degrees(shown))
        line = np.concatenate([points[: done - 1], now[None]])
        parts = []
        if done < len(points):
            parts.append(f'<path class="vi-line-own vi-later" d="{svg.path(points[done - 1 :])}"/>')
        parts.append(f'<path class="vi-line-own" d="{svg.path(line)}"/>')
        if len(history) <= DOT_LIMIT:
            probe = np.array([snapshot.probe for snapshot in history[: done - 1]], bool)
            parts.append(f'<path class="vi-dot-own" d="{svg.dots(points[: done - 1][~probe])}"/>')
            if probe.any():
                parts.append(f'<path class="vi-probe-own" d="{svg.circles(points[: done - 1][probe], 2.6)}"/>')
        words = self._words(history, cursor, theta, points)
        parts += [_dot(now), self._in_inset(line), self._above, words]
        return self._plane.wrap("".join(parts), "vi-over")

    def _words(self, history: Sequence[Snapshot], cursor: int, theta: NDArray | None, points: NDArray) -> str:
        """All labels; those but the learner's own stay while the arm is on its way. points: (k, 2) px of the path."""
        about, present = (len(history), cursor), history[cursor]
        if self._placed is None or (self._placed.about, self._placed.present) != (about, present):
            new = self._since(history, cursor)
            if new is None or not self._gone_on(history, cursor, new):
                self._placed = self._place(history, cursor, points, new)
        placed = self._placed
        assert placed is not None
        return placed.words + (placed.own if theta is None else self._now(placed.free, theta, cursor))

    def _since(self, history: Sequence[Snapshot], cursor: int) -> list[Rectangle] | None:
        """What the motions since labels were drawn last take; None if the path is another one."""
        placed = self._placed
        if placed is None or not len(history) - 1 == cursor > placed.about[1] == placed.about[0] - 1:
            return None
        since = history[placed.about[1] : cursor + 1]
        if since[0] is not placed.present:
            return None
        new = line_taken(self._plane.place(np.degrees([moment.theta for moment in since])), CLEAR)
        placed.path.take(*new)
        return new

    def _place(
        self, history: Sequence[Snapshot], cursor: int, points: NDArray, new: list[Rectangle] | None
    ) -> "Placed":
        """All labels, off the path. points: (k, 2) px of it; new: what of it has just been taken; None: nothing is."""
        present = history[cursor]
        if self._placed is not None and new is not None:
            path = self._placed.path
        else:
            path = self._plane.labels.copy()
            path.take_line(points, CLEAR)
        line, others = path.copy(), Labels(*path.bounds)
        now, start = self._plane.place(np.degrees(present.theta)), points[0]
        line.take_points(now, NOW + AHEAD)
        labels, words = line.copy(), ""
        own, place = self._own(labels, present.theta, cursor)
        if place is not None:
            labels.take(place)
        if cursor and np.abs(now - start).max() > 20:
            words = labels.beside(float(start[0]), float(start[1]), "start", "vi-2nd vi-halo", 8)
        words += self._labels(labels)
        others.take(*labels.placed)
        taken = labels.since(line)[place is not None :]
        return Placed(cursor, (len(history), cursor), present, path, line, taken, others, own, words)

    def _gone_on(self, history: Sequence[Snapshot], cursor: int, new: list[Rectangle]) -> bool:
        """While more motions keep off the labels, these stay: they do not jump, and need not be placed. new: what these
        motions take."""
        placed, present = self._placed, history[cursor]
        assert placed is not None
        if cursor - placed.since > STAYS:
            return False
        x, y = self._plane.place(np.degrees(present.theta)).tolist()
        new = [*new, (x - NOW, y - NOW, x + NOW, y + NOW)]
        if any(map(placed.others.covers, new)):
            return False
        placed.take(new)
        placed.own = self._now(placed.free, present.theta, cursor)
        if not placed.own and self._now(placed.line, present.theta, cursor):
            return False  # it would have room if the others stood elsewhere
        placed.about, placed.present = (len(history), cursor), present
        return True

    def _now(self, labels: Labels, theta: NDArray, cursor: int) -> str:
        """The learner's own label at theta, (m,) rad, beside the others."""
        return self._own(labels, theta, cursor)[0]

    def _own(self, labels: Labels, theta: NDArray, cursor: int) -> tuple[str, Rectangle | None]:
        """The learner's own label at theta, (m,) rad, and its place, which is not taken."""
        x, y = self._plane.place(np.degrees(theta)).tolist()
        words = f"{'now' if cursor else 'start'} ({svg.degrees(theta[0])}, {svg.degrees(theta[1])})"
        place = labels.free_beside(x, y, words, 11)
        return ("" if place is None else text_at(place, words, "vi-of-own vi-halo")), place

    def _labels(self, labels: Labels) -> str:
        """Of the marks and of the contours, where there is room."""
        led = "".join(labels.led(x, y, words, kind, to_left) for (x, y), words, kind, to_left in self._named)
        return led + relief.draw_levels(self._levels, labels)

    def _draw(self, landscape: Landscape, snapshot: Snapshot) -> str:
        plane, labels = self._plane, self._plane.labels
        grid = plane.grid(landscape.axes)
        demo, lowest = np.degrees(snapshot.theta_demo), np.degrees(landscape.minimum)
        marks = plane.place(np.stack([demo, lowest]))
        start = plane.place(np.array(snapshot.settings.start_deg))
        labels.take_points(marks, 8)
        inset = ""
        fine = max(np.degrees(np.diff(axis)).max() for axis in landscape.axes) <= CLOSE_DEG / 2
        room = min(plane.box[2:]) > 2 * INSET
        if fine and room and np.max(np.abs(demo - lowest)) < CLOSE_DEG:
            inset = self._inset(landscape, demo, lowest, [*marks, (start + marks[1]) / 2, start])
        self._above = _marks(marks) + self._above
        left_first = bool(marks[0, 0] <= marks[1, 0] + 1)
        named = (("demonstrator", demo, "vi-lead-demo"), ("smallest E", lowest, "vi-lead"))
        for k, (name, posture, kind) in enumerate(named):
            words = f"{name} ({svg.number(posture[0], 0)}°, {svg.number(posture[1], 0)}°)"
            self._named.append((marks[k], words, kind, (k == 0) == left_first))
        self._levels = relief.level_places(grid, landscape.E, labels.bounds, marks[1])
        return relief.shading(grid, landscape.E, plane.box) + relief.contours(grid, landscape.E) + inset

    def _inset(self, landscape: Landscape, demo: NDArray, lowest: NDArray, busy: list[NDArray]) -> str:
        """What lies around both marks, enlarged, in the corner of the plot farthest from busy px."""
        side, (x, y, w, h) = INSET / 2, self._plane.box
        corners = [np.array([a, b]) for a in (x + side + 4, x + w - side - 4) for b in (y + side + 4, y + h - side - 4)]
        middle = max(corners, key=lambda corner: min(np.hypot(*(corner - point)) for point in busy))
        centre = (demo + lowest) / 2
        self._zoom = middle, centre
        self._plane.labels.take_points(middle, side + 3)
        near = [
            np.flatnonzero(np.abs(np.degrees(axis) - c) < CLOSE_DEG + 1.5) for axis, c in zip(landscape.axes, centre)
        ]
        first, second = landscape.axes
        columns, rows = self._plane.grid((first[near[0]], second[near[1]]))
        at = self._plane.place(centre)
        enlarged = tuple(middle[k] + (px - at[k]) * self._enlargement for k, px in enumerate((columns, rows)))
        contours = relief.fine_contours((enlarged[0], enlarged[1]), landscape.E[np.ix_(*near)])
        self._above = _marks(self._zoomed(self._plane.place(np.stack([demo, lowest]))))
        left, top = middle - side
        size = f'width="{INSET - 1}" height="{INSET - 1}" rx="3"'
        frame = f'<rect class="vi-inset" x="{left + 0.5:.1f}" y="{top + 0.5:.1f}" {size}/>'
        note = svg.text(left + 5, top + INSET - 5, f"±{CLOSE_DEG:g}°", "vi-2nd vi-halo")
        return self._clipped(frame + contours + note)

    def _in_inset(self, line: NDArray) -> str:
        """The last motions where the inset shows them. line: (k, 2) px of the plot."""
        if self._zoom is None:
            return ""
        near = self._zoomed(line[-INSET_MOTIONS:])
        if np.abs(near[-1] - self._zoom[0]).max() > INSET / 2 - 3:
            return ""
        return self._clipped(f'<path class="vi-line-own" d="{svg.path(near)}"/>{_dot(near[-1])}')

    @property
    def _enlargement(self) -> float:
        return INSET / (2 * CLOSE_DEG * self._plane.scale)

    def _zoomed(self, points: NDArray) -> NDArray:
        """px of the plot → px of the inset"""
        assert self._zoom is not None  # only asked for with an inset
        middle, centre = self._zoom
        return middle + (points - self._plane.place(centre)) * self._enlargement

    def _clipped(self, inside: str) -> str:
        assert self._zoom is not None
        left, top = self._zoom[0] - INSET / 2
        place = f'x="{left:.1f}" y="{top:.1f}" width="{INSET}" height="{INSET}"'
        return f'<svg {place} viewBox="{left:.1f} {top:.1f} {INSET} {INSET}">{inside}</svg>'


def _dot(place: NDArray) -> str:
    return f'<circle class="vi-now" cx="{place[0]:.1f}" cy="{place[1]:.1f}" r="{NOW}"/>'


def _marks(points: NDArray) -> str:
    """The demonstrator's diamond and the cross of the smallest E, larger so that neither hides the other."""
    x, y = points[1]
    return (
        f'<path class="vi-seen" d="{svg.diamonds(points[:1], OBSERVED + 1)}"/>'
        f'<path class="vi-cross" d="M{x - 6:.1f} {y:.1f}h12M{x:.1f} {y - 6:.1f}v12"/>'
    )

"""Tracked points: the track of one view, the tracks of all four views together, and the rows of a table."""

import math
from array import array
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...estimation.views import VIEW_NAMES, VIEWS, FourViews
from ..frames import is_missing_value

MAX_PX = 1e6  # of a coordinate: no picture is larger
MAX_CELLS = 5_000_000  # frames times points
PERCENT, OWN_GRID = 100, 256  # px: a picture that is no larger is rare
CERTAIN = 1.0  # confidence where a file gives none
MAX_CONFIDENCE = 2.0  # some trackers' peaks are a little above 1; COCO writes 2 for visible
BODIES = (VIEWS[:2], VIEWS[2:])  # the views of each body
Row = tuple[int, str, float, float, float]  # frame, point, x, y, confidence


@dataclass(frozen=True)
class Track:
    """N points in T frames of one view."""

    frames: NDArray[np.int_]  # (T,) numbers, ascending
    points: tuple[str, ...]  # N names
    image: NDArray[np.float64]  # (T, N, 2) px, NaN if not visible
    confidence: NDArray[np.float64]  # (T, N)

    def require_pixels(self, where: str) -> "Track":
        """Return the track. Raises ValueError for no points, a repeated name, or values that are no pixels."""
        twice = [name for name, count in Counter(self.points).items() if count > 1]
        if twice:
            raise ValueError(f"{where}: two points are named {twice[0]!r}: they are matched by name, so rename one")
        if not np.isfinite(self.image).all(-1).any():
            raise ValueError(f"{where}: no point in any frame")
        wrong = np.isinf(self.image) | (np.abs(self.image) > MAX_PX)
        if wrong.any():
            t, n, axis = np.argwhere(wrong)[0]
            value = self.image[t, n, axis]
            fault = f"is no pixel: beyond {MAX_PX:g}" if math.isfinite(value) else "is not a finite number"
            raise ValueError(
                f"{where}: frame {self.frames[t]}, point {self.points[n]}, {'xy'[axis]}: {value:g} {fault}"
            )
        return self.require_units(where)

    def require_units(self, where: str) -> "Track":
        """Return the track. Raises ValueError for a confidence above 1, and for fractions of the picture."""
        wrong = self.confidence > MAX_CONFIDENCE
        if wrong.any():
            t, n = np.argwhere(wrong)[0]
            fault = f"confidence {self.confidence[t, n]:g} is not in 0 … 1: divide percentages by 100"
            raise ValueError(f"{where}: frame {self.frames[t]}, point {self.points[n]}: {fault}")
        there = self.image[np.isfinite(self.image).all(-1) & ~is_missing_value(self.image)]
        if there.size and (there >= 0).all() and (there <= 1).all():
            raise ValueError(
                f"{where}: all x and y are in 0 … 1, shares of the picture: multiply by its width and height, px"
            )
        return self

    def above_confidence(self, min_confidence: float) -> NDArray[np.float64]:
        """Return the points, (T, N, 2) px, with NaN for those of less confidence."""
        return np.where((self.confidence >= min_confidence)[..., None], self.image, np.nan)

    def non_empty_frames(self) -> "Track":
        """Return the track without frames that show no point."""
        shows = np.isfinite(self.image).all(-1).any(-1)
        return Track(self.frames[shows], self.points, self.image[shows], self.confidence[shows])


@dataclass(frozen=True)
class TrackedPoints:
    """N points in T frames of all four views."""

    frames: tuple[int, ...]  # T numbers
    points: tuple[str, ...]  # N names
    image: dict[str, NDArray[np.float64]]  # by view, (T, N, 2) px, NaN if not visible
    confidence: dict[str, NDArray[np.float64]]  # by view, (T, N)

    def views(self, min_confidence: float = 0.0) -> FourViews:
        """Return all frames, (T, N, …). Points of less confidence, and missing values, count as not visible."""
        visible = {view: self._confident(view, min_confidence) & ~is_missing_value(self.image[view]) for view in VIEWS}
        return FourViews.from_arrays(*(np.where(visible[v][..., None], self.image[v], np.nan) for v in VIEWS))

    def n_missing(self, min_confidence: float) -> int:
        """Count the points of sufficient confidence that a tracker marks as missing by their place."""
        found = (is_missing_value(self.image[view]) & self._confident(view, min_confidence) for view in VIEWS)
        return sum(int(one.sum()) for one in found)

    def n_below_confidence(self, min_confidence: float) -> dict[str, int]:
        """Count the image points of less confidence, by the name of the point, without zeros."""
        count = sum((self._present(view) & ~self._confident(view, min_confidence)).sum(0) for view in VIEWS)
        return {name: int(number) for name, number in zip(self.points, np.asarray(count)) if number}

    def n_image_points(self) -> int:
        """Count the points of any confidence in all frames and views, without missing values."""
        return sum(int(self._present(view).sum()) for view in VIEWS)

    def doubtful_units(self) -> str | None:
        """Return what coordinates look like that may be no pixels of the pictures; None for all others."""
        shown = [self.image[view][self._present(view)] for view in VIEWS]
        if not all(map(len, shown)) or min(image.min() for image in shown) < 0:
            return None
        widest = max(float(image.max()) for image in shown)
        if widest <= PERCENT:
            return f"all x and y are in 0 … {PERCENT}: if these are percent, multiply by the picture's size in pixels"
        if widest <= OWN_GRID:
            grid = f"in 0 … {OWN_GRID}: if this is the grid of a tracker such as TAPIR"
            return f"all x and y are {grid}, scale them to the picture's size"
        return None

    def doubtful_frames(self) -> str | None:
        """Return which views may count their frames from 0 where the others count from 1; None if none seem to."""
        shown = {view: np.flatnonzero(self._present(view).any(1)) for view in VIEWS}
        spans = {view: (self.frames[at[0]], self.frames[at[-1]]) for view, at in shown.items() if len(at) > 1}
        from_0 = {view: last for view, (first, last) in spans.items() if first == 0}
        from_1 = {view: last for view, (first, last) in spans.items() if first == 1}
        ends = {last + 1 for last in from_0.values()} | {*from_1.values()}
        if not from_0 or not from_1 or len(ends) > 1:
            return None
        zero, one = (", ".join(VIEW_NAMES[view] for view in views) for views in (from_0, from_1))
        (end,) = ends
        return (
            f"frames are 0 to {end - 1} in {zero}, but 1 to {end} in {one}: "
            "if the first of each shows the same moment, count them alike"
        )

    def _present(self, view: str) -> NDArray[np.bool_]:
        return np.asarray(np.isfinite(self.image[view]).all(-1) & ~is_missing_value(self.image[view]))

    def _confident(self, view: str, min_confidence: float) -> NDArray[np.bool_]:
        return self.confidence[view] >= min_confidence


def require_cells(where: str, frames: int, points: int) -> None:
    """Raise ValueError for more frames and points than are kept in memory."""
    if frames * points > MAX_CELLS:
        raise ValueError(
            f"{where}: {frames:,} frames times {points:,} points are more than {MAX_CELLS:,}: take fewer of either"
        )


def choose_individual(where: str, individuals: Sequence[str], name: str | None) -> str:
    """Return the individual of this name, or the only one. Raises ValueError that lists the individuals."""
    if name is None and len(individuals) <= 1:
        return individuals[0] if individuals else ""
    if name is not None and (name in individuals or list(individuals) in ([], [""])):
        return name if name in individuals else ""
    named = ", ".join(individuals)
    if name is None:
        raise ValueError(f"{where}: it has {named}: say who is whom by --demonstrator NAME and --learner NAME")
    raise ValueError(f"{where}: nobody is named {name!r}; it has {named}")


class Rows:
    """The rows of one view while they are read, in a few bytes each.

    Parameters
    ----------
    points : dict, optional
        Columns by the name of the point. Views that share it share their columns.
    """

    def __init__(self, points: dict[str, int] | None = None):
        self._points = {} if points is None else points
        self.frame, self.point, self.line = array("q"), array("l"), array("l")
        self.xy, self.confidence = array("d"), array("d")

    def add(self, line: int, frame: int, point: str, x: float, y: float, confidence: float) -> None:
        """Add one row."""
        self.frame.append(frame)
        self.point.append(self._points.setdefault(point, len(self._points)))
        self.line.append(line)
        self.xy.extend((x, y))
        self.confidence.append(confidence)

    def require_once(self, where: str, view: str = "") -> None:
        """Raise ValueError with the lines of two rows of the same frame and point."""
        frame, point = np.array(self.frame), np.array(self.point)
        order = np.lexsort((point, frame))  # stable: of equal rows the earlier line comes first
        same = (np.diff(frame[order]) == 0) & (np.diff(point[order]) == 0)
        if not same.any():
            return
        line = np.array(self.line)[order]
        k = int(np.flatnonzero(same)[line[1:][same].argmin()])
        at = self.line.index(int(line[k + 1]))
        name = list(self._points)[self.point[at]]
        of = f" in view {view}" if view else ""
        raise ValueError(
            f"{where}: line {line[k + 1]}: point {name} of frame {self.frame[at]}{of} stands in line {line[k]} too"
        )

    def track(self, where: str) -> Track:
        """Return all rows as a track. Raises ValueError as `require_cells`."""
        frames, at = np.unique(np.array(self.frame), return_inverse=True)
        require_cells(where, len(frames), len(self._points))
        image = np.full((len(frames), len(self._points), 2), np.nan)
        confidence = np.zeros(image.shape[:2])
        cells = at, np.array(self.point)
        image[cells], confidence[cells] = np.array(self.xy).reshape(-1, 2), np.array(self.confidence)
        return Track(frames, tuple(self._points), image, confidence)


def combine_views(tracks: Mapping[str, Track]) -> TrackedPoints:
    """Match the points of all views by name.

    If both views of a body have a single frame, such as a demonstrator that stands still, it is used for all frames.
    """
    several = [view for pair in BODIES for view in pair if any(len(tracks[of].frames) > 1 for of in pair)]
    frames = np.unique(np.concatenate([tracks[view].frames for view in several or VIEWS[:1]]))
    names = list(dict.fromkeys(name for view in VIEWS for name in tracks[view].points))
    if all(name.isdecimal() for name in names):
        names = sorted(names, key=int)
    require_cells("all views together", len(frames), len(names))
    column = {name: k for k, name in enumerate(names)}
    image = {view: np.full((len(frames), len(names), 2), np.nan) for view in VIEWS}
    confidence = {view: np.zeros((len(frames), len(names))) for view in VIEWS}
    for view in VIEWS:
        track = tracks[view]
        at = np.searchsorted(frames, track.frames)[:, None] if view in several else np.arange(len(frames))[:, None]
        where = np.array([column[name] for name in track.points], int)
        image[view][at, where], confidence[view][at, where] = track.image, track.confidence
    return TrackedPoints(tuple(frames.tolist()), tuple(names), image, confidence)

"""What all readers make of their files: the track of one view, and those of all four together."""

import math
from array import array
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...estimation.views import VIEWS, FourViews
from ..point_checks import lost

MOST_PX = 1e6  # beyond which no picture goes
MOST_CELLS = 5_000_000  # frames times points
CERTAIN = 1.0  # where no confidence is given
MOST_CONFIDENCE = 2.0  # some trackers' peaks are a little above 1; visible is 2 in COCO's files
BODIES = (VIEWS[:2], VIEWS[2:])  # the views of each
Row = tuple[int, str, float, float, float]  # frame, point, x, y, confidence


@dataclass(frozen=True)
class Track:
    """One view. frames: (T,) numbers, ascending; points: N names; image: (T, N, 2) px, NaN where not seen;
    confidence: (T, N)."""

    frames: NDArray
    points: tuple[str, ...]
    image: NDArray
    confidence: NDArray

    def require_pixels(self, where: str) -> "Track":
        """Itself. Raises ValueError for no points at all, the same name twice, or numbers that are no pixels."""
        twice = [name for name, count in Counter(self.points).items() if count > 1]
        if twice:
            raise ValueError(f"{where}: two points are named {twice[0]!r}: they are matched by name, so rename one")
        if not np.isfinite(self.image).all(-1).any():
            raise ValueError(f"{where}: no point in any frame")
        wrong = np.isinf(self.image) | (np.abs(self.image) > MOST_PX)
        if wrong.any():
            t, n, axis = np.argwhere(wrong)[0]
            value = self.image[t, n, axis]
            what = f"is no pixel: beyond {MOST_PX:g}" if math.isfinite(value) else "is not a finite number"
            raise ValueError(f"{where}: frame {self.frames[t]}, point {self.points[n]}, {'xy'[axis]}: {value:g} {what}")
        return self.require_units(where)

    def require_units(self, where: str) -> "Track":
        """Itself. Raises ValueError for a confidence that is none, and for shares of the picture instead of px."""
        wrong = self.confidence > MOST_CONFIDENCE
        if wrong.any():
            t, n = np.argwhere(wrong)[0]
            sure = f"confidence {self.confidence[t, n]:g} is not in 0 … 1: divide percentages by 100"
            raise ValueError(f"{where}: frame {self.frames[t]}, point {self.points[n]}: {sure}")
        there = self.image[np.isfinite(self.image).all(-1) & ~lost(self.image)]
        if there.size and (there >= 0).all() and (there <= 1).all():
            raise ValueError(
                f"{where}: all x and y are in 0 … 1, shares of the picture: multiply by its width and height, px"
            )
        return self

    def sure(self, least_confidence: float) -> NDArray:
        """(T, N, 2) px: points of less confidence were not seen."""
        return np.where((self.confidence >= least_confidence)[..., None], self.image, np.nan)

    def seen(self) -> "Track":
        """Of the frames that show a point only."""
        shows = np.isfinite(self.image).all(-1).any(-1)
        return Track(self.frames[shows], self.points, self.image[shows], self.confidence[shows])


@dataclass(frozen=True)
class TrackedPoints:
    """T frames of N points. frames: (T,) numbers; points: N names; image: by view (T, N, 2) px, NaN where not seen;
    confidence: by view (T, N)."""

    frames: tuple[int, ...]
    points: tuple[str, ...]
    image: dict[str, NDArray]
    confidence: dict[str, NDArray]

    def views(self, least_confidence: float = 0.0) -> FourViews:
        """All frames: (T, N, …). Points of less confidence, and where a tracker writes what it has lost, were not
        seen."""
        return FourViews.from_arrays(*(self._seen(view, least_confidence) for view in VIEWS))

    def lost(self, least_confidence: float = 0.0) -> int:
        """How many points of as much confidence are where a tracker writes what it has lost."""
        return sum(int((lost(self.image[view]) & self._sure(view, least_confidence)).sum()) for view in VIEWS)

    def removed(self, least_confidence: float) -> dict[str, int]:
        """How many image points have less confidence, by name of the points that have such."""
        count = sum((self._there(view) & ~self._sure(view, least_confidence)).sum(0) for view in VIEWS)
        return {name: int(number) for name, number in zip(self.points, np.asarray(count)) if number}

    def image_points(self) -> int:
        """How many there are in all frames and views, of any confidence, without those that a tracker has lost."""
        return sum(int(self._there(view).sum()) for view in VIEWS)

    def _there(self, view: str) -> NDArray:
        return np.asarray(np.isfinite(self.image[view]).all(-1) & ~lost(self.image[view]))

    def _seen(self, view: str, least_confidence: float) -> NDArray:
        seen = self._sure(view, least_confidence) & ~lost(self.image[view])
        return np.where(seen[..., None], self.image[view], np.nan)

    def _sure(self, view: str, least_confidence: float) -> NDArray:
        return self.confidence[view] >= least_confidence


def require_cells(where: str, frames: int, points: int) -> None:
    """Raises ValueError for more than are kept in memory."""
    if frames * points > MOST_CELLS:
        raise ValueError(
            f"{where}: {frames:,} frames times {points:,} points are more than {MOST_CELLS:,}: take fewer of either"
        )


class Rows:
    """The rows of one view as they are read, a few bytes each."""

    def __init__(self, points: dict[str, int] | None = None):
        self._points = {} if points is None else points  # of all views: names to columns
        self.frame, self.point, self.line = array("q"), array("l"), array("l")
        self.xy, self.sure = array("d"), array("d")

    def add(self, line: int, frame: int, point: str, x: float, y: float, sure: float) -> None:
        self.frame.append(frame)
        self.point.append(self._points.setdefault(point, len(self._points)))
        self.line.append(line)
        self.xy.extend((x, y))
        self.sure.append(sure)

    def require_once(self, where: str, view: str = "") -> None:
        """Raises ValueError for two rows of the same frame and point, of `view`, that names their lines."""
        frame, point = np.array(self.frame), np.array(self.point)
        order = np.lexsort((point, frame))  # stable: of equal ones the earlier line comes first
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
        """Raises ValueError for more frames and points than are kept in memory."""
        frames, at = np.unique(np.array(self.frame), return_inverse=True)
        require_cells(where, len(frames), len(self._points))
        image = np.full((len(frames), len(self._points), 2), np.nan)
        confidence = np.zeros(image.shape[:2])
        cells = at, np.array(self.point)
        image[cells], confidence[cells] = np.array(self.xy).reshape(-1, 2), np.array(self.sure)
        return Track(frames, tuple(self._points), image, confidence)


def together(tracks: Mapping[str, Track]) -> TrackedPoints:
    """Of all views, points matched by name. A body that is shown in a single frame by both of its views, such as a
    demonstrator that stands still, holds for all frames."""
    several = [view for pair in BODIES for view in pair if any(len(tracks[of].frames) > 1 for of in pair)]
    frames = np.unique(np.concatenate([tracks[view].frames for view in several or VIEWS[:1]]))
    names = _ordered(list(dict.fromkeys(name for view in VIEWS for name in tracks[view].points)))
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


def _ordered(names: Sequence[str]) -> list[str]:
    """Numbers by number, names as they come."""
    return sorted(names, key=int) if all(name.isdecimal() for name in names) else list(names)

"""Tracked points: the track of one view, the tracks of all four views together, and the rows of a table."""

import math
from array import array
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...estimation.views import VIEW_NAMES, VIEWS, FourViews
from ...geometry.affine import MIN_POINTS
from ...geometry.arrays import Floats
from ...wording import first_of
from ..files import MAX_NAME_CHARS, escape
from ..frames import is_missing_value
from .columns import Meaning
from .names import same_names, unmatched_names
from .numbering import FrameLabels

MAX_PX = 1e6  # of a coordinate: no picture is larger
MAX_CELLS = 5_000_000  # frames times points
PERCENT, OWN_GRID = 100, 256  # px: a picture that is no larger is rare
MIN_SPAN = 4.0  # units that a body in pixels spans at least; shares span 1, focal lengths 2 or 3
MIN_SAME, MIN_SHARE = (5, 3), 0.01  # points in one place, of so many names; share of all points
MOST = (10, 90)  # percentiles: a few strays do not tell the unit
CERTAIN = 1.0  # confidence where a file gives none
MAX_CONFIDENCE = 1.5  # some trackers' peaks are a little above 1
FLAGS, COCO_FLAGS = (-1, 0, 1), (-1, 0, 1, 2)  # COCO: 2 visible, 1 labelled but not visible, 0 not labelled
BODIES = (VIEWS[:2], VIEWS[2:])  # the views of each body
Row = tuple[int, str, float, float, float]  # frame, point, x, y, confidence


@dataclass(frozen=True)
class Track:
    """N points in T frames of one view."""

    frames: NDArray[np.uint64]  # (T,) numbers, ascending
    points: tuple[str, ...]  # N names
    image: Floats  # (T, N, 2) px, NaN if not visible
    confidence: Floats  # (T, N)
    flag_1: NDArray[np.bool_] | None = None  # (T, N) whether the flag of visibility is 1; None without flags
    coco: bool = False  # whether the flags are COCO's, so that 1 is not visible
    unread: str = ""  # what of the file is not read

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
        return self

    def above_confidence(self, min_confidence: float) -> Floats:
        """Return the points, (T, N, 2) px, with NaN for those of less confidence."""
        return np.where((self.confidence >= min_confidence)[..., None], self.image, np.nan)

    def non_empty_frames(self) -> "Track":
        """Return the track without frames that show no point."""
        shows = np.isfinite(self.image).all(-1).any(-1)
        flag_1 = None if self.flag_1 is None else self.flag_1[shows]
        shown = self.frames[shows], self.points, self.image[shows], self.confidence[shows]
        return Track(*shown, flag_1, self.coco, self.unread)

    def as_coco(self) -> "Track":
        """Return the track with its flags read as COCO's, where 1 is labelled, but not visible."""
        if self.coco or self.flag_1 is None:
            return self
        return replace(self, confidence=np.where(self.flag_1, 0.0, self.confidence), coco=True)


@dataclass(frozen=True)
class TrackedPoints:
    """N points in T frames of all four views."""

    frames: tuple[int, ...]  # T numbers
    points: tuple[str, ...]  # N names
    image: dict[str, Floats]  # by view, (T, N, 2) px, NaN if not visible
    confidence: dict[str, Floats]  # by view, (T, N)
    names: dict[str, tuple[str, ...]] = field(default_factory=dict)  # by view, those in its file
    notes: tuple[str, ...] = ()  # what is not read, or read otherwise than it stands there

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
        if not all(map(len, shown)):
            return None
        low, high = (float(edge) for edge in np.percentile(np.concatenate(shown), MOST))
        if max(high, -low) <= PERCENT:
            within = f"{0 if low >= 0 else -PERCENT} … {PERCENT}"
            return f"nearly all x and y are in {within}: if these are percent, degrees or millimetres, write pixels"
        if low < 0:
            return None
        if high <= OWN_GRID:
            grid = f"in 0 … {OWN_GRID}: if this is the grid of a tracker such as TAPIR"
            return f"nearly all x and y are {grid}, scale them to the picture's size"
        return None

    def doubtful_place(self) -> str | None:
        """Return a place at which many points of several names are exactly, which may mark lost ones; None without."""
        present = [self._present(view) & ~self._coincide(view)[:, None] for view in VIEWS]
        shown = np.concatenate([self.image[view][seen] for view, seen in zip(VIEWS, present)])
        point = np.concatenate([np.nonzero(seen)[1] for seen in present])
        places, at, count = np.unique(shown @ [1, 1j], return_inverse=True, return_counts=True)
        most = int(count.argmax()) if len(count) else 0
        if not len(count) or count[most] < max(MIN_SAME[0], MIN_SHARE * len(shown)):
            return None
        if len(np.unique(point[at == most])) < MIN_SAME[1]:
            return None
        where = f"({places[most].real:g}, {places[most].imag:g})"
        return (
            f"{count[most]} points of several names are at {where}: if this marks lost points, leave their cells empty"
        )

    def require_pixels(self, where: str) -> "TrackedPoints":
        """Return the tracks. Raises ValueError for a view in which the body spans too few units to be in pixels."""
        for view in VIEWS:
            seen = self._present(view) & (self.confidence[view] > 0)
            if seen.any(0).sum() < MIN_POINTS:
                continue
            shown = self.image[view][seen]
            low, high = np.percentile(shown, MOST, axis=0)
            spans, farthest = high - low, np.abs([low, high]).max(0)
            few = spans[(spans > 0) & (spans < MIN_SPAN) & ((spans.max() < MIN_SPAN) | (farthest < MIN_SPAN))]
            if len(few):
                raise ValueError(
                    f"{where}x and y are no pixels: in {VIEW_NAMES[view]} the body spans {few.max():.2g} units. "
                    "Multiply shares of the picture, 0 … 1, by its width and height. Make shares of -1 … 1 first, by "
                    "(1 + x) / 2. Multiply units of the focal length by that, and add the centre"
                )
        return self

    def no_common_frame(self) -> str | None:
        """Say that no frame number is in all four views, with the numbers in each; None if one is."""
        shows = {view: np.asarray(self._present(view).any(1)) for view in VIEWS}
        if not all(map(np.any, shows.values())) or np.all(list(shows.values()), 0).any():
            return None
        ranges = []
        for view, at in shows.items():
            numbers = [number for number, one in zip(self.frames, at.tolist()) if one]
            ranges.append(f"{VIEW_NAMES[view]} has {numbers[0]}" + (f" to {numbers[-1]}" if numbers[1:] else ""))
        return f"no frame number is in all four views: {', '.join(ranges)}. Number pictures of one moment alike"

    def unmatched_names(self, together: Sequence[Sequence[str]] = (VIEWS,)) -> list[str]:
        """Say which names are not in all views of a group, for each group of views."""
        said = (unmatched_names({view: self.names[view] for view in views}) for views in together if self.names)
        return [one for one in said if one]

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

    def _coincide(self, view: str) -> NDArray[np.bool_]:
        """Return in which frames all points of a view are in one place, (T,): such a frame is refused for that."""
        shown = np.where(self._present(view)[..., None], self.image[view], np.nan)
        with np.errstate(invalid="ignore"):
            return np.asarray((np.fmax.reduce(shown, 1) == np.fmin.reduce(shown, 1)).all(-1))

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


def with_seen(where: str, track: Track, seen: Sequence[tuple[Meaning, Floats]]) -> Track:
    """Return the track with the confidence that all columns about it allow, instead of its own.

    seen: meaning and values, (T, N), of each such column. NaN: not seen; inf: not known. Raises ValueError for a value
    that its column cannot have.
    """
    confidence, flag_1, coco = np.full(track.image.shape[:2], CERTAIN), None, False
    there = np.isfinite(track.image).all(-1)
    for meaning in dict.fromkeys(one for one, _ in seen):
        values = _least_seen(meaning, np.stack([column for one, column in seen if one is meaning]))
        known = values[there & np.isfinite(values)]
        flags = meaning is Meaning.VISIBLE and np.isin(known, COCO_FLAGS).all()
        upto = 2.0 if flags else 1.0 if meaning is Meaning.HIDDEN else MAX_CONFIDENCE
        wrong = there & np.isfinite(values) & ((values > upto) | ((values < 0) & (meaning is Meaning.HIDDEN)))
        if wrong.any():
            t, n = np.argwhere(wrong)[0]
            remedy = "write 1 or 0, or a share: divide percentages by 100, and write 1 / (1 + exp(-x)) for a logit x"
            raise ValueError(
                f"{where}: frame {track.frames[t]}, point {escape(track.points[n], MAX_NAME_CHARS)}: "
                f"{meaning.value} {values[t, n]:g} is not in 0 … 1: {remedy}"
            )
        if flags:
            coco = bool((known == 2).any())
            flag_1 = there & (values == 1) if np.isin(known, COCO_FLAGS if coco else FLAGS).all() else None
        if meaning is Meaning.VISIBLE and len(set(known.tolist())) == 1:  # yes or nothing
            values = np.where(np.isinf(values), 0.0, values)
        sure = 1 - values if meaning is Meaning.HIDDEN else values == 2 if coco and flags else values
        confidence = np.minimum(confidence, np.where(np.isinf(values), CERTAIN, sure))
    return replace(track, confidence=confidence, flag_1=flag_1, coco=coco)


def _least_seen(meaning: Meaning, values: Floats) -> Floats:
    """What says least that a point is seen, of columns of one meaning, (columns, T, N); inf: none does."""
    if meaning is not Meaning.HIDDEN:
        return np.asarray(values.min(0))
    most = np.where(np.isposinf(values), -np.inf, values).max(0)
    return np.where(np.isneginf(most), np.inf, most)


class Rows:
    """The rows of one view while they are read, in a few bytes each. seen: meanings of its columns about that."""

    def __init__(self, labels: FrameLabels, seen: Sequence[Meaning] = ()):
        self._points: dict[str, int] = {}
        self.labels = labels
        self.frame, self.point, self.line = array("q"), array("l"), array("l")  # frame: index of its label
        self.xy, self.seen = array("d"), [(meaning, array("d")) for meaning in seen]

    def add(self, line: int, frame: int, point: str, x: float, y: float, seen: Sequence[float]) -> None:
        """Add one row. frame: index of its label; seen: a value for each column about that."""
        self.frame.append(frame)
        self.point.append(self._points.setdefault(point, len(self._points)))
        self.line.append(line)
        self.xy.extend((x, y))
        for (_, values), value in zip(self.seen, seen):
            values.append(value)

    def require_once(self, where: str, view: str = "", hint: str = "") -> None:
        """Raise ValueError with the lines of two rows of the same frame and point."""
        frame, point = self._frames(), np.array(self.point)
        order = np.lexsort((point, frame))  # stable: of equal rows the earlier line comes first
        same = (np.diff(frame[order]) == 0) & (np.diff(point[order]) == 0)
        if not same.any():
            return
        line = np.array(self.line)[order]
        k = int(np.flatnonzero(same)[line[1:][same].argmin()])
        at = self.line.index(int(line[k + 1]))
        name = escape(list(self._points)[self.point[at]], MAX_NAME_CHARS)
        of = f" in view {view}" if view else ""
        raise ValueError(
            f"{where}: line {line[k + 1]}: point {name} of frame {self.labels.described(int(frame[at]))}{of} stands in "
            f"line {line[k]} too{hint}"
        )

    def points(self) -> tuple[str, ...]:
        """Return the names of all points."""
        return tuple(self._points)

    def track(self, where: str) -> Track:
        """Return all rows as a track. Raises ValueError as `require_cells` and `with_seen`."""
        frames, at = np.unique(self._frames(), return_inverse=True)
        require_cells(where, len(frames), len(self._points))
        cells = at, np.array(self.point, int)

        def spread(values: "array[float]", missing: float) -> Floats:
            found = np.full((len(frames), len(self._points)), missing)
            found[cells] = np.array(values)
            return found

        image = np.stack([spread(self.xy[axis::2], np.nan) for axis in (0, 1)], -1)
        seen = [(meaning, spread(values, 0.0)) for meaning, values in self.seen]
        return with_seen(where, Track(frames, tuple(self._points), image, np.zeros(image.shape[:2])), seen)

    def _frames(self) -> NDArray[np.uint64]:
        return self.labels.numbers()[np.array(self.frame, int)]


def combine_views(tracks: Mapping[str, Track]) -> TrackedPoints:
    """Match the points of all views by name.

    If both views of a body have a single frame, such as a demonstrator that stands still, it is used for all frames.
    Raises ValueError as `require_cells`.
    """
    several = [view for pair in BODIES for view in pair if any(len(tracks[of].frames) > 1 for of in pair)]
    frames = np.unique(np.concatenate([tracks[view].frames for view in several or VIEWS[:1]]))
    same = same_names({view: tracks[view].points for view in VIEWS})
    named = {view: tuple(same.get(name, name) for name in tracks[view].points) for view in VIEWS}
    names = list(dict.fromkeys(name for view in VIEWS for name in named[view]))
    if all(name.isdecimal() for name in names):
        names = sorted(names, key=int)
    require_cells("all views together", len(frames), len(names))
    column = {name: k for k, name in enumerate(names)}
    image = {view: np.full((len(frames), len(names), 2), np.nan) for view in VIEWS}
    confidence = {view: np.zeros((len(frames), len(names))) for view in VIEWS}
    notes = _notes(tracks, same)
    for view in VIEWS:
        track = tracks[view].as_coco() if any(tracks[of].coco for of in VIEWS) else tracks[view]
        at = np.searchsorted(frames, track.frames) if view in several else np.arange(len(frames))
        where = np.array([column[name] for name in named[view]], int)
        cells = at[:, None], where
        image[view][cells], confidence[view][cells] = track.image, track.confidence
    return TrackedPoints(tuple(frames.tolist()), tuple(names), image, confidence, named, notes)


def _notes(tracks: Mapping[str, Track], same: Mapping[str, str]) -> tuple[str, ...]:
    """What is not read, or read otherwise than it stands there, in one line each."""
    notes, unread = [], dict[str, list[str]]()
    for view in VIEWS:
        unread.setdefault(tracks[view].unread, []).append(VIEW_NAMES[view])
    said = [
        what + (f" of {', '.join(views)}" if len(views) < len(VIEWS) else "") for what, views in unread.items() if what
    ]
    if said:
        notes.append(f"not read: {'; '.join(said)}")
    coco = any(tracks[view].coco for view in VIEWS)
    flags = [track.flag_1 for track in tracks.values() if coco and track.flag_1 is not None]
    if labelled := sum(int(ones.sum()) for ones in flags):
        notes.append(
            f"visible is 0, 1 or 2, as in COCO: {labelled} points of 1 are labelled, but not visible: left out"
        )
    if same:
        pairs = [f"{escape(a, MAX_NAME_CHARS)} = {escape(b, MAX_NAME_CHARS)}" for a, b in same.items()]
        notes.append(f"taken for the same point: {first_of(pairs, 6)}")
    return tuple(notes)

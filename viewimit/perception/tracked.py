"""Tracked points as CSV: tidy files of all four views, and DeepLabCut's, one a view.

Tidy: frame, view, point, x, y, confidence; a row a point that was seen in a picture. DeepLabCut: three rows of
headings, scorer, bodyparts, coords, then a row a frame. Both in pixels, (0, 0) at the picture's upper left.
"""

import csv
import math
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..views import VIEWS, FourViews

COLUMNS = ("frame", "view", "point", "x", "y", "confidence")
MOST_PX = 1e6  # beyond which no picture goes
MOST_FRAME = 2**53
CERTAIN = 1.0  # where no confidence is given
COORDINATES = ("x", "y", "likelihood")
Row = tuple[int, str, float, float, float]  # frame, point, x, y, confidence


@dataclass(frozen=True)
class TrackedPoints:
    """T frames of N points. frames: (T,) numbers; points: N names; image: by view (T, N, 2) px, NaN where not seen;
    confidence: by view (T, N)."""

    frames: tuple[int, ...]
    points: tuple[str, ...]
    image: dict[str, NDArray]
    confidence: dict[str, NDArray]

    def views(self, least_confidence: float = 0.0) -> FourViews:
        """All frames: (T, N, …). Points of less confidence were not seen."""
        sure = {view: self.confidence[view] >= least_confidence for view in VIEWS}
        return FourViews.from_images(*(np.where(sure[view][..., None], self.image[view], np.nan) for view in VIEWS))


class _Rows:
    """The rows of one view as they are read, a few bytes each. Raises ValueError for numbers that are none."""

    def __init__(self, points: dict[str, int]):
        self._points = points  # of all views: names to columns
        self.frame, self.point, self.line = array("q"), array("l"), array("l")
        self.xy, self.sure = array("d"), array("d")

    def add(self, line: int, frame: int, point: str, x: float, y: float, sure: float) -> None:
        self.frame.append(frame)
        self.point.append(self._points.setdefault(point, len(self._points)))
        self.line.append(line)
        self.xy.extend((x, y))
        self.sure.append(sure)

    def twice(self) -> tuple[int, int] | None:
        """Lines of the first two rows of the same frame and point; None if there are none."""
        frame, point = np.array(self.frame), np.array(self.point)
        order = np.lexsort((point, frame))  # stable: of equal ones the earlier line comes first
        same = (np.diff(frame[order]) == 0) & (np.diff(point[order]) == 0)
        if not same.any():
            return None
        line = np.array(self.line)[order]
        k = int(np.flatnonzero(same)[line[1:][same].argmin()])
        return int(line[k]), int(line[k + 1])


def _gather(rows: Mapping[str, _Rows], names: Sequence[str]) -> TrackedPoints:
    """Of all views. A view of a single frame, such as of a demonstrator that stands still, holds for all frames."""
    numbers = {view: np.array(rows[view].frame) for view in VIEWS}
    several = [view for view in VIEWS if len(np.unique(numbers[view])) > 1]
    frames = np.unique(np.concatenate([numbers[view] for view in several or VIEWS[:1]]))
    ordered = sorted(names, key=int) if all(name.isdecimal() for name in names) else list(names)
    column = np.array([ordered.index(name) for name in names])
    image = {view: np.full((len(frames), len(names), 2), np.nan) for view in VIEWS}
    confidence = {view: np.zeros((len(frames), len(names))) for view in VIEWS}
    for view in VIEWS:
        where = column[np.array(rows[view].point)]
        at = np.searchsorted(frames, numbers[view]) if view in several else np.zeros(len(where), int)
        shown = image[view] if view in several else image[view][:1]
        shown[at, where] = np.array(rows[view].xy).reshape(-1, 2)
        sure = confidence[view] if view in several else confidence[view][:1]
        sure[at, where] = np.array(rows[view].sure)
        if view not in several:
            image[view][:], confidence[view][:] = shown, sure
    return TrackedPoints(tuple(frames.tolist()), tuple(ordered), image, confidence)


def write_tidy(path: Path, rows: Mapping[str, Sequence[Row]]) -> None:
    """Raises OSError."""
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(COLUMNS)
        for view in VIEWS:
            for frame, point, x, y, sure in rows.get(view, ()):
                out.writerow((frame, view, point, f"{x:.4f}", f"{y:.4f}", f"{sure:.4f}"))


def read_tidy(path: Path) -> TrackedPoints:
    """Raises ValueError that names the file, and the line and column of what is wrong; OSError."""
    lines = _lines(path)
    at, heading = next(lines, (0, []))
    if not at:
        raise ValueError(f"{path}: the file is empty")
    if heading and heading[0] == "scorer":
        raise ValueError(f"{path}: DeepLabCut's files hold one view each: give four, by --l, --r, --L and --R")
    missing = [name for name in COLUMNS[:-1] if name not in heading]
    if missing:
        raise ValueError(f"{path}: line {at}: no column {', '.join(missing)}; the first line is {','.join(COLUMNS)}")
    frame_at, view_at, point_at, x_at, y_at = (heading.index(name) for name in COLUMNS[:-1])
    sure_at = heading.index(COLUMNS[-1]) if COLUMNS[-1] in heading else None
    names: dict[str, int] = {}
    rows = {view: _Rows(names) for view in VIEWS}
    for line, cells in lines:
        if len(cells) != len(heading):
            raise ValueError(f"{path}: line {line}: {len(cells)} cells, but {len(heading)} columns")
        frame = _whole(path, line, "frame", cells[frame_at])
        view, point = cells[view_at].strip(), cells[point_at].strip()
        if view not in rows:
            raise ValueError(f"{path}: line {line}, column view: {view!r} is none of {', '.join(VIEWS)}")
        if not point:
            raise ValueError(f"{path}: line {line}, column point: it is empty")
        x = _number(path, line, "x", cells[x_at], empty=np.nan)
        y = _number(path, line, "y", cells[y_at], empty=np.nan)
        sure = CERTAIN if sure_at is None else _number(path, line, COLUMNS[-1], cells[sure_at], empty=CERTAIN)
        rows[view].add(line, frame, point, x, y, sure)
    for view in VIEWS:
        twice = rows[view].twice()
        if twice is not None:
            k = rows[view].line.index(twice[1])
            frame, point = rows[view].frame[k], list(names)[rows[view].point[k]]
            raise ValueError(
                f"{path}: line {twice[1]}: point {point} of frame {frame} in view {view} stands in line {twice[0]} too"
            )
    lacking = [view for view in VIEWS if not rows[view].line]
    if lacking:
        raise ValueError(f"{path}: no row of view {', '.join(lacking)}; all of {', '.join(VIEWS)} are needed")
    return _gather(rows, tuple(names))


def read_deeplabcut(paths: Mapping[str, Path]) -> TrackedPoints:
    """One file a view. Raises ValueError that names the file, and the line and column of what is wrong; OSError."""
    names: dict[str, int] = {}
    return _gather({view: _deeplabcut_rows(paths[view], names) for view in VIEWS}, tuple(names))


def _deeplabcut_rows(path: Path, names: dict[str, int]) -> _Rows:
    lines = _lines(path)
    head = list(islice(lines, 3))
    if [cells[0] if cells else "" for _, cells in head] != ["scorer", "bodyparts", "coords"]:
        raise ValueError(f"{path}: its first three lines must begin with scorer, bodyparts, coords, as DeepLabCut's do")
    (_, _), (line, parts), (_, coordinates) = head
    if len(parts) != len(coordinates) or (len(parts) - 1) % 3 or len(parts) < 4:
        raise ValueError(f"{path}: line {line}: needs x, y and likelihood of each body part")
    for column in range(1, len(parts), 3):
        if tuple(coordinates[column : column + 3]) != COORDINATES or len(set(parts[column : column + 3])) != 1:
            raise ValueError(f"{path}: line {line + 1}, column {column + 1}: needs x, y, likelihood of one body part")
    rows = _Rows(names)
    for line, cells in lines:
        if len(cells) != len(parts):
            raise ValueError(f"{path}: line {line}: {len(cells)} cells, but {len(parts)} columns")
        frame = _whole(path, line, "1", cells[0])
        for column in range(1, len(parts), 3):
            numbers = [
                _number(path, line, f"{column + k + 1} ({parts[column]} {COORDINATES[k]})", cells[column + k], np.nan)
                for k in range(3)
            ]
            if all(map(math.isfinite, numbers)):
                rows.add(line, frame, parts[column], *numbers)
    if not rows.line:
        raise ValueError(f"{path}: no point in any frame")
    return rows


def _lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Line numbers from 1 and cells, empty lines left out."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file, strict=True)
            for cells in reader:
                if cells and (cells[0] or any(map(str.strip, cells))):
                    yield reader.line_num, cells
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file in UTF-8") from None
    except csv.Error as error:
        raise ValueError(f"{path}: line {reader.line_num}: {error}") from None


def _number(path: Path, line: int, column: str, text: str, empty: float) -> float:
    try:
        value = float(text)
        if -MOST_PX <= value <= MOST_PX:
            return value
    except ValueError:
        value = math.inf
    text = text.strip()
    if not text or text.lower() == "nan":
        return empty
    what = f"is no pixel: beyond {MOST_PX:g}" if math.isfinite(value) else "is not a finite number"
    raise ValueError(f"{path}: line {line}, column {column}: {text!r} {what}")


def _whole(path: Path, line: int, column: str, text: str) -> int:
    if not (text.isdecimal() or text.strip().isdecimal()) or int(text) > MOST_FRAME:
        raise ValueError(f"{path}: line {line}, column {column}: {text.strip()!r} is not a whole number from 0")
    return int(text)

"""Tracked points as CSV: tidy files of all four views, and DeepLabCut's, one a view.

Tidy: frame, view, point, x, y, confidence; a row a point that was seen in a picture. DeepLabCut: three rows of
headings, scorer, bodyparts, coords, then a row a frame. Both in pixels, (0, 0) at the picture's upper left.
"""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..views import VIEWS, FourViews

COLUMNS = ("frame", "view", "point", "x", "y", "confidence")
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


def gather(rows: Mapping[str, Sequence[Row]]) -> TrackedPoints:
    """Rows by view. A view of a single frame, such as of a demonstrator that stands still, holds for all frames."""
    seen = {view: sorted({row[0] for row in rows[view]}) for view in VIEWS}
    several = [view for view in VIEWS if len(seen[view]) > 1]
    frames = tuple(sorted(set().union(*(seen[view] for view in several or VIEWS[:1]))))
    names = dict.fromkeys(row[1] for view in VIEWS for row in rows[view])
    points = tuple(sorted(names, key=int) if all(name.isdecimal() for name in names) else names)
    place, column = ({key: k for k, key in enumerate(keys)} for keys in (frames, points))
    image = {view: np.full((len(frames), len(points), 2), np.nan) for view in VIEWS}
    confidence = {view: np.zeros((len(frames), len(points))) for view in VIEWS}
    for view in VIEWS:
        for frame, point, x, y, sure in rows[view]:
            where = place[frame] if view in several else slice(None)
            image[view][where, column[point]] = x, y
            confidence[view][where, column[point]] = sure
    return TrackedPoints(frames, points, image, confidence)


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
    if not lines:
        raise ValueError(f"{path}: the file is empty")
    (at, heading), *body = lines
    if heading and heading[0] == "scorer":
        raise ValueError(f"{path}: DeepLabCut's files hold one view each: give four, by --l, --r, --L and --R")
    missing = [name for name in COLUMNS[:-1] if name not in heading]
    if missing:
        raise ValueError(f"{path}: line {at}: no column {', '.join(missing)}; the first line is {','.join(COLUMNS)}")
    rows: dict[str, list[Row]] = {view: [] for view in VIEWS}
    before: dict[tuple, int] = {}
    for line, cells in body:
        if len(cells) != len(heading):
            raise ValueError(f"{path}: line {line}: {len(cells)} cells, but {len(heading)} columns")
        cell = dict(zip(heading, (text.strip() for text in cells)))
        frame = _whole(path, line, "frame", cell["frame"])
        view, point = cell["view"], cell["point"]
        if view not in VIEWS:
            raise ValueError(f"{path}: line {line}, column view: {view!r} is none of {', '.join(VIEWS)}")
        if not point:
            raise ValueError(f"{path}: line {line}, column point: it is empty")
        key = frame, view, point
        if key in before:
            raise ValueError(
                f"{path}: line {line}: point {point} of frame {frame} in view {view} stands in line {before[key]} too"
            )
        before[key] = line
        x, y = (_number(path, line, name, cell[name], empty=np.nan) for name in ("x", "y"))
        sure = _number(path, line, "confidence", cell.get("confidence", ""), empty=CERTAIN)
        rows[view].append((frame, point, x, y, sure))
    lacking = [view for view in VIEWS if not rows[view]]
    if lacking:
        raise ValueError(f"{path}: no row of view {', '.join(lacking)}; all of {', '.join(VIEWS)} are needed")
    return gather(rows)


def read_deeplabcut(paths: Mapping[str, Path]) -> TrackedPoints:
    """One file a view. Raises ValueError that names the file, and the line and column of what is wrong; OSError."""
    return gather({view: _deeplabcut_rows(paths[view]) for view in VIEWS})


def _deeplabcut_rows(path: Path) -> list[Row]:
    lines = _lines(path)
    names = [cells[0] if cells else "" for _, cells in lines[:3]]
    if names != ["scorer", "bodyparts", "coords"]:
        raise ValueError(f"{path}: its first three lines must begin with scorer, bodyparts, coords, as DeepLabCut's do")
    (_, _), (line, parts), (_, coordinates) = lines[:3]
    if len(parts) != len(coordinates) or (len(parts) - 1) % 3 or len(parts) < 4:
        raise ValueError(f"{path}: line {line}: needs x, y and likelihood of each body part")
    for column in range(1, len(parts), 3):
        if tuple(coordinates[column : column + 3]) != COORDINATES or len(set(parts[column : column + 3])) != 1:
            raise ValueError(f"{path}: line {line + 1}, column {column + 1}: needs x, y, likelihood of one body part")
    rows: list[Row] = []
    for line, cells in lines[3:]:
        if len(cells) != len(parts):
            raise ValueError(f"{path}: line {line}: {len(cells)} cells, but {len(parts)} columns")
        frame = _whole(path, line, "1", cells[0])
        for column in range(1, len(parts), 3):
            numbers = [
                _number(path, line, f"{column + k + 1} ({parts[column]} {COORDINATES[k]})", cells[column + k], np.nan)
                for k in range(3)
            ]
            if np.isfinite(numbers).all():
                x, y, likelihood = numbers
                rows.append((frame, parts[column], x, y, likelihood))
    if not rows:
        raise ValueError(f"{path}: no point in any frame")
    return rows


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """Line numbers from 1 and cells, empty lines left out."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file, strict=True)
            return [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file in UTF-8") from None
    except csv.Error as error:
        raise ValueError(f"{path}: line {reader.line_num}: {error}") from None


def _number(path: Path, line: int, column: str, text: str, empty: float) -> float:
    if not text or text.lower() == "nan":
        return empty
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{path}: line {line}, column {column}: {text!r} is not a finite number")
    return value


def _whole(path: Path, line: int, column: str, text: str) -> int:
    if not text.isdecimal():
        raise ValueError(f"{path}: line {line}, column {column}: {text!r} is not a whole number from 0")
    return int(text)

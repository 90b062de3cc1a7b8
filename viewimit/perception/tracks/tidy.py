"""Tidy tables: frame, view, point, x, y, confidence; a row a point that was seen in a picture, of all four views."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ...views import VIEWS
from .cells import Table, column_names
from .colmap import colmap_kind, converting
from .track import CERTAIN, Row, Rows, TrackedPoints, together

COLUMNS = ("frame", "view", "point", "x", "y", "confidence")


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
    table = Table(path)
    lines = table.lines()
    at, cells = next(lines)
    heading = column_names(cells)
    missing = [name for name in COLUMNS[:-1] if name not in heading]
    if kind := colmap_kind(",".join(map(str.strip, cells))):
        raise ValueError(f"{path}: {converting(path, kind)}")
    if missing:
        one = ". Files of one view are given by --l, --r, --L and --R" if "view" in missing else ""
        said = f"no column {', '.join(missing)}; the first line is {','.join(COLUMNS)}{one}"
        raise ValueError(f"{path}: line {at}: {said}")
    twice = [name for name in COLUMNS if heading.count(name) > 1]
    if twice:
        raise ValueError(f"{path}: line {at}: two columns are named {twice[0]}: keep one of them")
    frame_at, view_at, point_at, x_at, y_at = (heading.index(name) for name in COLUMNS[:-1])
    sure_at = heading.index(COLUMNS[-1]) if COLUMNS[-1] in heading else None
    names: dict[str, int] = {}
    rows = {view: Rows(names) for view in VIEWS}
    for line, cells in lines:
        if len(cells) != len(heading):
            table.require_count(line, cells, len(heading))
        frame = table.whole(line, "frame", cells[frame_at])
        view, point = cells[view_at].strip(), cells[point_at].strip()
        if view not in rows:
            raise ValueError(f"{path}: line {line}, column view: {view!r} is none of {', '.join(VIEWS)}")
        if not point:
            raise ValueError(f"{path}: line {line}, column point: it is empty")
        x = table.number(line, "x", cells[x_at], empty=np.nan)
        y = table.number(line, "y", cells[y_at], empty=np.nan)
        sure = CERTAIN if sure_at is None else table.number(line, COLUMNS[-1], cells[sure_at], empty=CERTAIN)
        rows[view].add(line, frame, point, x, y, sure)
    for view in VIEWS:
        rows[view].require_once(str(path), view)
    lacking = [view for view in VIEWS if not rows[view].line]
    if lacking:
        raise ValueError(f"{path}: no row of view {', '.join(lacking)}; all of {', '.join(VIEWS)} are needed")
    return together({view: rows[view].track(str(path)).require_units(f"{path}: view {view}") for view in VIEWS})

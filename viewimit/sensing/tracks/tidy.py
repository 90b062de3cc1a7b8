"""Tidy tables: frame, view, point, x, y, confidence; a row a point that was seen in a picture, of all four views."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ...estimation.views import VIEW_NAMES, VIEWS, view_of
from .cells import Table, column_names
from .colmap import colmap_kind, converting
from .track import CERTAIN, Row, Rows, TrackedPoints, together

COLUMNS = ("frame", "view", "point", "x", "y", "confidence")


def write_tidy(path: Path, rows: Mapping[str, Sequence[Row]]) -> None:
    """rows: by view, whose full name is written. Raises OSError."""
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(COLUMNS)
        for view in VIEWS:
            for frame, point, x, y, sure in rows.get(view, ()):
                out.writerow((frame, VIEW_NAMES[view], point, f"{x:.4f}", f"{y:.4f}", f"{sure:.4f}"))


def read_tidy(path: Path) -> TrackedPoints:
    """Views are called by their full names, demo_left, or by the paper's, l.

    Raises ValueError that names the file, and the line and column of what is wrong; OSError.
    """
    table = Table(path)
    lines = table.lines()
    at, cells = next(lines)
    heading = column_names(cells)
    missing = [name for name in COLUMNS[:-1] if name not in heading]
    if kind := colmap_kind(",".join(map(str.strip, cells))):
        raise ValueError(f"{path}: {converting(path, kind)}")
    if missing:
        one = (
            ". Files of one view are given by --demo-left, --demo-right, --own-left and --own-right"
            if "view" in missing
            else ""
        )
        said = f"no column {', '.join(missing)}; the first line is {','.join(COLUMNS)}{one}"
        raise ValueError(f"{path}: line {at}: {said}")
    twice = [name for name in COLUMNS if heading.count(name) > 1]
    if twice:
        raise ValueError(f"{path}: line {at}: two columns are named {twice[0]}: keep one of them")
    frame_at, view_at, point_at, x_at, y_at = (heading.index(name) for name in COLUMNS[:-1])
    sure_at = heading.index(COLUMNS[-1]) if COLUMNS[-1] in heading else None
    names: dict[str, int] = {}
    rows, known = {view: Rows(names) for view in VIEWS}, dict[str, str]()
    for line, cells in lines:
        if len(cells) != len(heading):
            table.require_count(line, cells, len(heading))
        frame = table.whole(line, "frame", cells[frame_at])
        view, point = known.get(cells[view_at]), cells[point_at].strip()
        if view is None:
            try:
                view = known[cells[view_at]] = view_of(cells[view_at].strip())
            except ValueError as error:
                raise ValueError(f"{path}: line {line}, column view: {error}") from None
        if not point:
            raise ValueError(f"{path}: line {line}, column point: it is empty")
        x = table.number(line, "x", cells[x_at], empty=np.nan)
        y = table.number(line, "y", cells[y_at], empty=np.nan)
        sure = CERTAIN if sure_at is None else table.number(line, COLUMNS[-1], cells[sure_at], empty=CERTAIN)
        rows[view].add(line, frame, point, x, y, sure)
    for view in VIEWS:
        rows[view].require_once(str(path), VIEW_NAMES[view])
    lacking = [VIEW_NAMES[view] for view in VIEWS if not rows[view].line]
    if lacking:
        needed = ", ".join(VIEW_NAMES.values())
        raise ValueError(f"{path}: no row of view {', '.join(lacking)}; all of {needed} are needed")
    where = {view: f"{path}: view {VIEW_NAMES[view]}" for view in VIEWS}
    return together({view: rows[view].track(str(path)).require_units(where[view]) for view in VIEWS})

"""A plain table of one view: a row a point, columns frame, point, x, y and confidence under whatever name they go, as
OpenCV's keypoints, COLMAP's points of an image or a spreadsheet have them. Without a frame all rows are of one."""

from pathlib import Path

import numpy as np

from .cells import Table
from .track import CERTAIN, Rows, Track

MEANT = {  # headings in small letters, without spaces, dots, underlines and brackets
    "frame": ("frame", "frameidx", "frameindex", "frameid", "framenumber", "image", "imageid", "imageidx", "t"),
    "point": ("point", "pointid", "pointname", "name", "id", "keypoint", "keypointid", "keypointname", "bodypart",
              "node", "nodename", "trackid", "point3did", "classid", "marker", "markerid", "label"),
    "x": ("x", "xpx", "u", "upx", "ptx", "px", "posx", "xpixel"),
    "y": ("y", "ypx", "v", "vpx", "pty", "py", "posy", "ypixel"),
    "confidence": ("confidence", "likelihood", "score", "probability", "prob", "visibility", "visible"),
}  # fmt: skip
NEEDED = ("point", "x", "y")


def read_plain(path: Path) -> Track:
    """Raises ValueError that names the file, and the line and column of what is wrong; OSError."""
    table = Table(path)
    lines = table.lines()
    line, heading = next(lines)
    at = _columns(path, line, heading)
    rows = Rows()
    for line, cells in lines:
        table.require_count(line, cells, len(heading))
        frame = table.whole(line, heading[at["frame"]], cells[at["frame"]]) if "frame" in at else 0
        point = cells[at["point"]].strip()
        if point in ("", "-1"):  # of no keypoint, or of none that COLMAP has matched
            continue
        x, y = (table.number(line, heading[at[name]], cells[at[name]], empty=np.nan) for name in "xy")
        sure = CERTAIN
        if "confidence" in at:
            sure = table.number(line, heading[at["confidence"]], cells[at["confidence"]], empty=CERTAIN)
        rows.add(line, frame, point, x, y, sure)
    rows.require_once(str(path))
    return rows.track(str(path))


def _columns(path: Path, line: int, heading: list[str]) -> dict[str, int]:
    """Which column is what. Raises ValueError for what is missing, or meant by two columns."""
    plain = ["".join(filter(str.isalnum, name.lower())) for name in heading]
    at: dict[str, int] = {}
    for wanted, names in MEANT.items():
        found = [k for k, name in enumerate(plain) if name in names]
        exact = [k for k in found if plain[k] == wanted]
        if len(found) > 1 and len(exact) != 1:
            said = " or ".join(heading[k] for k in found)
            raise ValueError(f"{path}: line {line}: is {wanted} the column {said}? Keep one of them, as {wanted}")
        if found:
            at[wanted] = (exact or found)[0]
    missing = [name for name in NEEDED if name not in at]
    if missing:
        spaces = len(heading) == 1 and len(heading[0].split()) >= len(NEEDED)
        hint = ": separate columns by , or ; or tabs, not spaces" if spaces else ""
        raise ValueError(
            f"{path}: line {line}: no column {', '.join(missing)}{hint}; a table of one view begins with the line "
            "frame,point,x,y,confidence, where points of the same name in all views are the same"
        )
    return at

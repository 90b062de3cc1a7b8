"""What `evaluate` tells of points that are likely wrong: as JSON has it, and in words."""

from collections.abc import Sequence

from ..estimation.outliers import Outlier, OutlierReport
from ..estimation.views import VIEW_NAMES

SHOWN = 6  # frames that are named in words


def told(suspects: OutlierReport, points: Sequence[str], numbers: Sequence[int]) -> list[dict]:
    """points: names; numbers: of the frames. E and E_swapped, px², are of swapped points only."""
    return [_told(suspect, points, numbers) for suspect in suspects.found]


def in_words(suspect: dict, frames: int) -> tuple[str, str, str]:
    """The points, what is wrong with them, and how much speaks for that. frames: how many there are."""
    named, where = " and ".join(suspect["points"]), " or ".join(suspect["views"])
    if suspect["kind"] == "swapped":
        falls = f"E {suspect['E']:.3g} px², {suspect['E_swapped']:.3g} px² permuted: falls {suspect['score']:.3g} times"
        return named, f"swapped in {where.replace(' or ', ', ')}", falls
    seen = suspect["frames"]
    those = ", ".join(map(str, seen[:SHOWN])) + (" …" if len(seen) > SHOWN else "")
    which = f"frame {those}" if len(seen) == 1 else f"{len(seen)} of {frames} frames: {those}"
    return named, f"misplaced in {where}", f"{suspect['score']:.3g} standard deviations of the others off; {which}"


def _told(suspect: Outlier, points: Sequence[str], numbers: Sequence[int]) -> dict:
    said = {
        "kind": suspect.kind,
        "points": [points[k] for k in suspect.points],
        "views": [VIEW_NAMES[view] for view in suspect.views],
        "frames": [numbers[k] for k in suspect.frames],
        "score": suspect.score,
    }
    if suspect.kind == "swapped":
        said |= {"E": suspect.E, "E_swapped": suspect.E_swapped}
    return said

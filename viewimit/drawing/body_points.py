"""What body points tell, for whoever edits them: bars of what a pixel costs at each joint, and sentences."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.observability import PointInformation, Proposal, unobservable_joints
from ..estimation.transfers.registry import FLATNESS
from ..geometry.affine import MIN_POINTS
from . import svg
from .observability import described, draw_bars

WIDTH, ROW = 250, 19  # px, of the drawing and of a joint
EACH = 3  # joints that a sentence names all of


def draw_edited(
    joints: Sequence[int], information: PointInformation, proposal: Proposal | None, searching: bool
) -> str:
    """How many points, how flat they are, a bar a joint, and what a further point would change. joints: numbers from
    1."""
    lines = [f"<b>{_counted(information)}</b>{_flat(information)}"]
    spread = information.std_per_px
    if spread is not None:
        height = ROW * len(joints)
        bars = draw_bars(joints, spread, WIDTH, ROW)
        lines.append(f'1 px of noise costs<svg class="vi" viewBox="0 0 {WIDTH} {height}">{bars}</svg>')
    words = _next(joints, proposal, searching)
    return "".join(f"<div>{line}</div>" for line in (*lines, svg.escape(words)) if line)


def describe_edited(
    joints: Sequence[int], information: PointInformation, proposal: Proposal | None, searching: bool
) -> str:
    """The same in a sentence or two."""
    if information.std_per_px is None:
        told = f"{_counted(information)}; a transfer needs {MIN_POINTS}."
    else:
        told = f"{_counted(information)}; {_costs(joints, information.std_per_px)}{_flat(information)}."
    return f"{told} {_next(joints, proposal, searching) or 'Click an arm to place one.'}"


def _counted(information: PointInformation) -> str:
    count, seen = information.count, information.visible
    return f"{count} points" if seen == count else f"{count} points, {seen} seen in all images"


def _flat(information: PointInformation) -> str:
    return f"; {FLATNESS} {svg.number(information.flatness, 0)}" if np.isfinite(information.flatness) else ""


def _next(joints: Sequence[int], proposal: Proposal | None, searching: bool) -> str:
    if searching:
        return "Looking for the best next point …"
    if proposal is None:
        return ""
    after = proposal.after.std_per_px
    return "The hollow one tells most" + ("." if after is None else f": {_costs(joints, after)}.")


def _costs(joints: Sequence[int], spread: NDArray) -> str:
    """Of many joints the costliest, and those that are not told."""
    if len(joints) <= EACH:
        return described(joints, spread)
    untold = unobservable_joints(spread)
    told = [k for k in np.argsort(-spread) if k not in untold][:1]
    chosen = [*told, *sorted(untold)]
    return described([joints[k] for k in chosen], spread[chosen]).replace("costs", "costs at most", 1)

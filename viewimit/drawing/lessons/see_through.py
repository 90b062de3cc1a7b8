"""A posture that the visitor gives a see-through arm, in an image of the learner's own: dashed, its points hollow."""

from collections.abc import Callable, Collection
from dataclasses import dataclass

from numpy.typing import NDArray

from ...loop.snapshot import Snapshot
from .. import svg
from ..theme import HEAD

LAYERS = ("guessed", "guessed arrows")


@dataclass(frozen=True)
class SeeThrough:
    """moment: what would be seen there; bones: (2, k, 2) px, its skeleton in L and R; room: (2, n, 2) px, all that it
    may reach in them."""

    moment: Snapshot
    bones: NDArray
    room: NDArray


def draw_see_through(
    arm: SeeThrough, side: int, layers: Collection[str], place: Callable[[NDArray], NDArray]
) -> list[str]:
    """side: 0 for L, 1 for R; place: px to units."""
    parts: list[str] = []
    columns = slice(2 * side, 2 * side + 2)
    seen = arm.moment.views.visible[:, 2 + side]
    if "guessed" in layers:
        points = place(arm.moment.views.own[seen, columns])
        parts.append(f'<path class="vi-guessed-bone" d="{svg.path(place(arm.bones[side]))}"/>')
        parts.append(f'<path class="vi-guessed" d="{svg.circles(points, 4.2)}"/>')
    if "guessed arrows" in layers and arm.moment.transfer is not None:
        usable = arm.moment.usable
        own = place(arm.moment.views.own[usable, columns])
        recovered = place(arm.moment.recovered[usable, columns])
        tips = svg.arrow_tips(recovered[None], own[None], 1.6 * HEAD)[0]
        parts.append(f'<path class="vi-e" d="{svg.segments(recovered, own)}"/><path class="vi-tip" d="{tips}"/>')
    return parts

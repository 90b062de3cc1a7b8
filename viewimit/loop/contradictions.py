"""The step after looking: what one camera shows of a point and the other contradicts is not believed.

One head makes all pairs of views, so each look is held against the matches of those before it as well.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import FourViews
from ..geometry.rectification import Rectification
from ..geometry.robust_fit import agree, contradicting
from .rectifying import pooled
from .snapshot import Snapshot

POOLED = 10  # moments


def believed(views: FourViews, moments: Sequence[Snapshot], noise_px: float, look: int) -> FourViews:
    """The views with points unseen where left and right contradict each other. moments: those before; look: by which
    draws are seeded."""
    now = views.matches
    matches, rectification = np.concatenate(now), moments[-1].rectification
    if agree(*sides(matches, rectification), noise_px):
        return views
    matches = np.concatenate([matches, pooled(moment.views for moment in moments[-POOLED:])])
    wrong = contradicting(*sides(matches, rectification), noise_px, np.random.default_rng(look))[: sum(map(len, now))]
    if not wrong.any():
        return views
    visible = views.visible.copy()
    for body, of_body in enumerate(np.split(wrong, [len(now[0])])):
        pair = visible[:, 2 * body : 2 * body + 2]
        pair[np.flatnonzero(pair.all(-1))[of_body]] = False
    return replace(views, visible=visible)


def sides(matches: NDArray, rectification: Rectification | None) -> tuple[NDArray, NDArray]:
    """(M, 4) px → (M, 2) px of the left and the right image, rectified if it is known how."""
    if rectification is not None:
        matches = rectification.apply(matches)
    return matches[:, :2], matches[:, 2:]

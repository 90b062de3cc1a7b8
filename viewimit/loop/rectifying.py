"""The step between views and transfer: rectification from the matches of all postures visited, if they ask for it."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import FourViews
from ..geometry.rectification import Rectification, rectification_of
from .settings import Settings
from .snapshot import Snapshot

POOLED = 40  # moments whose matches are pooled; after as many motions the rectification stays
ASKED = *range(9), 10, 13, 16, 20, 25, 32, POOLED  # motions: as the matches become more by a quarter


def rectification_for(settings: Settings, moments: Sequence[Snapshot], views: FourViews) -> Rectification | None:
    """For a moment that sees `views`, after those before it, the present one last; None if images stay as they are.

    The matches are ASKED now and then; once they want it, it is refined with every posture until POOLED of them are
    known. It is found anew where the settings change.
    """
    if settings.rectify == "off":
        return None
    now = moments[-1]
    settled = now.motion >= POOLED if now.rectification is not None else now.motion not in ASKED
    if settled and now.settings == settings:
        return now.rectification
    matches = pooled([*(moment.views for moment in moments[-POOLED:]), views])
    return rectification_of(matches[:, :2], matches[:, 2:])


def pooled(seen: Iterable[FourViews]) -> NDArray:
    """All different pairs of views of both bodies: matches (M, 4) px of the left and the right camera."""
    pairs: dict[bytes, NDArray] = {}
    for views in seen:
        for matched in views.matches:
            pairs.setdefault(matched.tobytes(), matched)
    return np.concatenate(list(pairs.values()))

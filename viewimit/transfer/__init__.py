"""Transfers: from the demonstrator's points in [l], [r] to where they would be in the learner's own views.

`TRANSFERS[name](views)` fits one to `FourViews` of points that are all seen; leading axes are a batch of postures.
`.recover(l, r)` of what it returns gives (..., N, 4) px, and `.condition` says how far its linear system amplifies
errors. A new one is a file with a `TransferMethod`, and a line here: its title, limits, equations and how it is stored
come with it.
"""

from . import epipolar, linear_combination, projective, rank3
from .transfer import FittedTransfer, TransferMethod

TRANSFERS: dict[str, TransferMethod] = {
    "epipolar": epipolar.METHOD,
    "linear": linear_combination.METHOD,
    "rank3": rank3.METHOD,
    "projective": projective.METHOD,
}

PROJECTIVE_FROM = 8  # points: 32 coordinates for its 19 parameters

__all__ = ["PROJECTIVE_FROM", "TRANSFERS", "FittedTransfer", "TransferMethod", "default_transfer"]


def default_transfer(points: int) -> str:
    """Name of the transfer for so many points: projective from PROJECTIVE_FROM on, epipolar below."""
    return "projective" if points >= PROJECTIVE_FROM else "epipolar"

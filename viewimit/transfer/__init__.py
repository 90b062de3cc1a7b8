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

__all__ = ["TRANSFERS", "FittedTransfer", "TransferMethod"]

"""Transfers: from the demonstrator's points in [l], [r] to where they would be in the learner's own views.

`TRANSFERS[name](views)` fits one to `FourViews` of points that are all seen; leading axes are a batch of postures.
`.recover(l, r)` of what it returns gives (..., N, 4) px, and `.condition` says how far its linear system amplifies
errors. A new one is a function of `FourViews`, given to `Session(settings, transfer=…)`. As a file with a
`TransferMethod`, and a line here, it has a name for all commands and the page: title, limits, equations and how it is
stored come with it.
"""

from collections import UserDict

from . import epipolar, linear_combination, projective, rank3
from .function import Recovers, TransferFunction, transfer_method
from .transfer import FittedTransfer, TransferMethod


class Transfers(UserDict[str, TransferMethod]):
    """By name. A function that is set becomes a `TransferMethod`; TypeError for anything else."""

    def __setitem__(self, name: str, given: TransferMethod | TransferFunction) -> None:
        super().__setitem__(name, transfer_method(given))


TRANSFERS = Transfers(
    {
        "epipolar": epipolar.METHOD,
        "linear": linear_combination.METHOD,
        "rank3": rank3.METHOD,
        "projective": projective.METHOD,
    }
)

PROJECTIVE_FROM = 8  # points: 32 coordinates for its 19 parameters

__all__ = [
    "PROJECTIVE_FROM",
    "TRANSFERS",
    "FittedTransfer",
    "Recovers",
    "TransferFunction",
    "TransferMethod",
    "Transfers",
    "default_transfer",
    "transfer_method",
]


def default_transfer(points: int) -> str:
    """Name of the transfer for so many points: projective from PROJECTIVE_FROM on, epipolar below."""
    return "projective" if points >= PROJECTIVE_FROM else "epipolar"

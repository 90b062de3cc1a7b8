"""Transfers: maps from the demonstrator's points in [l], [r] to where they would be in the learner's own views.

`TRANSFERS[name](views)` fits a transfer to `FourViews` of points that all four views show; leading axes are a batch of
postures. The fitted transfer has `recover(l, r)`, (..., N, 4) px, and `condition`, its condition number. To add one,
write a function of `FourViews` and give it to `Session(settings, transfer=…)`. To give it a name for all commands and
the page, assign it, or a `TransferMethod` with title, limitations and equations: `TRANSFERS["name"] = …`.
"""

from .registry import TRANSFERS, Transfers, default_transfer
from .transfer import FittedTransfer, Recovers, Transfer, TransferFunction, TransferMethod, transfer_method

__all__ = [
    "TRANSFERS",
    "FittedTransfer",
    "Recovers",
    "Transfer",
    "TransferFunction",
    "TransferMethod",
    "Transfers",
    "default_transfer",
    "transfer_method",
]

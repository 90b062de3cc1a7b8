"""Rectification between views and transfer.

A transfer that is exact for parallel optical axes is exact for any pair of pinhole cameras if it maps rectified images.
The rectification is estimated from the matches of all postures visited, if these ask for it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry.rectification import Rectification, fit_rectification
from .transfers.transfer import FittedTransfer, TransferMethod, conflict, is_whitened
from .views import FourViews, unique_matches

MAX_LOOKS = 40  # whose matches are pooled; after as many motions the rectification stays
ESTIMATED_AT = *range(9), 10, 13, 16, 20, 25, 32, MAX_LOOKS  # motions: the matches grow by a quarter each


@dataclass(frozen=True)
class RectifiedTransfer(FittedTransfer):
    """A transfer that was fitted to rectified images and maps images as seen.

    e and E are those of the images as seen [px, px²]. If the transfer has residuals in the demonstrator's images too,
    they are those of the rectified images, whose pixels are as large in the middle of the images.
    """

    between: FittedTransfer  # maps rectified images, between the rectification and its inverse
    rectification: Rectification

    @property
    def condition(self) -> NDArray[np.float64]:
        return self.between.condition

    @property
    def is_whitened(self) -> bool:
        return is_whitened(self.between)

    @property
    def fundamentals(self) -> NDArray[np.float64] | None:
        return self.between.fundamentals

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray[np.float64]:
        demo = self.rectification.apply(np.concatenate([demo_left, demo_right], -1))
        return self.rectification.restore(self.between.recover(demo[..., :2], demo[..., 2:]))

    def residual(self, views: FourViews) -> NDArray[np.float64]:
        if self.is_whitened:
            return self.between.residual(rectify_views(views, self.rectification))
        return views.own - self.recover(views.demo_left, views.demo_right)

    def conflict(self, views: FourViews) -> NDArray[np.float64]:
        if self.is_whitened:
            return self.between.conflict(rectify_views(views, self.rectification))
        return conflict(self.residual(views))


def fit_transfer(method: TransferMethod, views: FourViews, rectification: Rectification | None) -> FittedTransfer:
    """Fit a transfer to images as they are, or rectified.

    Parameters
    ----------
    method : TransferMethod
        An entry of `TRANSFERS`.
    views : FourViews
        Points visible in all views, (..., N, 4) px with N ≥ 5.
    rectification : Rectification or None
        Of all images; None for images as they are.

    Returns
    -------
    FittedTransfer
        Maps images as seen.
    """
    if rectification is None:
        return method(views)
    return RectifiedTransfer(method(rectify_views(views, rectification)), rectification)


def rectify_views(views: FourViews, rectification: Rectification) -> FourViews:
    """Map all points to the rectified images [px]."""
    return FourViews(rectification.apply(views.demo), rectification.apply(views.own), views.visible, views.matched)


def update_rectification(
    views: FourViews, past: Sequence[FourViews], current: Rectification | None, motion: int, refresh: bool = False
) -> Rectification | None:
    """Estimate the rectification that the head needs, if any, from the matches of all looks.

    It is estimated at the motions ESTIMATED_AT. Once the matches ask for one, it is refined at each motion until
    MAX_LOOKS of them were made.

    Parameters
    ----------
    views : FourViews
        The present look.
    past : sequence of FourViews
        Looks before it, the last one last.
    current : Rectification or None
        The last estimate.
    motion : int
        How many motions were made before the last of the past looks.
    refresh : bool
        Estimate it at any motion, as after a change of the cameras.

    Returns
    -------
    Rectification or None
        None if images stay as they are.
    """
    settled = motion >= MAX_LOOKS if current is not None else motion not in ESTIMATED_AT
    if settled and not refresh:
        return current
    matches = unique_matches([*past[-MAX_LOOKS:], views])
    return fit_rectification(matches[:, :2], matches[:, 2:])

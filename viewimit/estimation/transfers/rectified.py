"""A transfer between rectified images: what comes in is rectified, what comes out is given back in px of the images.

So any transfer that is exact for parallel optical axes is exact for every pair of pinhole cameras.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...geometry.rectification import Rectification
from ..residuals import conflict
from ..views import FourViews
from .transfer import FittedTransfer, TransferMethod


@dataclass(frozen=True)
class RectifiedTransfer(FittedTransfer):
    """between: fitted to the rectified images; rectification: by which they are.

    e and E are those of the images as seen, in px and px². Where a transfer answers for the demonstrator's images, too,
    they are those of the rectified ones, whose px are as large in the middle of the images.
    """

    between: FittedTransfer
    rectification: Rectification

    @property
    def condition(self) -> NDArray:
        return self.between.condition

    @property
    def weighs_noise(self) -> bool:
        return self.between.weighs_noise

    @property
    def fundamentals(self) -> NDArray | None:
        return self.between.fundamentals

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray:
        demo = self.rectification.apply(np.concatenate([demo_left, demo_right], -1))
        return self.rectification.restore(self.between.recover(demo[..., :2], demo[..., 2:]))

    def residual(self, views: FourViews) -> NDArray:
        if self.weighs_noise:
            return self.between.residual(rectified(views, self.rectification))
        return views.own - self.recover(views.demo_left, views.demo_right)

    def conflict(self, views: FourViews) -> NDArray:
        if self.weighs_noise:
            return self.between.conflict(rectified(views, self.rectification))
        return conflict(self.residual(views))


def fit(method: TransferMethod, views: FourViews, rectification: Rectification | None) -> FittedTransfer:
    """The method's, between images as they are or, if a rectification is given, as that has them."""
    if rectification is None:
        return method(views)
    return RectifiedTransfer(method(rectified(views, rectification)), rectification)


def rectified(views: FourViews, rectification: Rectification) -> FourViews:
    """px of the rectified images."""
    return FourViews(rectification.apply(views.demo), rectification.apply(views.own), views.visible)

"""What all transfers share: residuals, and the conflict E of Eq. (6)."""

from numpy.typing import ArrayLike, NDArray

from ..evaluation import conflict
from ..views import FourViews


class Transfer:
    """A map of image points from [l], [r] to [L], [R], fitted to `FourViews`."""

    condition: NDArray
    weighs_noise = False  # whether residuals answer for the noise of the demonstrator's images already

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray:
        """demo_left, demo_right: (..., M, 2) px, any points seen in [l], [r] → (..., M, 4) px in [L, R]."""
        raise NotImplementedError

    def residual(self, views: FourViews) -> NDArray:
        """(..., N, C) px whose squares make E: e of Eq. (6), unless a transfer has more images to answer for."""
        return views.own - self.recover(views.demo_left, views.demo_right)

    def conflict(self, views: FourViews) -> NDArray:
        """E: (...) px²."""
        return conflict(self.residual(views))

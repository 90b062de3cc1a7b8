"""What the method computes from the four views of one look: the transfer, recovered points, residuals and E."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ..estimation.rectification import fit_transfer, rectify_views
from ..estimation.transfers import FittedTransfer, TransferMethod
from ..estimation.views import FourViews
from ..geometry.affine import LINE_VIEWS, MIN_POINTS, PairGeometry, fit_pairs, flatness
from ..geometry.rectification import Rectification


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The method applied to four views of N points. Each quantity is computed when first used."""

    views: FourViews
    rectification: Rectification | None  # of the images, for the transfer; None if they stay as they are
    method: TransferMethod
    frozen: FittedTransfer | None = None  # a transfer that was fitted elsewhere, which replaces the fitted one

    def is_of(self, views: FourViews, rectification: Rectification | None, method: TransferMethod) -> bool:
        """Whether these are its views, rectification and method: identical objects."""
        return self.views is views and self.rectification is rectification and self.method is method

    @cached_property
    def fitted(self) -> FittedTransfer | None:
        """The transfer fitted to the usable points; None with fewer than MIN_POINTS."""
        if np.count_nonzero(self.views.usable) < MIN_POINTS:
            return None
        return fit_transfer(self.method, self.views.used, self.rectification)

    @property
    def transfer(self) -> FittedTransfer | None:
        """The transfer that is applied: the frozen one, or else the fitted one."""
        return self.fitted if self.frozen is None else self.frozen

    @cached_property
    def recovered(self) -> NDArray[np.float64]:
        """(N, 4) px: the demonstrator's points, transferred to [L, R]; NaN if not usable."""
        seen, transfer = self.views.used, self.transfer
        if transfer is not None and seen is self.views:
            return transfer.recover(seen.demo_left, seen.demo_right)
        recovered = np.full_like(self.views.own, np.nan)
        if transfer is not None:
            recovered[self.views.usable] = transfer.recover(seen.demo_left, seen.demo_right)
        return recovered

    @cached_property
    def e(self) -> NDArray[np.float64]:
        """(N, 4) px: residuals in [L, R], own minus recovered points; NaN if not usable."""
        return self.views.own - self.recovered

    @cached_property
    def residual(self) -> NDArray[np.float64]:
        """(n, C) px: residuals of the usable points, whose squares make E. Needs a transfer."""
        assert self.transfer is not None
        return self.transfer.residual(self.views.used)

    @property
    def E(self) -> float:
        """The conflict [px²]; NaN without a transfer."""
        return np.nan if self.transfer is None else float(self.transfer.conflict(self.views.used))

    @cached_property
    def flatness(self) -> float:
        """σ1/σ3 of the demonstrator's usable points in [l, r]; inf with too few of them."""
        return np.inf if self.transfer is None else _flatness(self.views.used.demo.tobytes())

    @cached_property
    def fundamental(self) -> PairGeometry | None:
        """Affine epipolar geometry of the six pairs of views, from the usable points; None with too few of them."""
        views = self.views if self.rectification is None else rectify_views(self.views, self.rectification)
        known = None if self.fitted is None else self.fitted.fundamentals
        return fit_pairs(np.concatenate([views.demo, views.own], 1)[self.views.usable], known)

    def epipolar_lines(self, point: int) -> NDArray[np.float64] | None:
        """Compute the epipolar lines of a body point in the original images. point: index of the point. Returns (12,
        3), lines as `PairGeometry.lines`; those in rectified images are mapped back. None with too few points."""
        if self.fundamental is None:
            return None
        if point not in self._lines:
            self._lines[point] = self._lines_of(self.fundamental, point)
        return self._lines[point]

    @cached_property
    def _lines(self) -> dict[int, NDArray[np.float64]]:
        """Cache of `epipolar_lines`, by body point."""
        return {}

    def _lines_of(self, fundamental: PairGeometry, point: int) -> NDArray[np.float64]:
        images, by = np.stack([self.views.demo[point], self.views.own[point]]), self.rectification
        if by is None:
            return fundamental.lines(images.reshape(4, 2))
        lines = fundamental.lines(by.apply(images).reshape(4, 2))
        return np.einsum("ki,kij->kj", lines, np.stack([by.left, by.right])[LINE_VIEWS % 2])


@lru_cache(64)  # the images of a demonstrator that stands still are the same at every motion
def _flatness(demo: bytes) -> float:
    return flatness(np.frombuffer(demo).reshape(-1, 4))

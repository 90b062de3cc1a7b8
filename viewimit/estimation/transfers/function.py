"""A transfer as a plain function: FourViews of one posture → anything that can `recover`. The rest has defaults."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...geometry.affine import flatness
from ..views import FourViews
from .transfer import FittedTransfer, Transfer, TransferMethod, name_of


class Recovers(Protocol):
    """What such a function returns. Other members of `FittedTransfer`, if it has them, replace the defaults."""

    def recover(self, demo_left: NDArray, demo_right: NDArray) -> ArrayLike:
        """demo_left, demo_right: (M, 2) px, any points seen in [l], [r] → (M, 4) px in [L, R]."""
        ...


TransferFunction = Callable[[FourViews], Recovers]


def transfer_method(given: TransferMethod | TransferFunction) -> TransferMethod:
    """A `TransferMethod` as it is; of a function, one with its name as title. Raises TypeError for anything else."""
    if isinstance(given, TransferMethod):
        return given
    if not callable(given):
        raise TypeError(f"a transfer is a function of FourViews or a TransferMethod, got {given!r}")
    title = name_of(given)
    return TransferMethod(title=title, fit=lambda views: _fit(given, title, views))


def _fit(function: TransferFunction, title: str, views: FourViews) -> FittedTransfer:
    """Fit each posture of a batch by itself, as the function was written for one."""
    batch = np.broadcast_shapes(views.demo.shape[:-2], views.own.shape[:-2])
    postures = _postures(views, batch)
    fitted = [_completed(function(posture), title, posture) for posture in postures]
    return _EachTransfer(tuple(fitted), batch) if batch else fitted[0]


def _postures(views: FourViews, batch: tuple[int, ...]) -> list[FourViews]:
    """The views of each posture of a batch."""
    demo, own = (
        np.broadcast_to(images, batch + images.shape[-2:]).reshape((-1,) + images.shape[-2:])
        for images in (views.demo, views.own)
    )
    seen = np.ones(own.shape[-2:], bool)
    return [FourViews(*images, seen) for images in zip(demo, own)]


def _completed(fitted: Any, title: str, views: FourViews) -> FittedTransfer:
    """Raises TypeError for what cannot `recover`."""
    if isinstance(fitted, Transfer):
        return fitted
    if not callable(getattr(fitted, "recover", None)):
        raise TypeError(f"transfer {title!r} must return an object with recover(demo_left, demo_right), got {fitted!r}")
    return _CompletedTransfer(fitted, title, views.demo)


@dataclass(frozen=True, eq=False)
class _CompletedTransfer(Transfer):
    """fitted: what the function returned for one posture; demo: (N, 4) px, what it was fitted to."""

    fitted: Any
    title: str
    demo: NDArray

    @property
    def condition(self) -> NDArray:
        """σ1/σ3 of the demonstrator's points by default."""
        own = getattr(self.fitted, "condition", None)
        return np.asarray(flatness(self.demo) if own is None else own, float)

    @property
    def weighs_noise(self) -> bool:  # type: ignore[override]
        return bool(getattr(self.fitted, "weighs_noise", False))

    @property
    def fundamentals(self) -> NDArray | None:
        return getattr(self.fitted, "fundamentals", None)

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray:
        left, right = np.asarray(demo_left, float), np.asarray(demo_right, float)
        if left.ndim > 2:
            return np.array([self.recover(*each) for each in zip(left, right)])
        found = np.asarray(self.fitted.recover(left, right), float)
        if found.shape != (len(left), 4):
            wanted = f"({len(left)}, 4) px in [L, R]"
            raise ValueError(f"transfer {self.title!r}: recover must return {wanted}, got shape {found.shape}")
        return found

    def residual(self, views: FourViews) -> NDArray:
        own = getattr(self.fitted, "residual", None)
        return super().residual(views) if own is None else np.asarray(own(views), float)

    def conflict(self, views: FourViews) -> NDArray:
        own = getattr(self.fitted, "conflict", None)
        return super().conflict(views) if own is None else np.asarray(own(views), float)


@dataclass(frozen=True, eq=False)
class _EachTransfer(Transfer):
    """fitted: one for each posture of a batch."""

    fitted: tuple[FittedTransfer, ...]
    batch: tuple[int, ...]

    @property
    def condition(self) -> NDArray:
        return np.array([one.condition for one in self.fitted]).reshape(self.batch)

    @property
    def weighs_noise(self) -> bool:  # type: ignore[override]
        return self.fitted[0].weighs_noise if self.fitted else False

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray:
        left, right = (
            np.broadcast_to(points, self.batch + np.shape(points)[-2:]).reshape((-1,) + np.shape(points)[-2:])
            for points in (demo_left, demo_right)
        )
        return self._joined([one.recover(*points) for one, *points in zip(self.fitted, left, right)])

    def residual(self, views: FourViews) -> NDArray:
        each = zip(self.fitted, _postures(views, self.batch))
        return self._joined([one.residual(posture) for one, posture in each])

    def conflict(self, views: FourViews) -> NDArray:
        each = zip(self.fitted, _postures(views, self.batch))
        return self._joined([one.conflict(posture) for one, posture in each])

    def _joined(self, found: list[NDArray]) -> NDArray:
        together = np.array(found)
        return together.reshape(self.batch + together.shape[1:])

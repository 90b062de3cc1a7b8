"""What a transfer is, and what all those in this folder share: residuals, and the conflict E of Eq. (6)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...geometry.rectification import Rectification
from ..equations import Equation
from ..residuals import conflict
from ..views import FourViews

FLATNESS = "σ₁/σ₃"  # of the centred [l r]
FLAT = "the points nearly lie in a plane, E may mislead"


class FittedTransfer(Protocol):
    """A map of image points from [l], [r] to [L], [R], fitted to `FourViews`. Leading axes are a batch of postures."""

    @property
    def condition(self) -> NDArray:
        """How far the transfer's linear system amplifies errors: (...), ≥ 1, inf where it is singular."""
        ...

    @property
    def weighs_noise(self) -> bool:
        """Whether residuals answer for the noise of the demonstrator's images already."""
        ...

    @property
    def fundamentals(self) -> NDArray | None:
        """(5, 4): f of all pairs of views but [l], [r], if it was fitted by them, of one posture; None else."""
        return None

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray:
        """demo_left, demo_right: (..., M, 2) px, any points seen in [l], [r] → (..., M, 4) px in [L, R]."""
        ...

    def residual(self, views: FourViews) -> NDArray:
        """(..., N, C) px whose squares make E: e of Eq. (6), C = 4, unless it has more images to answer for."""
        ...

    def conflict(self, views: FourViews) -> NDArray:
        """E: (...) px²."""
        ...


class Residuals(Protocol):
    """e: (..., N, C) px of views whose squares make an E."""

    def residual(self, views: FourViews) -> NDArray: ...


@dataclass(frozen=True, kw_only=True)
class TransferMethod:
    """One way to recover points, with all that anybody says about it. Called with `FourViews` it is `fit`.

    fit: views of points that are all seen, (..., N, 4) px with N ≥ 5 → a `FittedTransfer`; all else has a default.
    title: in dropdowns, by default the name of fit; assumes, fails: a sentence each. stored: the dataclasses that a
    fitted one is made of, nested ones too; they are stored by their fields, which are arrays, scalars, strings, tuples
    or such dataclasses.
    equations(fitted, demo, own, name): how one point, (4,) px in [l, r] and (4,) px in [L, R], is recovered; no batch.
    crosses_lines: whether a point is recovered where its epipolar lines cross.
    condition_name: what `condition` is; ill: what it means where it is too large.
    conflict_equation(E px²): in place of Eq. (6) where E is another function of the images.
    near(views, rectification, own_share): what weighs noise better than the transfer's own residuals, of rectified
    images near own ones that are like those of the views, of one posture; it gives residuals of any own images.
    half_seen(views, rectification): the same that weighs all points alike, for views in which the demonstrator shows
    one image alone of some points.
    """

    fit: Callable[[FourViews], FittedTransfer]
    title: str = ""
    assumes: str = ""
    fails: str = ""
    stored: tuple[type, ...] = ()
    equations: Callable[[Any, NDArray, NDArray, str], tuple[Equation, ...]] = lambda fitted, demo, own, name: ()
    crosses_lines: bool = False
    condition_name: str = FLATNESS
    ill: str = FLAT
    conflict_equation: Callable[[float], Equation] | None = None
    near: Callable[[FourViews, Rectification, float], Residuals] | None = None
    half_seen: Callable[[FourViews, Rectification], Residuals] | None = None

    def __post_init__(self) -> None:
        if not self.title:
            object.__setattr__(self, "title", name_of(self.fit))

    def __call__(self, views: FourViews) -> FittedTransfer:
        """`fit`. Raises ValueError for coordinates that are not finite."""
        if not (np.isfinite(views.demo).all() and np.isfinite(views.own).all()):
            raise ValueError("a transfer needs points that are seen in all four views: take FourViews.used")
        return self.fit(views)


def name_of(function: Callable) -> str:
    """What it is called in code."""
    return getattr(function, "__name__", type(function).__name__)


class Transfer(FittedTransfer):
    """E by Eq. (6) from the points that `recover` finds."""

    weighs_noise: ClassVar[bool] = False

    def residual(self, views: FourViews) -> NDArray:
        return views.own - self.recover(views.demo_left, views.demo_right)

    def conflict(self, views: FourViews) -> NDArray:
        return conflict(self.residual(views))

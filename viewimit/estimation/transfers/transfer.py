"""The interface of a transfer, its defaults, and the adaptor for a plain function of views.

A transfer maps the demonstrator's points from its images [l], [r] to where they would be in the learner's own images
[L], [R]. Subclass `Transfer` and define `recover` and `condition`; residuals and E follow from Eq. (6).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...geometry.affine import flatness
from ..equations import Equation
from ..views import VIEWS, FourViews

FLATNESS = "σ₁/σ₃"  # of the centred [l r]
FLAT = "The points nearly lie in a plane, so E may mislead."


def conflict(e: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute E = 1/(2N) Σ (|e_L|² + |e_R|²), Eq. (6).

    Parameters
    ----------
    e : (..., N, C) array
        Residuals of N points with C coordinates each [px].

    Returns
    -------
    (...) array
        E [px²].
    """
    return np.einsum("...ij,...ij->...", e, e) / (2 * e.shape[-2])


class FittedTransfer(Protocol):
    """A map of image points from [l], [r] to [L], [R], fitted to `FourViews`. Leading axes are a batch of postures."""

    @property
    def condition(self) -> NDArray[np.float64]:
        """Condition number of the transfer's linear system: (...), ≥ 1, inf where it is singular."""
        ...

    @property
    def is_whitened(self) -> bool:
        """Whether residuals are whitened already: whether they account for noise in the demonstrator's images."""
        ...

    @property
    def fundamentals(self) -> NDArray[np.float64] | None:
        """(5, 4): f of all pairs of views but [l], [r], if one posture was fitted by them; otherwise None."""
        return None

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray[np.float64]:
        """Map points from the demonstrator's images to the own ones.

        Parameters
        ----------
        demo_left, demo_right : (..., M, 2) arrays
            Any points seen in [l], [r] [px], not only those that were fitted.

        Returns
        -------
        (..., M, 4) array
            Points in [L, R] [px].
        """
        ...

    def residual(self, views: FourViews) -> NDArray[np.float64]:
        """Compute e of Eq. (6).

        Parameters
        ----------
        views : FourViews
            The N points that were fitted, or the same points with other own images.

        Returns
        -------
        (..., N, C) array
            Residuals [px]: C = 4, or 8 if the demonstrator's images have residuals as well.
        """
        ...

    def conflict(self, views: FourViews) -> NDArray[np.float64]:
        """Compute E of Eq. (6).

        Parameters
        ----------
        views : FourViews
            As for `residual`.

        Returns
        -------
        (...) array
            E [px²].
        """
        ...


class Transfer(FittedTransfer):
    """Base class: residuals and E follow from `recover` by Eq. (6)."""

    is_whitened: ClassVar[bool] = False

    def residual(self, views: FourViews) -> NDArray[np.float64]:
        return views.own - self.recover(views.demo_left, views.demo_right)

    def conflict(self, views: FourViews) -> NDArray[np.float64]:
        return conflict(self.residual(views))


def is_whitened(fitted: Any) -> bool:
    """Return `is_whitened` of a fitted transfer; by default False."""
    return bool(getattr(fitted, "is_whitened", False))


class Recovers(Protocol):
    """What a transfer function returns. It may also define any other member of `FittedTransfer`."""

    def recover(self, demo_left: NDArray[np.float64], demo_right: NDArray[np.float64]) -> ArrayLike:
        """Map points from the demonstrator's images to the own ones.

        Parameters
        ----------
        demo_left, demo_right : (M, 2) arrays
            Any points seen in [l], [r] [px].

        Returns
        -------
        (M, 4) array
            Points in [L, R] [px].
        """
        ...


TransferFunction = Callable[[FourViews], Recovers]


def fit_function(function: TransferFunction, title: str, views: FourViews) -> FittedTransfer:
    """Fit a function of one posture to each posture of a batch.

    Parameters
    ----------
    function : callable
        Takes the `FourViews` of one posture, returns an object with `recover`.
    title : str
        Name of the function in messages.
    views : FourViews
        Points that are visible in all views, (..., N, 4) px.

    Returns
    -------
    FittedTransfer

    Raises
    ------
    TypeError
        If the function returns an object without `recover`, or is a class whose objects cannot recover points.
    """
    batch = np.broadcast_shapes(views.demo.shape[:-2], views.own.shape[:-2])
    fitted = tuple(_with_defaults(function(posture), title, posture) for posture in _postures(views, batch))
    if isinstance(function, type) and fitted:
        _require_fitting(fitted[0], title, views)
    return _BatchTransfer(fitted, batch) if batch else fitted[0]


def _postures(views: FourViews, batch: tuple[int, ...]) -> list[FourViews]:
    """Split a batch into the views of single postures."""
    demo, own = (
        np.broadcast_to(images, batch + images.shape[-2:]).reshape((-1,) + images.shape[-2:])
        for images in (views.demo, views.own)
    )
    visible = np.ones((own.shape[-2], len(VIEWS)), bool)
    return [FourViews(*images, visible) for images in zip(demo, own)]


def _with_defaults(fitted: Any, title: str, views: FourViews) -> FittedTransfer:
    """Add the members of `FittedTransfer` that the object of a transfer function lacks."""
    if isinstance(fitted, Transfer):
        return fitted
    if not callable(getattr(fitted, "recover", None)):
        raise TypeError(f"transfer {title!r} must return an object with recover(demo_left, demo_right), got {fitted!r}")
    return _FunctionTransfer(fitted, title, views.demo)


def _require_fitting(fitted: FittedTransfer, title: str, views: FourViews) -> None:
    """Raise TypeError for an object of a class that does not fit the views it is made of."""
    demo = views.demo.reshape(-1, *views.demo.shape[-2:])[0]
    try:
        fitted.recover(demo[:, :2], demo[:, 2:])
    except (AttributeError, IndexError, TypeError, ValueError) as error:
        advice = f"give a function of FourViews that returns a fitted {title}"
        raise TypeError(f"transfer {title!r} is a class, and {title}(views) cannot recover points: {advice}") from error


@dataclass(frozen=True, eq=False)
class _FunctionTransfer(Transfer):
    """One posture's transfer; members that the object does not define have their defaults."""

    fitted: Any  # what the function returned: `recover`, and optionally other members of FittedTransfer
    title: str
    demo: NDArray[np.float64]  # (N, 4) px, what it was fitted to

    @property
    def condition(self) -> NDArray[np.float64]:
        """σ1/σ3 of the demonstrator's points by default."""
        given = getattr(self.fitted, "condition", None)
        return np.asarray(flatness(self.demo) if given is None else given, float)

    @property
    def is_whitened(self) -> bool:  # type: ignore[override]
        return is_whitened(self.fitted)

    @property
    def fundamentals(self) -> NDArray[np.float64] | None:
        return getattr(self.fitted, "fundamentals", None)

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray[np.float64]:
        left, right = np.asarray(demo_left, float), np.asarray(demo_right, float)
        if left.ndim > 2:
            return np.array([self.recover(*each) for each in zip(left, right)])
        found = np.asarray(self.fitted.recover(left, right), float)
        if found.shape != (len(left), 4):
            expected = f"({len(left)}, 4) px in [L, R]"
            raise ValueError(f"transfer {self.title!r}: recover must return {expected}, got shape {found.shape}")
        return found

    def residual(self, views: FourViews) -> NDArray[np.float64]:
        given = getattr(self.fitted, "residual", None)
        return super().residual(views) if given is None else np.asarray(given(views), float)

    def conflict(self, views: FourViews) -> NDArray[np.float64]:
        given = getattr(self.fitted, "conflict", None)
        return super().conflict(views) if given is None else np.asarray(given(views), float)


@dataclass(frozen=True, eq=False)
class _BatchTransfer(Transfer):
    """Transfers of single postures, as one transfer of the batch."""

    fitted: tuple[FittedTransfer, ...]
    batch: tuple[int, ...]

    @property
    def condition(self) -> NDArray[np.float64]:
        return np.array([one.condition for one in self.fitted]).reshape(self.batch)

    @property
    def is_whitened(self) -> bool:  # type: ignore[override]
        return bool(self.fitted) and is_whitened(self.fitted[0])

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray[np.float64]:
        left, right = (
            np.broadcast_to(points, self.batch + np.shape(points)[-2:]).reshape((-1,) + np.shape(points)[-2:])
            for points in (demo_left, demo_right)
        )
        return self._joined([one.recover(*points) for one, *points in zip(self.fitted, left, right)])

    def residual(self, views: FourViews) -> NDArray[np.float64]:
        return self._joined([one.residual(v) for one, v in zip(self.fitted, _postures(views, self.batch))])

    def conflict(self, views: FourViews) -> NDArray[np.float64]:
        return self._joined([one.conflict(v) for one, v in zip(self.fitted, _postures(views, self.batch))])

    def _joined(self, found: list[NDArray[np.float64]]) -> NDArray[np.float64]:
        together = np.array(found)
        return together.reshape(self.batch + together.shape[1:])


Equations = Callable[[Any, NDArray[np.float64], NDArray[np.float64], str], tuple[Equation, ...]]


@dataclass(kw_only=True)
class TransferMethod:
    """A transfer with its description. Calling it with `FourViews` calls `fit`."""

    fit: Callable[[FourViews], FittedTransfer]  #: views of points visible in all four, (..., N, 4) px, N ≥ 5
    title: str = ""  #: in dropdowns; by default the name of `fit`
    assumes: str = ""  #: one sentence: when it is exact
    limitations: str = ""  #: one sentence: where it fails
    equations: Equations = (
        lambda fitted, demo, own, name: ()
    )  #: how one point, (4,) px in [l r] and [L R], is recovered
    crosses_lines: bool = False  #: whether a point is recovered at the intersection of its epipolar lines
    condition_name: str = FLATNESS  #: what `condition` is
    degenerate_message: str = FLAT  #: shown if `condition` is too large
    conflict_equation: Callable[[float], Equation] | None = None  #: E px² → what replaces Eq. (6), if anything

    def __post_init__(self) -> None:
        self.title = self.title or name_of(self.fit)

    def __call__(self, views: FourViews) -> FittedTransfer:
        """Fit the transfer. Raises ValueError for coordinates that are not finite."""
        if not (np.isfinite(views.demo).all() and np.isfinite(views.own).all()):
            raise ValueError("a transfer needs points that are seen in all four views: take FourViews.used")
        return self.fit(views)


def name_of(function: Callable) -> str:
    """Return the name of a function, or of a callable's class."""
    return getattr(function, "__name__", type(function).__name__)


def transfer_method(given: TransferMethod | TransferFunction) -> TransferMethod:
    """Return a `TransferMethod` unchanged, or make one of a plain function of one posture's views. Raises TypeError for
    anything else."""
    if isinstance(given, TransferMethod):
        return given
    if not callable(given):
        raise TypeError(f"a transfer is a function of FourViews or a TransferMethod, got {given!r}")
    title = name_of(given)

    @wraps(given)
    def fit(views: FourViews) -> FittedTransfer:
        return fit_function(given, title, views)

    return TransferMethod(title=title, fit=fit)

"""Residuals e of the own image points, and their conflict E (Eq. (6), Section 3)."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

EARLIER_ARGUMENTS = {"by": "transfer", "weighting": "noise_reference", "head": "rig"}  # of a `ResidualFunction`
Call = TypeVar("Call", bound=Callable[..., Any])


def conflict(e: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute E = 1/(2N) Σ (|e_L|² + |e_R|²), Eq. (6).

    Parameters
    ----------
    e : (..., N, C) array
        Residuals of N points [px].

    Returns
    -------
    (...) array
        E [px²].
    """
    return np.einsum("...ij,...ij->...", e, e) / (2 * e.shape[-2])


@dataclass(frozen=True)
class NoiseReference:
    """Own images about which the noise of residuals is propagated, so that residuals can be whitened.

    Whitened residuals at the true posture have the variance of the noise, in every scene.
    """

    own: NDArray[np.float64] | None = None  # (N, 4) px; None: not known yet, so points weigh alike
    own_variance_ratio: float = 0.0  # κ: variance of the compared own images over that of the demonstrator's


class ResidualFunction(Protocol):
    """Residuals of own images that a servo predicts, against the demonstrator as now seen. It moves nothing."""

    def __call__(
        self,
        own: NDArray[np.float64],
        transfer: str | None = None,
        noise_reference: NoiseReference | None = None,
        rig: int = 0,
    ) -> NDArray[np.float64]:
        """Compute the residuals of own images.

        Parameters
        ----------
        own : (..., N, 4) array
            Predicted points in [L, R] [px]; NaN for points that the servo cannot predict.
        transfer : str, optional
            Name of a transfer to use instead of the chosen one.
        noise_reference : NoiseReference, optional
            Whiten the residuals by the noise about these images; by default they are not weighted.
        rig : int, optional
            Hypothesis about the stereo head: 0 for its estimate, 1 to `Observation.heads` for the others.

        Returns
        -------
        (..., n, C) array
            Residuals of the n points that are known in all images [px]; infinite if these are too few.
        """
        ...

    def with_partially_visible(self) -> "ResidualFunction":
        """Include the demonstrator's points that only one camera sees, after all others."""
        ...


def warn_renamed(old: str, new: str, stacklevel: int = 3) -> None:
    """Warn that a name of the last version is read for the last time."""
    warnings.warn(f"{old} is now called {new}; the old name will be gone", FutureWarning, stacklevel)


def with_earlier_arguments(call: Call) -> Call:
    """Let a residual function also be called with EARLIER_ARGUMENTS."""

    @wraps(call)
    def renamed(*args: Any, **given: Any) -> Any:
        for old, new in EARLIER_ARGUMENTS.items():
            if old in given:
                warn_renamed(old, new)
                given[new] = given.pop(old)
        return call(*args, **given)

    return renamed  # type: ignore[return-value]

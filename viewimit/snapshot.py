"""What one pass of the loop leaves behind: plain data, read by everything else."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geometry.affine import MIN_POINTS, flatness
from .settings import Settings
from .transfer import TRANSFERS
from .views import FourViews

DERIVED = ("usable", "transfer", "flatness", "recovered", "e")  # what follows from views and settings alone


@dataclass(frozen=True)
class Snapshot:
    """One pass of the loop. Arrays are of all N points; those not usable are NaN in recovered and residual.

    theta, theta_demo: (m,) rad, the truth, for viewers only; views: what the learner saw;
    usable: (N,) bool, seen in all four views; transfer: None with too few of them, E then NaN;
    flatness: σ1/σ3 of the demonstrator's usable points in [l, r]; recovered, e: (N, 4) px in [L, R];
    commanded: (m,) rad, where the learner has sent its arm, which is theta if that obeys exactly;
    moved: (m,) rad, the motion that led here; probe: it was a probe;
    status: ready, moving, converged, stalled, stopped; lag: looks that pictures come late, None until a motion has
    shown it; frozen: the transfer as it was fitted at the last convergence, None before.

    A long history keeps of its older moments what does not follow from the rest: `fade` lets go of DERIVED, which are
    found again when they are asked for.
    """

    settings: Settings
    motion: int
    look: int
    theta: NDArray
    theta_demo: NDArray
    views: FourViews
    usable: NDArray
    transfer: Any
    flatness: float
    recovered: NDArray
    e: NDArray
    E: float
    commanded: NDArray
    moved: NDArray
    probe: bool
    status: str
    servo_state: Any
    lag: int | None
    frozen: Any

    @property
    def expected_error(self) -> float | None:
        """rad, a standard deviation: what the noise of the images leaves to the worst joint, as the servo reckons;
        None if it gives none."""
        return getattr(self.servo_state, "expected", None)

    def fade(self) -> None:
        for name in DERIVED:
            vars(self).pop(name, None)

    def __getattr__(self, name: str):
        """Only asked for what the moment does not have: DERIVED, after `fade`."""
        if name not in DERIVED:
            raise AttributeError(f"'Snapshot' object has no attribute '{name}'")
        vars(self).update(derived(self.views, self.settings.transfer))
        return vars(self)[name]


def derived(views: FourViews, transfer: str) -> dict[str, Any]:
    """What `Snapshot` says of DERIVED. transfer: by name."""
    usable = views.usable
    recovered = np.full_like(views.own, np.nan)
    fitted, shape = None, np.inf
    if usable.sum() >= MIN_POINTS:
        seen = views.used
        fitted = TRANSFERS[transfer](seen)
        recovered[usable] = fitted.recover(seen.demo_left, seen.demo_right)
        shape = _flatness(seen.demo.tobytes())
    return dict(zip(DERIVED, (usable, fitted, shape, recovered, views.own - recovered)))


@lru_cache(64)  # the demonstrator mostly stands still while the learner moves
def _flatness(demo: bytes) -> float:
    return flatness(np.frombuffer(demo).reshape(-1, 4))

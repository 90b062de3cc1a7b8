"""What a run depends on, and what one pass of its loop leaves behind: plain data, read by everything else."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from .geometry.affine import MIN_POINTS, flatness
from .geometry.pairs import PairGeometry, fit_pairs
from .perception.latency import MOST_LAG
from .servo import SERVOS
from .transfer import TRANSFERS
from .views import FourViews

CAMERAS = ("points", "rendered")  # projected points, or detected in rendered pictures of arms that have weight
MOST_SEED = 2**32 - 1
MOST_FRAMES = 1_000
DERIVED = ("usable", "transfer", "flatness", "recovered", "e")  # what follows from views and settings alone


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All that a run depends on: with equal settings it repeats itself to the last bit.

    demonstrator_deg, start_deg: of the scene's moving joints; None takes the scene's own.
    gain_error, quantum_deg: of the arm; delay: looks after a motion that still show the posture before it. The learner
    is told of none of them.
    frames: how many images are averaged at each posture, of both bodies.
    robot: a name or the path of a URDF, in place of the scene's; joints: which move, in place of the scene's.
    camera: of CAMERAS; points: layout of the scene, in place of which rendered pictures show the robot's markers.
    """

    scene: str = "panda"
    robot: str | None = None
    joints: tuple[int, ...] | None = None
    points: int = 10
    demonstrator_deg: tuple[float, ...] | None = None
    start_deg: tuple[float, ...] | None = None
    transfer: str = "epipolar"
    servo: str = "broyden"
    noise_px: float = 0.0
    missing: float = 0.0
    outliers: float = 0.0
    frames: int = 1
    gain_error: float = 0.0
    quantum_deg: float = 0.0
    delay: int = 0
    seed: int = 7
    camera: str = "points"

    def __post_init__(self):
        _require_choice("transfer", self.transfer, TRANSFERS)
        _require_choice("servo", self.servo, SERVOS)
        _require_choice("camera", self.camera, CAMERAS)
        _require_range("noise_px", self.noise_px, 0, 20)
        _require_range("missing", self.missing, 0, 1)
        _require_range("outliers", self.outliers, 0, 1)
        _require_range("gain_error", self.gain_error, -0.5, 0.5)
        _require_range("quantum_deg", self.quantum_deg, 0, 5)
        _require_range("delay", self.delay, 0, MOST_LAG)
        _require_range("frames", self.frames, 1, MOST_FRAMES)
        _require_range("seed", self.seed, 0, MOST_SEED)


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
        for name in (*DERIVED, "fundamental"):
            vars(self).pop(name, None)

    def __getattr__(self, name: str):
        """Only asked for what the moment does not have: DERIVED, after `fade`."""
        if name not in DERIVED:
            raise AttributeError(f"'Snapshot' object has no attribute '{name}'")
        vars(self).update(derived(self.views, self.settings.transfer))
        return vars(self)[name]

    @cached_property
    def fundamental(self) -> PairGeometry | None:
        """Of the six pairs of views, from the usable points, whatever the transfer is; None with too few of them."""
        images = np.concatenate([self.views.demo, self.views.own], 1)[self.usable]
        return fit_pairs(images.reshape(-1, 4, 2).transpose(1, 0, 2))


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


def _require_choice(name: str, value: str, choices) -> None:
    if value not in choices:
        raise ValueError(f"no {name} {value!r}; there are {', '.join(choices)}")


def _require_range(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name} must be between {low:g} and {high:.10g}, got {value:.10g}")


# What the page and `imitate` begin with; 25 images at each posture are a second of video
BEST = Settings(transfer="projective", servo="trust-region", frames=25)

"""The records of the loop: `Snapshot`, of one pass, and `RunResult`, of a whole run."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..estimation.prediction import AT_REST, PredictedResiduals
from ..estimation.rectification import fit_transfer, rectify_views
from ..estimation.transfers import TRANSFERS, FittedTransfer, TransferMethod
from ..estimation.views import FourViews, Pairs
from ..geometry.affine import LINE_VIEWS, MIN_POINTS, PairGeometry, fit_pairs, flatness
from ..geometry.rectification import Rectification
from ..servo import SERVOS, Certificate, ServoMethod, ServoStatus
from .self_calibration import SelfCalibration
from .settings import OWN, Settings

SERVO_STATUSES = (ServoStatus.MOVING, *(status for status in ServoStatus if status.is_at_rest))


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The session after a motion: an immutable record of one pass of the loop.

    The fields are recorded. All other quantities follow from `views` and `settings`, and are computed when first used.
    """

    settings: Settings
    motion: int  # number of motions so far
    look: int  # number of looks at the own body so far
    theta: NDArray[np.float64]  # (m,) rad, the learner's true posture, for viewers only
    theta_demo: NDArray[np.float64]  # (m,) rad, the demonstrator's true posture, for viewers only; NaN where unknown
    views: FourViews  # the image points of both bodies, all N
    rectification: Rectification | None  # of the images, for the transfer; None if they stay as they are
    E: float  # px²; NaN with too few points to fit a transfer
    commanded: NDArray[np.float64]  # (m,) rad, where the arm was sent: theta, if it obeys exactly
    moved: NDArray[np.float64]  # (m,) rad, the motion that led here
    probe: bool  # that motion was made to learn from it
    status: ServoStatus
    servo_state: Any  # None before the servo was first asked
    lag: int | None  # latency of the images in looks; None until a motion has shown it
    converged_transfer: FittedTransfer | None  # as fitted at the last convergence
    calibration: SelfCalibration | None = None  # what was seen of the own body before imitating
    pending_postures: NDArray[np.float64] | None = None  # (k, m) rad, that the calibration has still to visit
    target: NDArray[np.float64] | None = None  # (m,) rad, where an arm is going that is still on its way
    custom_transfer: TransferMethod | None = None  # given to the session itself; settings call it OWN
    custom_servo: ServoMethod | None = None  # given to the session itself; settings call it OWN
    n_rejected: int = 0  # points that all images show and that contradict the epipolar geometry of one rigid head

    @property
    def method(self) -> TransferMethod:
        """The transfer that the settings name. Raises ValueError for one that no session was given."""
        if self.settings.transfer != OWN:
            return TRANSFERS[self.settings.transfer]
        return require_given("transfer", self.custom_transfer)

    @property
    def servo(self) -> ServoMethod:
        """The servo that the settings name. Raises ValueError for one that no session was given."""
        return SERVOS[self.settings.servo] if self.settings.servo != OWN else require_given("servo", self.custom_servo)

    @cached_property
    def usable(self) -> NDArray[np.bool_]:
        """(N,) bool: visible in all four views."""
        return self.views.usable

    @property
    def shown(self) -> int:
        """Number of the demonstrator's points that are visible in both images."""
        return int(np.count_nonzero(self.views.visible[:, :2].all(-1)))

    @property
    def half_shown(self) -> int:
        """Number of points visible in one image only, 0 for a transfer that cannot use their epipolar lines."""
        asked = self.method.homography_of_space and self.settings.rectify != "off"
        return int(np.count_nonzero(self.views.partially_visible)) if asked else 0

    @property
    def shows_demonstrator(self) -> bool:
        """Whether enough of the demonstrator's points are visible for a transfer."""
        return self.shown >= MIN_POINTS

    @cached_property
    def transfer(self) -> FittedTransfer | None:
        """The transfer fitted to the usable points; None with fewer than MIN_POINTS."""
        if np.count_nonzero(self.usable) < MIN_POINTS:
            return None
        return self.fit(self.views.used)

    def fit(self, views: FourViews, by: str | None = None) -> FittedTransfer:
        """Fit the chosen transfer, or another one by its name, to views, rectified as here."""
        return fit_transfer(TRANSFERS[by] if by else self.method, views, self.rectification)

    @cached_property
    def flatness(self) -> float:
        """σ1/σ3 of the demonstrator's usable points in [l, r]; inf with too few of them."""
        return np.inf if self.transfer is None else _flatness(self.views.used.demo.tobytes())

    @cached_property
    def residual(self) -> NDArray[np.float64]:
        """(n, C) px: residuals of the usable points, whose squares make E. Needs a transfer."""
        assert self.transfer is not None
        return self.transfer.residual(self.views.used)

    @cached_property
    def recovered(self) -> NDArray[np.float64]:
        """(N, 4) px: the demonstrator's points, transferred to [L, R]; NaN if not usable."""
        seen, transfer = self.views.used, self.transfer
        if transfer is not None and seen is self.views:
            return transfer.recover(seen.demo_left, seen.demo_right)
        recovered = np.full_like(self.views.own, np.nan)
        if transfer is not None:
            recovered[self.usable] = transfer.recover(seen.demo_left, seen.demo_right)
        return recovered

    @cached_property
    def e(self) -> NDArray[np.float64]:
        """(N, 4) px: residuals in [L, R], own minus recovered points; NaN if not usable."""
        return self.views.own - self.recovered

    @property
    def is_rehearsing(self) -> bool:
        """Whether the learner has still to visit postures of its calibration."""
        return self.pending_postures is not None and len(self.pending_postures) > 0

    @property
    def calibration_holds(self) -> bool | None:
        """Whether the servo still uses the calibration; None without one, or before the servo was asked."""
        if self.calibration is None or self.servo_state is None:
            return None
        return bool(getattr(self.servo_state, "calibration", ()))

    @property
    def certificate(self) -> Certificate | None:
        """The servo's convergence test; None if it makes none."""
        return getattr(self.servo_state, "certificate", None)

    @property
    def exchanged(self) -> Pairs:
        """Pairs of the demonstrator's points that the servo considers swapped; `views` are corrected."""
        return exchanged(self.servo_state)

    @property
    def expected_error(self) -> float | None:
        """rad, of the worst joint, as the servo estimates it (`Certificate.simultaneous_std_error`), or None."""
        return None if self.certificate is None else self.certificate.simultaneous_std_error

    def with_fields(self, **changes: Any) -> "Snapshot":
        """A snapshot with other values of some fields. Computed quantities are kept if views and transfer stay.

        Raises TypeError for another name.
        """
        if not changes.keys() <= FIELDS:
            raise TypeError(f"a snapshot has no fields {', '.join(sorted(changes.keys() - FIELDS))}")
        same_images = "views" not in changes and "rectification" not in changes
        stays = same_images and changes.get("settings", self.settings).transfer == self.settings.transfer
        kept = vars(self) if stays else {name: value for name, value in vars(self).items() if name in FIELDS}
        other = object.__new__(Snapshot)  # takes a third of the time of `replace`, twice a motion
        vars(other).update(kept, **changes)
        return other

    def recovered_by(self, transfer: FittedTransfer) -> "Snapshot":
        """The same views with a transfer that was fitted elsewhere."""
        other = self.without_cache().with_fields()
        if self.usable.any():
            vars(other).update(fundamental=self.fundamental, transfer=transfer)
            square = (other.e[self.usable] ** 2).sum()
            vars(other)["E"] = float(square / (2 * self.usable.sum()))
        return other

    def without_cache(self) -> "Snapshot":
        """A snapshot without computed quantities: this one, if it has none."""
        return self if vars(self).keys() <= FIELDS else replace(self)

    def keeps_the_same(self, other: "Snapshot") -> bool:
        """Whether all fields of both are identical objects."""
        return all(getattr(self, name) is getattr(other, name) for name in FIELDS)

    @cached_property
    def fundamental(self) -> PairGeometry | None:
        """Affine epipolar geometry of the six pairs of views, from the usable points; None with too few of them."""
        views = self.views if self.rectification is None else rectify_views(self.views, self.rectification)
        known = None if self.transfer is None else self.transfer.fundamentals
        return fit_pairs(np.concatenate([views.demo, views.own], 1)[self.usable], known)

    def epipolar_lines(self, point: int) -> NDArray[np.float64] | None:
        """(12, 3): the epipolar lines of a body point in the original images (`PairGeometry.lines`).

        None with too few points. Lines in rectified images are mapped back.
        """
        if self.fundamental is None:
            return None
        if point not in self._lines:
            self._lines[point] = self._lines_of(self.fundamental, point)
        return self._lines[point]

    @cached_property
    def _lines(self) -> dict[int, NDArray]:
        """Cache of `epipolar_lines`, by body point."""
        return {}

    def _lines_of(self, fundamental: PairGeometry, point: int) -> NDArray:
        images, by = np.stack([self.views.demo[point], self.views.own[point]]), self.rectification
        if by is None:
            return fundamental.lines(images.reshape(4, 2))
        lines = fundamental.lines(by.apply(images).reshape(4, 2))
        return np.einsum("ki,kij->kj", lines, np.stack([by.left, by.right])[LINE_VIEWS % 2])


T = TypeVar("T")


def require_given(what: str, given: T | None) -> T:
    """Return a transfer or servo that was given to the session. Raise ValueError if none was."""
    if given is None:
        raise ValueError(f"{what} {OWN!r} is one of your own that is not here: give it to Session(settings, {what}=…)")
    return given


def exchanged(servo_state: Any) -> Pairs:
    """Pairs of points that a servo considers swapped. A custom state may have no such field."""
    return getattr(servo_state, "exchanged", ())


def probes(servo_state: Any) -> bool:
    """Whether the last motion was a probe. A custom state may have no such field."""
    return bool(getattr(servo_state, "probe", False))


def status_of(servo_state: Any, usual: ServoStatus) -> ServoStatus:
    """Status of a servo's state. usual: for a custom state without one.

    Raises ValueError for an unknown status, and for a claim of convergence without a certificate.
    """
    status = getattr(servo_state, "status", usual)
    try:
        found = ServoStatus(status)
    except ValueError:
        found = None
    if found not in SERVO_STATUSES:
        raise ValueError(f"a servo's status must be one of {', '.join(SERVO_STATUSES)}, got {status!r}")
    if found.is_claim and getattr(servo_state, "certificate", None) is None:
        raise ValueError("a servo's status is 'converged', but its state has no certificate: report 'settled'")
    return found


def predicted_residuals(
    now: Snapshot,
    velocity: NDArray[np.float64] = AT_REST,
    noise_px: float = 0.0,
    past: Sequence[Snapshot] = (),
    mirror_columns: bool = True,
) -> PredictedResiduals:
    """The residuals of predicted images against a snapshot's demonstrator.

    velocity: (N, 4) px a look, of the demonstrator's points; noise_px: standard deviation of an image coordinate; past:
    earlier snapshots, whose matches and residuals are reused; mirror_columns: as of `PredictedResiduals`.
    """
    return PredictedResiduals(
        now.views,
        now.method,
        now.rectification,
        noise_px=noise_px,
        velocity=velocity,
        converged=now.converged_transfer,
        past=[one.views for one in past],
        computed=_computed(now, past),
        mirror_columns=mirror_columns,
    )


def _computed(now: Snapshot, past: Sequence[Snapshot]) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Own images and residuals of snapshots that differ from `now` in nothing else."""
    if now.transfer is None or not now.views.complete:
        return
    for one in past:
        if (
            _equal(one.views.demo, now.views.demo)
            and _equal(one.views.visible, now.views.visible)
            and one.rectification is now.rectification
            and one.settings.transfer == now.settings.transfer
        ):
            yield one.views.own, one.residual


def _equal(one: NDArray, other: NDArray) -> bool:
    """Compare arrays, which are mostly identical, except in a resumed session."""
    return one is other or np.array_equal(one, other)


FIELDS = frozenset(field.name for field in fields(Snapshot))


@lru_cache(64)  # a demonstrator that stands still is asked for at every motion
def _flatness(demo: bytes) -> float:
    return flatness(np.frombuffer(demo).reshape(-1, 4))


WHY = {
    ServoStatus.CONVERGED: "the learner claims to have arrived",
    ServoStatus.SETTLED: "it rests, without evidence of having arrived",
    ServoStatus.UNOBSERVABLE: "the points do not determine every joint",
    ServoStatus.NO_PROGRESS: "no progress",
    ServoStatus.TOO_FEW_POINTS: "too few points are seen in all four images",
    ServoStatus.MAX_MOTIONS: "it made as many motions as it was allowed",
}


@dataclass(frozen=True, repr=False)
class RunResult:
    """Why `Session.run` ended, and how far the arm went."""

    motions: int  # made in this run
    travel: float  # rad, sum over the motions of the joint that moved most in each
    joint_travel: NDArray[np.float64]  # (m,) rad, the path length of each joint
    last: Snapshot  # at which the run ended

    def __repr__(self) -> str:
        return f"RunResult(status={self.status.value!r}, motions={self.motions}, travel_deg={self.travel_deg:.4g})"

    @property
    def status(self) -> ServoStatus:
        """The status of a servo at rest; otherwise too-few-points or max-motions."""
        if self.last.status.is_at_rest:
            return self.last.status
        return ServoStatus.TOO_FEW_POINTS if self.last.transfer is None else ServoStatus.MAX_MOTIONS

    @property
    def success(self) -> bool:
        """Whether the learner claims to have arrived."""
        return self.status.is_claim

    @property
    def message(self) -> str:
        """Why the run ended, in a sentence."""
        status, last = self.status, self.last
        why = "no motion was made" if status == ServoStatus.MAX_MOTIONS and last.motion == 0 else WHY[status]
        reasons = [why]
        if status == ServoStatus.NO_PROGRESS:
            reasons.append(last.servo.describe_status(last.servo_state, last.status))
        if last.transfer is None and status != ServoStatus.TOO_FEW_POINTS:
            reasons.append(WHY[ServoStatus.TOO_FEW_POINTS])
        if last.transfer is None and last.n_rejected:
            reasons.append(f"{last.n_rejected} points contradict the one epipolar geometry of a rigid stereo head")
        return ": ".join(filter(None, reasons))

    @property
    def travel_deg(self) -> float:
        """`travel` in degrees."""
        return float(np.degrees(self.travel))

    @property
    def joint_travel_deg(self) -> NDArray[np.float64]:
        """(m,) degrees: `joint_travel` in degrees."""
        return np.degrees(self.joint_travel)

    @property
    def theta(self) -> NDArray[np.float64]:
        """(m,) rad: the arm's true posture at the end, for viewers only."""
        return self.last.theta

    @property
    def E(self) -> float:
        """E at the end [px²]."""
        return self.last.E

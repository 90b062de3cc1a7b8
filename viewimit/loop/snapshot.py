"""One pass of the loop: what it leaves behind, and what follows from that."""

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

OF_A_SERVO = (ServoStatus.MOVING, *(status for status in ServoStatus if status.is_at_rest))


@dataclass(frozen=True, eq=False)
class Snapshot:
    """One moment of a session: its fields are what is kept; all else follows from `views` and `settings`.

    motion, look: how many were made until then; theta, theta_demo: (m,) rad, the truth, for viewers only,
    NaN where nobody knows it;
    views: what the learner saw, of all N points; rectification: by which images are rectified for the transfer, None if
    they are not; E: px², NaN with too few points to fit a transfer;
    commanded: (m,) rad, where the learner has sent its arm, which is theta if that obeys exactly;
    moved: (m,) rad, the motion that led here; probe: it was a probe;
    status: any; servo_state: None before the servo was asked;
    lag: looks that images come late, None until a motion has shown it;
    converged_transfer: the transfer as it was fitted at the last convergence, None before;
    calibration: what was seen of the own body before there was anybody to imitate, None if that was never rehearsed;
    pending_postures: (k, m) rad, postures still to watch itself in, None or (0, m) if there are none;
    target: (m,) rad, where the servo has sent the arm that is still on its way there, None if it is there;
    custom_transfer, custom_servo: given to the session itself, which settings call OWN; None if none was given.
    """

    settings: Settings
    motion: int
    look: int
    theta: NDArray
    theta_demo: NDArray
    views: FourViews
    rectification: Rectification | None
    E: float
    commanded: NDArray
    moved: NDArray
    probe: bool
    status: ServoStatus
    servo_state: Any
    lag: int | None
    converged_transfer: FittedTransfer | None
    calibration: SelfCalibration | None = None
    pending_postures: NDArray | None = None
    target: NDArray | None = None
    custom_transfer: TransferMethod | None = None
    custom_servo: ServoMethod | None = None

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
    def usable(self) -> NDArray:
        """(N,) bool: seen in all four views."""
        return self.views.usable

    @property
    def shown(self) -> int:
        """How many of the demonstrator's points are in sight in both images."""
        return int(np.count_nonzero(self.views.visible[:, :2].all(-1)))

    @property
    def half_shown(self) -> int:
        """How many are in sight in one image alone, for a transfer that can ask them: on a line of the other image."""
        asked = self.method.homography_of_space and self.settings.rectify != "off"
        return int(np.count_nonzero(self.views.partially_visible)) if asked else 0

    @property
    def shows_demonstrator(self) -> bool:
        """By as many points as a transfer needs."""
        return self.shown >= MIN_POINTS

    @cached_property
    def transfer(self) -> FittedTransfer | None:
        """Fitted to the usable points; None with too few of them."""
        if np.count_nonzero(self.usable) < MIN_POINTS:
            return None
        return self.fit(self.views.used)

    def fit(self, views: FourViews, by: str | None = None) -> FittedTransfer:
        """The transfer chosen, or another one by its name, fitted to any views as this moment rectifies them."""
        return fit_transfer(TRANSFERS[by] if by else self.method, views, self.rectification)

    @cached_property
    def flatness(self) -> float:
        """σ1/σ3 of the demonstrator's usable points in [l, r]; inf with too few of them."""
        return np.inf if self.transfer is None else _flatness(self.views.used.demo.tobytes())

    @cached_property
    def residual(self) -> NDArray:
        """(n, C) px, of the usable points, whose squares make E, of enough of them."""
        assert self.transfer is not None
        return self.transfer.residual(self.views.used)

    @cached_property
    def recovered(self) -> NDArray:
        """(N, 4) px: the demonstrator's points as the transfer expects them in [L, R]; NaN if not usable."""
        seen, transfer = self.views.used, self.transfer
        if transfer is not None and seen is self.views:
            return transfer.recover(seen.demo_left, seen.demo_right)
        recovered = np.full_like(self.views.own, np.nan)
        if transfer is not None:
            recovered[self.usable] = transfer.recover(seen.demo_left, seen.demo_right)
        return recovered

    @cached_property
    def e(self) -> NDArray:
        """(N, 4) px: residuals in [L, R], from the recovered points to the learner's own; NaN if not usable."""
        return self.views.own - self.recovered

    @property
    def is_rehearsing(self) -> bool:
        """Whether it is to watch itself before it imitates."""
        return self.pending_postures is not None and len(self.pending_postures) > 0

    @property
    def calibration_holds(self) -> bool | None:
        """Whether the servo still goes by what was rehearsed; None if nothing was, or none was asked yet."""
        if self.calibration is None or self.servo_state is None:
            return None
        return bool(getattr(self.servo_state, "calibration", ()))

    @property
    def certificate(self) -> Certificate | None:
        """What the servo can tell of its posture; None if it gives none."""
        return getattr(self.servo_state, "certificate", None)

    @property
    def exchanged(self) -> Pairs:
        """What the servo takes to be exchanged of the demonstrator's points; `views` have them exchanged back."""
        return exchanged(self.servo_state)

    @property
    def expected_error(self) -> float | None:
        """rad, of the worst joint, as the servo estimates it (`Certificate.simultaneous_std_error`), or None."""
        return None if self.certificate is None else self.certificate.simultaneous_std_error

    def with_fields(self, **changes) -> "Snapshot":
        """As dataclasses.replace; what was found already is not found anew if views and transfer stay.

        Raises TypeError for a name that is no field.
        """
        if not changes.keys() <= FIELDS:
            raise TypeError(f"a snapshot has no fields {', '.join(sorted(changes.keys() - FIELDS))}")
        same_images = "views" not in changes and "rectification" not in changes
        stays = same_images and changes.get("settings", self.settings).transfer == self.settings.transfer
        kept = vars(self) if stays else {name: value for name, value in vars(self).items() if name in FIELDS}
        other = object.__new__(Snapshot)  # a third of what `replace` takes: this is done twice a motion
        vars(other).update(kept, **changes)
        return other

    def recovered_by(self, transfer: FittedTransfer) -> "Snapshot":
        """The same views as a transfer that was fitted elsewhere recovers them."""
        other = self.without_cache().with_fields()
        if self.usable.any():
            vars(other).update(fundamental=self.fundamental, transfer=transfer)
            square = (other.e[self.usable] ** 2).sum()
            vars(other)["E"] = float(square / (2 * self.usable.sum()))
        return other

    def without_cache(self) -> "Snapshot":
        """A moment that holds its fields only: this one, if nothing that follows from them has been asked for yet."""
        return self if vars(self).keys() <= FIELDS else replace(self)

    def keeps_the_same(self, other: "Snapshot") -> bool:
        """Whether the fields of both are the very same objects."""
        return all(getattr(self, name) is getattr(other, name) for name in FIELDS)

    @cached_property
    def fundamental(self) -> PairGeometry | None:
        """Of the six pairs of views, rectified if they are for the transfer, from the usable points, whatever the
        transfer is; None with too few of them."""
        views = self.views if self.rectification is None else rectify_views(self.views, self.rectification)
        known = None if self.transfer is None else self.transfer.fundamentals
        return fit_pairs(np.concatenate([views.demo, views.own], 1)[self.usable], known)

    def epipolar_lines(self, point: int) -> NDArray | None:
        """(12, 3): `PairGeometry.lines` of a body point, in px as seen: lines in rectified images are mapped back. None
        with too few points for any."""
        if self.fundamental is None:
            return None
        if point not in self._lines:
            self._lines[point] = self._lines_of(self.fundamental, point)
        return self._lines[point]

    @cached_property
    def _lines(self) -> dict[int, NDArray]:
        """By body point, of those that were asked for."""
        return {}

    def _lines_of(self, fundamental: PairGeometry, point: int) -> NDArray:
        images, by = np.stack([self.views.demo[point], self.views.own[point]]), self.rectification
        if by is None:
            return fundamental.lines(images.reshape(4, 2))
        lines = fundamental.lines(by.apply(images).reshape(4, 2))
        return np.einsum("ki,kij->kj", lines, np.stack([by.left, by.right])[LINE_VIEWS % 2])


T = TypeVar("T")


def require_given(what: str, given: T | None) -> T:
    """What a session was given itself. Raises ValueError if it was given none."""
    if given is None:
        raise ValueError(f"{what} {OWN!r} is one of your own that is not here: give it to Session(settings, {what}=…)")
    return given


def exchanged(servo_state: Any) -> Pairs:
    """Pairs of points, none if the servo tells of none."""
    return getattr(servo_state, "exchanged", ())


def probes(servo_state: Any) -> bool:
    """Whether the motion asked for last is to learn from; a state without `probe` asks for none."""
    return bool(getattr(servo_state, "probe", False))


def status_of(servo_state: Any, usual: ServoStatus) -> ServoStatus:
    """Of a `ServoState`; usual: of a state without one. Raises ValueError for a status that there is not."""
    status = getattr(servo_state, "status", usual)
    try:
        found = ServoStatus(status)
    except ValueError:
        found = None
    if found not in OF_A_SERVO:
        raise ValueError(f"a servo's status must be one of {', '.join(OF_A_SERVO)}, got {status!r}")
    return found


def predicted_residuals(
    now: Snapshot, velocity: NDArray[np.float64] = AT_REST, noise_px: float = 0.0, past: Sequence[Snapshot] = ()
) -> PredictedResiduals:
    """Residuals that a servo may ask for at a moment.

    velocity: of the demonstrator's points, px; noise_px: standard deviation of an image coordinate; past: moments
    before, whose matches and residuals are known.
    """
    return PredictedResiduals(
        now.views,
        now.method,
        now.rectification,
        noise_px=noise_px,
        velocity=velocity,
        converged=now.converged_transfer,
        past=[moment.views for moment in past],
        computed=_computed(now, past),
    )


def _computed(now: Snapshot, past: Sequence[Snapshot]) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Own images and residuals of the moments at which all else was as it is now."""
    if now.transfer is None or not now.views.complete:
        return
    for moment in past:
        if (
            _equal(moment.views.demo, now.views.demo)
            and _equal(moment.views.visible, now.views.visible)
            and moment.rectification is now.rectification
            and moment.settings.transfer == now.settings.transfer
        ):
            yield moment.views.own, moment.residual


def _equal(one: NDArray, other: NDArray) -> bool:
    """Mostly the same array; not where a session was resumed."""
    return one is other or np.array_equal(one, other)


FIELDS = frozenset(field.name for field in fields(Snapshot))


@lru_cache(64)  # the demonstrator mostly stands still while the learner moves
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
    """Why `Session.run` ended, and what it took.

    motions: made in this run; joint_travel: (m,) rad, how far each joint went in them, back and forth; travel: rad, sum
    over the motions of the joint that moved most in each; last: the moment at which it ended.
    """

    motions: int
    travel: float
    joint_travel: NDArray
    last: Snapshot

    def __repr__(self) -> str:
        return f"RunResult(status={self.status.value!r}, motions={self.motions}, travel_deg={self.travel_deg:.4g})"

    @property
    def status(self) -> ServoStatus:
        """Of the servo at rest; else too-few-points or max-motions."""
        if self.last.status.is_at_rest:
            return self.last.status
        return ServoStatus.TOO_FEW_POINTS if self.last.transfer is None else ServoStatus.MAX_MOTIONS

    @property
    def success(self) -> bool:
        """Whether the learner claims to have arrived."""
        return self.status.is_claim

    @property
    def message(self) -> str:
        """Why it ended, in a line."""
        status, last = self.status, self.last
        why = "no motion was made" if status == ServoStatus.MAX_MOTIONS and last.motion == 0 else WHY[status]
        says = last.servo.describe_status(last.servo_state, last.status) if status == ServoStatus.NO_PROGRESS else ""
        return f"{why}: {says}" if says else why

    @property
    def travel_deg(self) -> float:
        """`travel` in degrees."""
        return float(np.degrees(self.travel))

    @property
    def joint_travel_deg(self) -> NDArray:
        """(m,) degrees"""
        return np.degrees(self.joint_travel)

    @property
    def theta(self) -> NDArray:
        """(m,) rad, where the arm stands: the truth, for viewers only."""
        return self.last.theta

    @property
    def E(self) -> float:
        """px², at the end."""
        return self.last.E

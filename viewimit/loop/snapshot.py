"""The records of the loop: `Snapshot`, of one pass, and `RunResult`, of a whole run."""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..estimation.rectification import fit_transfer, rectify_views
from ..estimation.transfers import TRANSFERS, FittedTransfer, TransferMethod
from ..estimation.views import FourViews, Pairs
from ..geometry.affine import LINE_VIEWS, MIN_POINTS, PairGeometry, fit_pairs, flatness
from ..geometry.arrays import Floats
from ..geometry.rectification import Rectification
from ..servo import SERVOS, Certificate, Misfit, Naming, ServoMethod, ServoState, ServoStatus, verdict
from ..servo.verdict import ANY_JOINT
from ..wording import listed, sentences
from .self_calibration import SelfCalibration
from .settings import OWN, Settings

Limits = tuple[Floats, Floats]  # lowest and highest angles, (m,) rad each

Images = tuple[Floats, NDArray[np.bool_]]  # of one body: points (N, 4) px, visible (N, 2)


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The session after a motion: an immutable record of one pass of the loop.

    The fields are recorded. All other quantities follow from them, are computed when first used, and then kept.
    """

    settings: Settings
    motion: int  # number of motions so far
    look: int  # number of looks at the own body so far
    theta: Floats  # (m,) rad, the learner's true posture, for viewers only
    theta_demo: Floats  # (m,) rad, the demonstrator's true posture, for viewers only; NaN where unknown
    views: FourViews  # the image points of both bodies, all N
    rectification: Rectification | None  # of the images, for the transfer; None if they stay as they are
    E: float  # px²; NaN with too few points to fit a transfer
    commanded: Floats  # (m,) rad, where the arm was sent: theta, if it obeys exactly
    moved: Floats  # (m,) rad, the motion that led here
    probe: bool  # that motion was made to learn from it
    status: ServoStatus
    servo_state: Any  # None before the servo was first asked
    lag: int | None  # latency of the images in looks; None until a motion has shown it
    converged_transfer: FittedTransfer | None  # as fitted at the last convergence
    calibration: SelfCalibration | None = None  # images of the own body, recorded before imitating
    pending_postures: Floats | None = None  # (k, m) rad, that the calibration has still to visit
    target: Floats | None = None  # (m,) rad, where an arm is going that is still on its way
    custom_transfer: TransferMethod | None = None  # given to the session itself; settings call it OWN
    custom_servo: ServoMethod | None = None  # given to the session itself; settings call it OWN
    demo_looks: tuple[Images, ...] = ()  # at the demonstrator since it last moved, in the order of the eyes
    n_rejected: int = 0  # points that all images show and that contradict the epipolar geometry of one rigid head
    frozen_transfer: FittedTransfer | None = None  # fitted elsewhere, replaces the one fitted here

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

    # What the method computes from the views: transfer → recovered points → residuals e → E

    @property
    def usable(self) -> NDArray[np.bool_]:
        """(N,) bool: visible in all four views."""
        return self.views.usable

    @cached_property
    def _fitted(self) -> FittedTransfer | None:
        if np.count_nonzero(self.views.usable) < MIN_POINTS:
            return None
        return self.fit(self.views.used)

    @property
    def transfer(self) -> FittedTransfer | None:
        """The transfer fitted to the usable points, or the frozen one; None with fewer than MIN_POINTS."""
        return self._fitted if self.frozen_transfer is None else self.frozen_transfer

    @cached_property
    def recovered(self) -> Floats:
        """(N, 4) px: the demonstrator's points, transferred to [L, R]; NaN if not usable."""
        seen, transfer = self.views.used, self.transfer
        if transfer is not None and seen is self.views:
            return transfer.recover(seen.demo_left, seen.demo_right)
        recovered = np.full_like(self.views.own, np.nan)
        if transfer is not None:
            recovered[self.views.usable] = transfer.recover(seen.demo_left, seen.demo_right)
        return recovered

    @cached_property
    def e(self) -> Floats:
        """(N, 4) px: residuals in [L, R], own minus recovered points; NaN if not usable."""
        return self.views.own - self.recovered

    @cached_property
    def residual(self) -> Floats:
        """(n, C) px: residuals of the usable points, whose squares make E. Needs a transfer."""
        assert self.transfer is not None
        return self.transfer.residual(self.views.used)

    @cached_property
    def flatness(self) -> float:
        """σ1/σ3 of the demonstrator's usable points in [l, r]; inf with too few of them."""
        return np.inf if self.transfer is None else _flatness(self.views.used.demo.tobytes())

    @cached_property
    def fundamental(self) -> PairGeometry | None:
        """Affine epipolar geometry of the six pairs of views, from the usable points; None with too few of them."""
        views = self.views if self.rectification is None else rectify_views(self.views, self.rectification)
        known = None if self._fitted is None else self._fitted.fundamentals
        return fit_pairs(np.concatenate([views.demo, views.own], 1)[self.views.usable], known)

    def fit(self, views: FourViews, by: str | None = None) -> FittedTransfer:
        """Fit a transfer to views, rectified as here.

        Parameters
        ----------
        views : FourViews
            Usable points only.
        by : str, optional
            Name of the transfer; by default that of the settings.

        Returns
        -------
        FittedTransfer
            The map from [l, r] to [L, R].
        """
        return fit_transfer(TRANSFERS[by] if by else self.method, views, self.rectification)

    def epipolar_lines(self, point: int) -> Floats | None:
        """Compute the epipolar lines of a body point in the original images.

        Parameters
        ----------
        point : int
            Index of the point.

        Returns
        -------
        (12, 3) array or None
            Lines as `PairGeometry.lines`; those in rectified images are mapped back. None with too few points.
        """
        if self.fundamental is None:
            return None
        images, by = np.stack([self.views.demo[point], self.views.own[point]]), self.rectification
        if by is None:
            return self.fundamental.lines(images.reshape(4, 2))
        lines = self.fundamental.lines(by.apply(images).reshape(4, 2))
        return np.einsum("ki,kij->kj", lines, np.stack([by.left, by.right])[LINE_VIEWS % 2])

    # What is seen of the demonstrator

    @property
    def shown(self) -> int:
        """Number of the demonstrator's points that are visible in both images."""
        return int(np.count_nonzero(self.views.visible[:, :2].all(-1)))

    @property
    def shows_demonstrator(self) -> bool:
        """Whether enough of the demonstrator's points are visible for a transfer."""
        return self.shown >= MIN_POINTS

    @property
    def awaits_names(self) -> bool:
        """Whether the demonstrator is visible, and its points are still to be named."""
        return not self.views.matched and self.shows_demonstrator

    @property
    def is_blind(self) -> bool:
        """Whether too few points are visible for E, and the learner knows no more to do than to look again."""
        return self.transfer is None and self.target is None and not self.awaits_names

    @property
    def leaves_servo_blind(self) -> bool:
        """Whether the servo cannot lead on: it has no E, and predicts no images or does not see the demonstrator."""
        goes_on = self.servo_state is not None and self.servo.predicts and self.shows_demonstrator
        return self.transfer is None and not goes_on

    # What the servo says

    @cached_property
    def says(self) -> ServoState:
        """What the servo's state says, and defaults for what it does not."""
        return ServoState.of(self.servo_state)

    @property
    def certificate(self) -> Certificate | None:
        """The servo's convergence test; None if it makes none."""
        return self.says.certificate

    @property
    def exchanged(self) -> Pairs:
        """Pairs of the demonstrator's points that the servo considers swapped; `views` are corrected."""
        return self.says.exchanged

    @property
    def misfit(self) -> Misfit | None:
        """Why the demonstrator's images fit no posture of the own body, as the servo found; None: no sign of that."""
        return self.says.misfit

    @property
    def naming(self) -> Naming | None:
        """What the servo found about the names of the demonstrator's points; None if they came with names."""
        return self.says.naming

    @property
    def correspondences(self) -> tuple[Any, ...]:
        """Compares equal if the servo takes the demonstrator's points for the same own points, in the same order."""
        names = self.says.names
        return self.views.matched, self.exchanged, None if names is None else names.tobytes()

    @property
    def expected_error(self) -> float | None:
        """rad, of the worst joint, as the servo estimates it (`Certificate.simultaneous_std_error`), or None."""
        return None if self.certificate is None else self.certificate.simultaneous_std_error

    @property
    def awake_status(self) -> ServoStatus:
        """The status of a session at this motion whose servo will be asked again."""
        return ServoStatus.READY if self.motion == 0 else ServoStatus.MOVING

    @property
    def is_rehearsing(self) -> bool:
        """Whether the learner has still to visit postures of its calibration."""
        return self.pending_postures is not None and len(self.pending_postures) > 0

    @property
    def calibration_holds(self) -> bool | None:
        """Whether the servo still uses the calibration; None without one, or before the servo was asked."""
        if self.calibration is None or self.servo_state is None:
            return None
        return bool(self.says.calibration)

    # Other snapshots made of this one

    def with_fields(self, **changes: Any) -> "Snapshot":
        """Make a snapshot with other values of some fields. What was computed from those that stay is kept.

        Parameters
        ----------
        **changes
            Fields and their values. TypeError for another name.

        Returns
        -------
        Snapshot
            The other one.
        """
        other = replace(self, **changes)
        kept = COMPUTED & self.__dict__.keys()
        if kept and all(getattr(self, name) is getattr(other, name) for name in COMPUTED_FROM):
            other.__dict__.update({name: self.__dict__[name] for name in kept})
        return other

    def recovered_by(self, transfer: FittedTransfer) -> "Snapshot":
        """Evaluate the same views with a transfer that was fitted elsewhere.

        Parameters
        ----------
        transfer : FittedTransfer
            Replaces the one fitted here.

        Returns
        -------
        Snapshot
            With the residuals and E of that transfer.
        """
        if not self.usable.any():
            return self
        other = self.with_fields(frozen_transfer=transfer)
        square = float((other.e[self.usable] ** 2).sum())
        return other.with_fields(E=square / (2 * int(self.usable.sum())))


COMPUTED_FROM = "views", "rectification", "method", "frozen_transfer"
COMPUTED = {"_fitted", "recovered", "e", "residual", "flatness", "fundamental"}


@lru_cache(64)  # the images of a demonstrator that stands still are the same at every motion
def _flatness(demo: bytes) -> float:
    return flatness(np.frombuffer(demo).reshape(-1, 4))


T = TypeVar("T")


def require_given(what: str, given: T | None) -> T:
    """Return a transfer or servo that was given to the session. Raise ValueError if none was."""
    if given is None:
        raise ValueError(f"{what} {OWN!r} is one of your own that is not here: give it to Session(settings, {what}=…)")
    return given


class CustomMethods(NamedTuple):
    """A transfer and a servo that were given to the session itself, which settings call OWN; None for none."""

    transfer: TransferMethod | None = None
    servo: ServoMethod | None = None

    def require(self, settings: Settings) -> None:
        """Raise ValueError for settings that name a method that was not given, or a servo that cannot name points."""
        for name, given in zip(self._fields, self):
            if getattr(settings, name) == OWN:
                require_given(name, given)
        servo = self.servo if settings.servo == OWN else SERVOS[settings.servo]
        if not settings.matched and servo is not None and not servo.names_points:
            able = ", ".join(name for name, found in SERVOS.items() if found.names_points)
            raise ValueError(f"matched: the servo {settings.servo!r} needs points with names; {able} finds the names")


@dataclass(frozen=True, repr=False)
class RunResult:
    """Why `Session.run` ended, and how far the arm went."""

    motions: int  # made in this run
    travel: float  # rad, sum over the motions of the joint that moved most in each
    joint_travel: Floats  # (m,) rad, the path length of each joint
    last: Snapshot  # at which the run ended
    joints: tuple[int, ...] = ()  # numbers of the moving joints, if they are not counted from 1

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
        """What is told of the run in every front end, and why it ended, in sentences."""
        status, last, known = self.status, self.last, self.last.certificate
        off = None if last.expected_error is None else float(np.degrees(last.expected_error))
        unobservable = [] if known is None else known.unobservable_joints
        names = listed([f"joint {self.joints[k] if self.joints else k + 1}" for k in unobservable]) or ANY_JOINT
        reasons = [verdict(status).sentence(last.motion, last.E, int(last.usable.sum()), names, off)]
        if status.is_at_rest and not status.is_claim and last.misfit is not None:
            reasons.append(last.misfit.describe(self.joints))
        elif status == ServoStatus.NO_PROGRESS:
            reasons.append(last.servo.describe_status(last.servo_state, status))
        sees_too_few = last.transfer is None and not last.awaits_names
        if sees_too_few and status != ServoStatus.TOO_FEW_POINTS:
            few = verdict(ServoStatus.TOO_FEW_POINTS)
            reasons.append(few.sentence(last.motion, last.E, int(last.usable.sum())))
        if sees_too_few and last.n_rejected:
            reasons.append(f"{last.n_rejected} points contradict the one epipolar geometry of a rigid stereo head.")
        return sentences(*reasons)

    @property
    def travel_deg(self) -> float:
        """`travel` in degrees."""
        return float(np.degrees(self.travel))

    @property
    def joint_travel_deg(self) -> Floats:
        """(m,) degrees: `joint_travel` in degrees."""
        return np.degrees(self.joint_travel)

    @property
    def theta(self) -> Floats:
        """(m,) rad: the arm's true posture at the end, for viewers only."""
        return self.last.theta

    @property
    def E(self) -> float:
        """E at the end [px²]."""
        return self.last.E

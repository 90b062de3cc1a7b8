"""The records of the loop: `Snapshot`, of one pass, and `RunResult`, of a whole run."""

from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..estimation.prediction import AT_REST, PredictedResiduals
from ..estimation.rectification import fit_transfer
from ..estimation.transfers import TRANSFERS, FittedTransfer, TransferMethod
from ..estimation.views import FourViews, Pairs
from ..geometry.affine import MIN_POINTS, PairGeometry
from ..geometry.rectification import Rectification
from ..servo import SERVOS, Certificate, Misfit, Naming, Observation, ServoMethod, ServoStatus, verdict
from ..servo.observation import repeat_xy
from ..wording import sentences
from .demonstrator import Images, average_looks
from .evaluation import Evaluation
from .self_calibration import MIN_POSTURES, SelfCalibration
from .servo_state import StateAttributes
from .settings import OWN, Settings

Limits = tuple[NDArray[np.float64], NDArray[np.float64]]  # lowest and highest angles, (m,) rad each


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
    calibration: SelfCalibration | None = None  # images of the own body, recorded before imitating
    pending_postures: NDArray[np.float64] | None = None  # (k, m) rad, that the calibration has still to visit
    target: NDArray[np.float64] | None = None  # (m,) rad, where an arm is going that is still on its way
    custom_transfer: TransferMethod | None = None  # given to the session itself; settings call it OWN
    custom_servo: ServoMethod | None = None  # given to the session itself; settings call it OWN
    demo_looks: tuple[Images, ...] = ()  # at the demonstrator since it last moved, in the order of the eyes
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

    @property
    def evaluation(self) -> Evaluation:
        """What the method computes from `views`. Snapshots of the same views share it (`with_fields`)."""
        found = _EVALUATIONS.get(self)
        if found is None:
            found = _EVALUATIONS.setdefault(self, Evaluation(self.views, self.rectification, self.method))
        return found

    @property
    def usable(self) -> NDArray[np.bool_]:
        """(N,) bool: visible in all four views."""
        return self.views.usable

    @property
    def transfer(self) -> FittedTransfer | None:
        """The transfer fitted to the usable points; None with fewer than MIN_POINTS."""
        return self.evaluation.transfer

    @property
    def recovered(self) -> NDArray[np.float64]:
        """(N, 4) px: the demonstrator's points, transferred to [L, R]; NaN if not usable."""
        return self.evaluation.recovered

    @property
    def e(self) -> NDArray[np.float64]:
        """(N, 4) px: residuals in [L, R], own minus recovered points; NaN if not usable."""
        return self.evaluation.e

    @property
    def residual(self) -> NDArray[np.float64]:
        """(n, C) px: residuals of the usable points, whose squares make E. Needs a transfer."""
        return self.evaluation.residual

    @property
    def flatness(self) -> float:
        """σ1/σ3 of the demonstrator's usable points in [l, r]; inf with too few of them."""
        return self.evaluation.flatness

    @property
    def fundamental(self) -> PairGeometry | None:
        """Affine epipolar geometry of the six pairs of views, from the usable points; None with too few of them."""
        return self.evaluation.fundamental

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

    def is_renamed_by(self, servo_state: Any) -> bool:
        """Whether a servo's state has other names for the demonstrator's points than these views.

        Parameters
        ----------
        servo_state : any
            The servo's answer to this snapshot.

        Returns
        -------
        bool
            Whether to look again, with the points in another order.
        """
        names, here = StateAttributes.of(servo_state).names, self._state.names
        if names is None or self.settings.matched:
            return False
        return not self.views.matched or here is None or not np.array_equal(names, here)

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

    @property
    def awake_status(self) -> ServoStatus:
        """The status of a session at this motion whose servo will be asked again."""
        return ServoStatus.READY if self.motion == 0 else ServoStatus.MOVING

    def shows_same_demonstrator(self, other: "Snapshot") -> bool:
        """Compare the demonstrator's images.

        Parameters
        ----------
        other : Snapshot
            The one to compare with.

        Returns
        -------
        bool
            Whether they are equal.
        """
        one, demo = self.views.demo, other.views.demo
        return one is demo or np.array_equal(one, demo, equal_nan=True)

    def demonstrator_average(self, noise_px: float, fixed_px: float) -> tuple[NDArray[np.float64] | None, float | None]:
        """Average all looks at the demonstrator since it last moved.

        Parameters
        ----------
        noise_px, fixed_px : float
            As of `average_looks`.

        Returns
        -------
        (N, 4) array or None
            Its points in [l, r] [px], in the order of `views`; NaN where no look shows a point, or it is an outlier.
            None if there is one look only.
        float or None
            Standard deviation of a coordinate [px].
        """
        if len(self.demo_looks) < 2:
            return None, None
        (points, visible), noise_px = average_looks(self.demo_looks, noise_px, fixed_px)
        first = self._in_order(self.demo_looks[0][0], self.demo_looks[0][1])
        rejected = first.visible[:, :2] & ~self.views.visible[:, :2]
        average = self._in_order(points, visible)
        return np.where(repeat_xy(average.visible[:, :2] & ~rejected), average.demo, np.nan), noise_px

    def _in_order(self, demo: NDArray[np.float64], visible: NDArray[np.bool_]) -> FourViews:
        """Put the demonstrator's points, (N, 4) px, in the order of `views`. visible: (N, 2)."""
        views = FourViews(demo, self.views.own, np.concatenate([visible, self.views.visible[:, 2:]], -1))
        if not self.settings.matched and self.views.matched and self._state.names is not None:
            views = views.named(self._state.names)
        return views.permuted(self.exchanged)

    @property
    def is_rehearsing(self) -> bool:
        """Whether the learner has still to visit postures of its calibration."""
        return self.pending_postures is not None and len(self.pending_postures) > 0

    @property
    def calibration_holds(self) -> bool | None:
        """Whether the servo still uses the calibration; None without one, or before the servo was asked."""
        if self.calibration is None or self.servo_state is None:
            return None
        return bool(self._state.calibration)

    @property
    def certificate(self) -> Certificate | None:
        """The servo's convergence test; None if it makes none."""
        return self._state.certificate

    @property
    def exchanged(self) -> Pairs:
        """Pairs of the demonstrator's points that the servo considers swapped; `views` are corrected."""
        return self._state.exchanged

    @property
    def misfit(self) -> Misfit | None:
        """Why the demonstrator's images fit no posture of the own body, as the servo found; None: no sign of that."""
        return self._state.misfit

    @property
    def correspondences(self) -> tuple[Any, ...]:
        """Compares equal if the servo takes the demonstrator's points for the same own points, in the same order."""
        names = self._state.names
        return self.views.matched, self.exchanged, None if names is None else names.tobytes()

    @property
    def naming(self) -> Naming | None:
        """What the servo found about the names of the demonstrator's points; None if they came with names."""
        return self._state.naming

    @property
    def _state(self) -> StateAttributes:
        return StateAttributes.of(self.servo_state)

    @property
    def expected_error(self) -> float | None:
        """rad, of the worst joint, as the servo estimates it (`Certificate.simultaneous_std_error`), or None."""
        return None if self.certificate is None else self.certificate.simultaneous_std_error

    def with_fields(self, **changes: Any) -> "Snapshot":
        """Make a snapshot with other values of some fields. It shares the evaluation if views and transfer stay.

        Parameters
        ----------
        **changes
            Fields and their values.

        Returns
        -------
        Snapshot
            The other one.

        Raises
        ------
        TypeError
            For another name.
        """
        if not changes.keys() <= FIELDS:
            raise TypeError(f"a snapshot has no fields {', '.join(sorted(changes.keys() - FIELDS))}")
        other = replace(self, **changes)
        found = _EVALUATIONS.get(self)
        if found is not None and found.is_of(other.views, other.rectification, other.method):
            _EVALUATIONS[other] = found
        return other

    def at_rest(self, servo_state: Any) -> "Snapshot":
        """Record that the servo asks for no motion.

        Parameters
        ----------
        servo_state : any
            The state that it returned.

        Returns
        -------
        Snapshot
            With the status of a servo at rest.
        """
        status = StateAttributes.of(servo_state).status_at_rest
        converged_transfer = self.transfer if status.is_at_minimum else self.converged_transfer
        return self.with_fields(servo_state=servo_state, status=status, converged_transfer=converged_transfer)

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
            return self.without_cache()
        evaluation = replace(self.evaluation, frozen=transfer)
        square = float((evaluation.e[self.usable] ** 2).sum())
        other = replace(self, E=square / (2 * int(self.usable.sum())))
        _EVALUATIONS[other] = evaluation
        return other

    def without_cache(self) -> "Snapshot":
        """Drop the evaluation.

        Returns
        -------
        Snapshot
            One that computes it again when it is used: this one, if it has none.
        """
        return replace(self) if self in _EVALUATIONS else self

    def keeps_the_same(self, other: "Snapshot") -> bool:
        """Compare two snapshots by their fields.

        Parameters
        ----------
        other : Snapshot
            The one to compare with.

        Returns
        -------
        bool
            Whether all fields are identical objects.
        """
        return all(getattr(self, name) is getattr(other, name) for name in FIELDS)

    def epipolar_lines(self, point: int) -> NDArray[np.float64] | None:
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
        return self.evaluation.epipolar_lines(point)


FIELDS = frozenset(field.name for field in fields(Snapshot))
_EVALUATIONS: WeakKeyDictionary[Snapshot, Evaluation] = WeakKeyDictionary()  # those that were used; see `evaluation`
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


def observation(
    now: Snapshot, workspace: Limits, lower: NDArray[np.float64], noise_px: float, fixed_px: float
) -> Observation:
    """Select what a servo is given of a snapshot.

    workspace: lowest and highest angles that the arm may be sent to, (m,) rad each; lower: (m,) rad, the arm's own
    limits, from which a calibration counts; noise_px: standard deviation of an image coordinate, fixed_px: the part of
    it that no averaging reduces.
    """
    start, demo_seen, seen = now.settings.start_rad, now.views.visible[:, :2], now.views.visible[:, 2:]
    average, demo_noise_px = now.demonstrator_average(noise_px, fixed_px)
    known = now.calibration if now.calibration is not None and len(now.calibration) >= MIN_POSTURES else None
    return Observation(
        own=now.views.own if now.views.complete else np.where(repeat_xy(seen), now.views.own, np.nan),
        seen=seen,
        demo=np.where(repeat_xy(demo_seen), now.views.demo, np.nan),
        demo_average=average,
        demo_noise_px=demo_noise_px,
        E=now.E,
        displacement=now.commanded - start,
        lower=workspace[0] - start,
        upper=workspace[1] - start,
        motion=now.motion,
        residual=now.e,
        noise_px=noise_px if known is None else max(noise_px, known.noise_px),
        matched=now.views.matched,
        calibration=() if known is None else known.seen_from(lower - start),
        rectification=now.rectification,
        max_step=now.settings.max_step,
        seed=now.settings.seed,
    )


def predicted_residuals(
    now: Snapshot,
    velocity: NDArray[np.float64] = AT_REST,
    noise_px: float = 0.0,
    mirror_columns: bool = True,
) -> PredictedResiduals:
    """The residuals of predicted images against a snapshot's demonstrator.

    velocity: (N, 4) px a look, of the demonstrator's points; noise_px: standard deviation of an image coordinate;
    mirror_columns: as of `PredictedResiduals`.
    """
    return PredictedResiduals(
        now.views,
        now.method,
        now.rectification,
        noise_px=noise_px,
        velocity=velocity,
        converged=now.converged_transfer,
        mirror_columns=mirror_columns,
    )


@dataclass(frozen=True, repr=False)
class RunResult:
    """Why `Session.run` ended, and how far the arm went."""

    motions: int  # made in this run
    travel: float  # rad, sum over the motions of the joint that moved most in each
    joint_travel: NDArray[np.float64]  # (m,) rad, the path length of each joint
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
        off = None if known is None else float(np.degrees(known.simultaneous_std_error))
        reasons = [verdict(status).sentence(last.motion, last.E, int(last.usable.sum()), std_error_deg=off)]
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

"""The loop of the paper: a learner looks, asks its servo, and moves.

The method is `Learner.step`, in the order of the paper:

    posture → body points in 3-D → four views → transfer → recovered points → residual e → E → servo → next posture

Every pass leaves one immutable `Snapshot`. Panels, plots, exports and tests all read this record.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..estimation.outliers import reject_outliers
from ..estimation.rectification import MAX_LOOKS, update_rectification
from ..estimation.residuals import VELOCITY_LOOKS, PredictedResiduals, target_velocity
from ..estimation.views import FourViews
from ..geometry.arrays import Floats
from ..geometry.rectification import Rectification
from ..sensing.frames import MIN_FRAMES, average_frames, noise_std
from ..servo import Observation, ServoState
from ..servo.observation import Visit, repeat_xy
from ..servo.status import ServoStatus
from .arm_and_eyes import waypoints
from .history import MAX_HISTORY
from .real_robot import RealObserver, RealRobot
from .self_calibration import MIN_POSTURES
from .settings import Settings, level_outside
from .simulated_robot import SimulatedObserver, SimulatedRobot
from .snapshot import Images, Limits, Snapshot

MAX_DEMO_LOOKS = 64  # that are remembered
OWN_NOISE_COUNTS = 8  # differences of images that the noise of the own images counts as much as
Embodiment = SimulatedRobot | RealRobot
Observer = SimulatedObserver | RealObserver
Past = Sequence[Snapshot]  # the last ones, the present one last


@dataclass(frozen=True)
class Learner:
    """An arm and eyes that imitate. It remembers nothing: each method is given the past snapshots, and returns one."""

    embodiment: Embodiment  # the arm, and its view of the demonstrator
    observer: Observer  # how both bodies are seen
    workspace: Limits  # lowest and highest angles that the arm may be sent to, (m,) rad each

    def step(self, past: Past) -> Snapshot:
        """Make one pass of the loop: ask the servo, move the arm, look.

        A motion longer than `Settings.max_step_deg` takes several passes; the servo is asked again after the last.

        past: up to the present one. Returns the snapshot after the motion; if the arm stays, one at the same motion.
        """
        now = past[-1]
        if now.pending_postures is not None and now.is_rehearsing:
            return self._recorded(self._moved(past, now, now.pending_postures[0], probe=True))
        if now.motion >= MAX_HISTORY:
            return now.with_fields(status=ServoStatus.MAX_MOTIONS)
        if now.target is not None:
            return self._moved(past, now, now.target, status=now.says.status_or(ServoStatus.MOVING))
        state, displacement = self._ask(past, now)  # residual e, E → servo
        while _renames(state, now):
            now = self.seen(past, now.theta, now, servo_state=state)
            if now.transfer is None:
                return now
            state, displacement = self._ask(past, now)
        says = ServoState.of(state)
        if says.exchanged != now.exchanged:
            now = self.seen(past, now.theta, now, servo_state=state)
        if not displacement.any():
            return _at_rest(now, state)
        changes = {"probe": says.probe, "status": says.status_or(ServoStatus.MOVING), "servo_state": state}
        return self._moved(past, now, now.commanded + displacement, **changes)  # → next posture

    def _ask(self, past: Past, now: Snapshot) -> tuple[Any, Floats]:
        """Ask the servo for its next state and motion, (m,) rad."""
        servo, seen = now.servo, self.observation(now)
        residuals = self.predicted_residuals(past, now, servo.mirror_columns)
        state = servo.start(seen) if now.servo_state is None else now.servo_state
        answer = servo.step(state, seen, residuals)
        if not (isinstance(answer, tuple) and len(answer) == 2):
            raise TypeError(f"the servo {servo.title!r} must return its state and its motion, (m,) rad, got {answer!r}")
        if answer[0] is None and state is not None:
            raise TypeError(f"the servo {servo.title!r} returned None as its next state; only stateless servos may")
        state, displacement = answer[0], np.asarray(answer[1], float)
        if displacement.shape != seen.displacement.shape or not np.isfinite(displacement).all():
            expected = f"{len(seen.displacement)} finite angles in rad"
            raise ValueError(f"the servo {servo.title!r} must return its state and {expected}, got {displacement}")
        target = seen.displacement + displacement
        if (np.abs(target - target.clip(seen.lower, seen.upper)) >= 2 * np.pi).any():
            asked = f"the servo {servo.title!r} asks for a motion of {displacement} rad"
            warnings.warn(f"{asked}, a turn or more beyond the limits: are these degrees?", stacklevel=level_outside())
        return state, displacement

    def _recorded(self, after: Snapshot) -> Snapshot:
        """Record the images after a motion of a rehearsal, if the arm has arrived."""
        assert after.pending_postures is not None and after.calibration is not None
        pending, calibration = after.pending_postures, after.calibration
        if after.target is None:
            visit = Visit.of(after.commanded - self.embodiment.lower, after.views.own, after.views.visible[:, 2:])
            pending, calibration = pending[1:], replace(calibration, visits=(*calibration.visits, visit))
        status = ServoStatus.REHEARSING if len(pending) else after.awake_status
        return after.with_fields(calibration=calibration, pending_postures=pending, status=status)

    def _moved(self, past: Past, now: Snapshot, target: Floats, **changes: Any) -> Snapshot:
        """Drive the arm towards the target, (m,) rad, within its limits, and look. `changes` are other new fields."""
        target = target.clip(*self.workspace)
        commanded, *later = waypoints(now.commanded, target, now.settings.max_step)
        theta = self.embodiment.drive(now.settings, now.theta, now.commanded, commanded)
        n_looks, lag = self.observer.wait_for_motion(now, theta)
        after = self.seen(
            past, theta, now, motion=now.motion + 1, look=now.look + 1 + n_looks, lag=lag, commanded=commanded,
            moved=theta - now.theta, target=target if later else None, **changes,
        )  # fmt: skip
        return self._retargeted(now, after)

    def seen(self, past: Past, theta: Floats, like: Snapshot, **changes: Any) -> Snapshot:
        """Look with the arm at a posture, and evaluate E, as `Session.observe`; `past` ends with the present."""
        # posture → body points in 3-D → four views l, r, L, R
        views, n_rejected = self._four_views(past, theta, like, **changes)
        rectification = _rectification(past, views, changes.get("settings", like.settings))
        seen = like.with_fields(
            theta=theta, views=views, n_rejected=n_rejected, rectification=rectification, frozen_transfer=None,
            **changes,
        )  # fmt: skip
        seen = seen.with_fields(demo_looks=self._demo_looks(seen, like, changes))
        if seen.awaits_names:  # E is not known before
            return seen.with_fields(E=np.nan)
        if seen.transfer is None:  # → transfer; for the epipolar one, fundamental matrices
            return seen.with_fields(E=np.nan, status=ServoStatus.TOO_FEW_POINTS)
        E = float(seen.transfer.conflict(seen.views.used))  # → recovered points → residual e → E
        if np.isnan(E):
            raise ValueError(f"the transfer {seen.method.title!r} maps visible points to NaN")
        return seen.with_fields(E=E)

    def _four_views(self, past: Past, theta: Floats, like: Snapshot, **changes: Any) -> tuple[FourViews, int]:
        """The image points of both bodies without outliers, and how many points became unusable by that.

        The servo's names of points that come without are applied, and its correction of swapped points.
        """
        settings, look = changes.get("settings", like.settings), changes.get("look", like.look)
        views = self.observer.four_views(settings, theta, changes.get("theta_demo", like.theta_demo), look)
        says = ServoState.of(changes.get("servo_state", like.servo_state))
        if not settings.matched:
            views = replace(views, matched=False) if says.names is None else views.named(says.names)
        views = views.permuted(says.exchanged)
        looks, noise_px = [one.views for one in past[-MAX_LOOKS:]], self.observer.image_noise_std(settings)
        inliers = reject_outliers(views, looks, past[-1].rectification, noise_px, look)
        return inliers, int(np.count_nonzero(views.usable & ~inliers.usable))

    def _demo_looks(self, seen: Snapshot, like: Snapshot, changes: Mapping[str, Any]) -> tuple[Images, ...]:
        """All looks at the demonstrator since it last moved: those before, and this one if it is a new one."""
        begins = not like.demo_looks or "theta_demo" in changes or "settings" in changes
        if not begins and "look" not in changes:
            return like.demo_looks
        if begins or not same_demonstrator(seen, like):
            return (self.observer.demo(seen.settings, seen.theta_demo, None),)
        look = self.observer.demo(seen.settings, seen.theta_demo, seen.look)
        last = like.demo_looks[-1]
        if look is last or all(map(np.array_equal, look, last)):  # without noise, by whichever session's eyes
            return like.demo_looks
        first, *later = like.demo_looks
        return (first, *later[2 - MAX_DEMO_LOOKS :], look)

    def look(self, past: Past, **changes: Any) -> Snapshot:
        """Look again with the arm held still, with other fields as in `changes`. Retarget the servo if it has to be."""
        now = past[-1]
        return self._retargeted(now, self.seen(past, now.theta, now, look=now.look + 1, **changes))

    def _retargeted(self, now: Snapshot, after: Snapshot) -> Snapshot:
        """Retarget the servo if the demonstrator has moved by itself, and drop the rest of a long motion."""
        if after.servo_state is None or after.transfer is None or same_demonstrator(now, after):
            return after
        return self.retargeted(after).with_fields(target=None)

    def retargeted(self, now: Snapshot) -> Snapshot:
        """Tell a servo that has begun that E has changed by itself."""
        if now.servo_state is None:
            return now
        return now.with_fields(servo_state=now.servo.retarget(now.servo_state, self.observation(now)))

    def observation(self, now: Snapshot) -> Observation:
        """Select what a servo is given of a snapshot: image points and displacements, no posture."""
        noise_px, start = self.observer.image_noise_std(now.settings), now.settings.start_rad
        demo_seen, seen = now.views.visible[:, :2], now.views.visible[:, 2:]
        average, demo_noise_px = demonstrator_average(now, noise_px, self.observer.fixed_noise_px())
        known = now.calibration if now.calibration is not None and len(now.calibration) >= MIN_POSTURES else None
        return Observation(
            own=now.views.own if now.views.complete else np.where(repeat_xy(seen), now.views.own, np.nan),
            seen=seen,
            demo=np.where(repeat_xy(demo_seen), now.views.demo, np.nan),
            demo_average=average,
            demo_noise_px=demo_noise_px,
            E=now.E,
            displacement=now.commanded - start,
            lower=self.workspace[0] - start,
            upper=self.workspace[1] - start,
            motion=now.motion,
            residual=now.e,
            noise_px=noise_px if known is None else max(noise_px, known.noise_px),
            matched=now.views.matched,
            calibration=() if known is None else known.seen_from(self.embodiment.lower - start),
            rectification=now.rectification,
            max_step=now.settings.max_step,
            seed=now.settings.seed,
        )

    def predicted_residuals(self, past: Past, now: Snapshot, mirror_columns: bool = True) -> PredictedResiduals:
        """Make the function that a servo calls for the residuals of images that it predicts.

        past: up to the present one; now: gives the demonstrator's images; mirror_columns: as of `PredictedResiduals`.
        It maps own images (..., N, 4) px to residuals (..., n, C) px.
        """
        return PredictedResiduals(
            now.views,
            now.method,
            now.rectification,
            noise_px=self.observer.image_noise_std(now.settings),
            velocity=target_velocity([one.views for one in past[-VELOCITY_LOOKS:]]),
            converged=now.converged_transfer,
            mirror_columns=mirror_columns,
        )


def demonstrator_average(now: Snapshot, noise_px: float, fixed_px: float) -> tuple[Floats | None, float | None]:
    """Average all looks at the demonstrator since it last moved; noise_px, fixed_px: as of `average_looks`.

    Returns its points in [l, r], (N, 4) px, in the order of the views, NaN where no look shows a point, or it is an
    outlier; and the standard deviation of a coordinate [px]. Both are None if there is one look only.
    """
    if len(now.demo_looks) < 2:
        return None, None
    (points, visible), noise_px = average_looks(now.demo_looks, noise_px, fixed_px)
    first, average = _in_order(now, *now.demo_looks[0]), _in_order(now, points, visible)
    rejected = first.visible[:, :2] & ~now.views.visible[:, :2]
    return np.where(repeat_xy(average.visible[:, :2] & ~rejected), average.demo, np.nan), noise_px


def _in_order(now: Snapshot, demo: Floats, visible: NDArray[np.bool_]) -> FourViews:
    """Put the demonstrator's points, (N, 4) px, in the order of the views. visible: (N, 2)."""
    views = FourViews(demo, now.views.own, np.concatenate([visible, now.views.visible[:, 2:]], -1))
    if not now.settings.matched and now.views.matched and now.says.names is not None:
        views = views.named(now.says.names)
    return views.permuted(now.exchanged)


def average_looks(looks: Sequence[Images], noise_px: float, fixed_px: float) -> tuple[Images, float]:
    """Average looks at a body that stands still, and estimate the noise of the mean [px] by what the looks differ.

    noise_px: of a coordinate in a look, as of the own images; fixed_px: the part of it that no averaging reduces.
    Returns (points (N, 4) px, visible (N, 2)) and px. With fewer than MIN_FRAMES looks, which outvote no outlier, or
    equal ones, which show no noise, it returns the first look that shows most points.
    """
    fullest = max(looks, key=lambda look: int(np.count_nonzero(look[1])))
    if len(looks) < MIN_FRAMES:
        return fullest, noise_px
    points, visible = np.array([one for one, _ in looks]), np.array([seen for _, seen in looks])
    measured = noise_std(points, visible)
    if measured == 0:
        return fullest, noise_px
    differences = 2 * int(np.count_nonzero(visible[1:] & visible[:-1]))
    squares = OWN_NOISE_COUNTS * noise_px**2 + differences * measured**2
    single = np.sqrt(squares / (OWN_NOISE_COUNTS + differences))
    return average_frames(points, visible), float(np.hypot(single / np.sqrt(len(looks)), fixed_px))


def _at_rest(now: Snapshot, state: Any) -> Snapshot:
    """Record that the servo, which returned this state, asks for no motion."""
    status = ServoState.of(state).status_at_rest
    converged_transfer = now.transfer if status.is_at_minimum else now.converged_transfer
    return now.with_fields(servo_state=state, status=status, converged_transfer=converged_transfer)


def same_demonstrator(one: Snapshot, other: Snapshot) -> bool:
    """Whether the demonstrator's images are equal in both."""
    demo = other.views.demo
    return one.views.demo is demo or np.array_equal(one.views.demo, demo, equal_nan=True)


def _renames(state: Any, now: Snapshot) -> bool:
    """Whether a servo's answer has other names for the demonstrator's points: look again, in another order."""
    names, here = ServoState.of(state).names, now.says.names
    if names is None or now.settings.matched:
        return False
    return not now.views.matched or here is None or not np.array_equal(names, here)


def _rectification(past: Past, views: FourViews, settings: Settings) -> Rectification | None:
    """Rectify the images where their matches show that the cameras are not parallel; None where they are."""
    if settings.rectify == "off":
        return None
    last, looks = past[-1], [one.views for one in past[-MAX_LOOKS:]]
    return update_rectification(views, looks, last.rectification, last.motion, refresh=last.settings != settings)

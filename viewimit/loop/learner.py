"""The loop of the paper: a learner looks, asks its servo, and moves.

The method is `Learner.step`, in the order of the paper:

    posture → body points in 3-D → four views → transfer → recovered points → residual e → E → servo → next posture

Every pass leaves one immutable `Snapshot`. Panels, plots, exports and tests all read this record.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..estimation.outliers import reject_outliers
from ..estimation.prediction import VELOCITY_LOOKS, target_velocity
from ..estimation.rectification import MAX_LOOKS, update_rectification
from ..estimation.residuals import ResidualFunction
from ..estimation.views import FourViews
from ..geometry.rectification import Rectification
from ..servo import Observation, ServoState
from ..servo.observation import repeat_xy
from ..servo.status import ServoStatus
from . import rehearsal
from .demonstrator import MAX_DEMO_LOOKS, Images
from .embodiment import Embodiment, Observer, waypoints
from .history import MAX_HISTORY, RECENT, History
from .script import Log, Looks, Steps
from .self_calibration import MIN_POSTURES
from .settings import Settings, level_outside
from .snapshot import Limits, RunResult, Snapshot

PATIENCE = 100  # looks in a row with too few points, after which a run is given up


class Learner:
    """A learner that imitates a demonstrator, and the history of its motions.

    Attributes
    ----------
    embodiment : Embodiment
        The arm, and its view of the demonstrator.
    observer : Observer
        How both bodies are seen.
    workspace : tuple of (m,) arrays
        Lowest and highest angles that the arm may be sent to [rad].
    history : History
        All snapshots, by motion.
    log : Log
        The actions so far.
    """

    embodiment: Embodiment
    observer: Observer
    workspace: Limits
    history: History
    log: Log

    @property
    def snapshot(self) -> Snapshot:
        """The snapshot that the cursor is on: the present, or a past one."""
        return self.history.present

    @property
    def cursor(self) -> int:
        """Number of motions before the snapshot shown."""
        return self.history.cursor

    @property
    def settings(self) -> Settings:
        """The settings of the snapshot shown."""
        return self.snapshot.settings

    def run(
        self,
        max_motions: int = MAX_HISTORY,
        patience: int = PATIENCE,
        each: Callable[[Snapshot], None] = lambda snapshot: None,
    ) -> RunResult:
        """Step until the servo rests, or a limit is reached.

        Parameters
        ----------
        max_motions : int
            Stop at this motion of the session.
        patience : int
            Stop after this number of looks in a row with too few points.
        each : callable
            Called with the snapshot after each motion.

        Returns
        -------
        RunResult
            Why the run ended, and how far the arm went.
        """
        failed_looks, motions, travel, joint_travel = 0, 0, 0.0, np.zeros_like(self.snapshot.moved)
        while self.snapshot.motion < max_motions and failed_looks < patience:
            if self.step():
                moved = np.abs(self.snapshot.moved)
                failed_looks, motions, travel = 0, motions + 1, travel + float(moved.max())
                joint_travel += moved
                each(self.snapshot)
            elif self.snapshot.status == ServoStatus.TOO_FEW_POINTS:
                failed_looks += 1
            else:
                break
        return RunResult(motions, travel, joint_travel, self.snapshot, self._joint_numbers)

    @property
    def _joint_numbers(self) -> tuple[int, ...]:
        """As `RunResult.joints`."""
        return ()

    def step(self) -> bool:
        """Make one pass of the loop: ask the servo, move the arm, look.

        A motion longer than `Settings.max_step_deg` takes several passes; the servo is asked again after the last. A
        step from a past snapshot drops the history after it.

        Returns
        -------
        bool
            False if the arm did not move: the servo rests, or too few points are visible.
        """
        now = self.snapshot
        if now.pending_postures is not None and now.is_rehearsing:
            after = self._moved(now, now.pending_postures[0], probe=True)
            return self._advance(now, rehearsal.record(after, self.embodiment.lower))
        too_few_points = now.transfer is None and now.target is None and not now.awaits_names
        if too_few_points:
            now = self._look_for_points()
            if now.transfer is None and not self._servo_can_go_on(now):
                return self._stay(now)
        if now.motion >= MAX_HISTORY:
            return self._stay(now.with_fields(status=ServoStatus.MAX_MOTIONS))
        if now.target is not None:
            status = now.says.status_or(ServoStatus.MOVING)
            return self._advance(now, self._moved(now, now.target, probe=now.probe, status=status))
        state, displacement = self._ask(now)  # residual e, E → servo
        while self._renames(state, now):
            now = self._seen(now.theta, now, servo_state=state)
            if now.transfer is None:
                return self._stay(now)
            state, displacement = self._ask(now)
        read = ServoState.of(state)
        if read.exchanged != now.exchanged:
            now = self._seen(now.theta, now, servo_state=state)
        if not displacement.any():
            return self._stay(now.at_rest(state))
        target = now.commanded + displacement  # → next posture
        changes = {"probe": read.probe, "status": read.status_or(ServoStatus.MOVING), "servo_state": state}
        return self._advance(now, self._moved(now, target, **changes), looked=too_few_points)

    def _ask(self, now: Snapshot) -> tuple[Any, NDArray[np.float64]]:
        """Ask the servo for its next state and motion, (m,) rad."""
        servo, seen = now.servo, self.observation(now)
        residuals = self.predicted_residuals(now, servo.mirror_columns)
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

    def _renames(self, state: Any, now: Snapshot) -> bool:
        """Whether a servo's answer has other names for the demonstrator's points: look again, in another order."""
        names, here = ServoState.of(state).names, now.says.names
        if names is None or now.settings.matched:
            return False
        return not now.views.matched or here is None or not np.array_equal(names, here)

    def _moved(self, now: Snapshot, target: NDArray[np.float64], **changes: Any) -> Snapshot:
        """Drive the arm towards the target, (m,) rad, within its limits, and look. `changes` are other new fields."""
        target = target.clip(*self.workspace)
        commanded, *later = waypoints(now.commanded, target, now.settings.max_step)
        theta = self.embodiment.drive(now.settings, now.theta, now.commanded, commanded)
        n_looks, lag = self.observer.wait_for_motion(now, theta)
        after = self._seen(
            theta, now, motion=now.motion + 1, look=now.look + 1 + n_looks, lag=lag, commanded=commanded,
            moved=theta - now.theta, target=target if later else None, **changes,
        )  # fmt: skip
        return self._retargeted(now, after)

    def _seen(self, theta: NDArray[np.float64], like: Snapshot, **changes: Any) -> Snapshot:
        """Look with the arm at theta, (m,) rad, and evaluate E. Other fields are those of `like`, or `changes`."""
        # posture → body points in 3-D → four views l, r, L, R
        views, n_rejected = self._four_views(theta, like, **changes)
        rectification = self._rectification(views, changes.get("settings", like.settings))
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

    def _demo_looks(self, seen: Snapshot, like: Snapshot, changes: Mapping[str, Any]) -> tuple[Images, ...]:
        """All looks at the demonstrator since it last moved: those before, and this one if it is a new one."""
        begins = not like.demo_looks or "theta_demo" in changes or "settings" in changes
        if not begins and "look" not in changes:
            return like.demo_looks
        if begins or not seen.shows_same_demonstrator(like):
            return (self.observer.demonstrator_look(seen.settings, seen.theta_demo, None),)
        look = self.observer.demonstrator_look(seen.settings, seen.theta_demo, seen.look)
        last = like.demo_looks[-1]
        if look is last or all(map(np.array_equal, look, last)):  # without noise, by whichever session's eyes
            return like.demo_looks
        first, *later = like.demo_looks
        return (first, *later[2 - MAX_DEMO_LOOKS :], look)

    def _four_views(self, theta: NDArray[np.float64], like: Snapshot, **changes: Any) -> tuple[FourViews, int]:
        """The image points of both bodies without outliers, and how many points became unusable by that.

        The servo's names of points that come without are applied, and its correction of swapped points.
        """
        settings, look = changes.get("settings", like.settings), changes.get("look", like.look)
        views = self.observer.four_views(settings, theta, changes.get("theta_demo", like.theta_demo), look)
        read = ServoState.of(changes.get("servo_state", like.servo_state))
        if not settings.matched:
            views = replace(views, matched=False) if read.names is None else views.named(read.names)
        views = views.permuted(read.exchanged)
        past, last = self.history.recent(MAX_LOOKS), self.history.present
        noise_px = self.observer.image_noise_std(settings)
        inliers = reject_outliers(views, [one.views for one in past], last.rectification, noise_px, look)
        return inliers, int(np.count_nonzero(views.usable & ~inliers.usable))

    def _rectification(self, views: FourViews, settings: Settings) -> Rectification | None:
        """Rectify the images where their matches show that the cameras are not parallel; None where they are."""
        if settings.rectify == "off":
            return None
        past, last = self.history.recent(MAX_LOOKS), self.history.present
        refresh, past_views = last.settings != settings, [one.views for one in past]
        return update_rectification(views, past_views, last.rectification, last.motion, refresh=refresh)

    def _stay(self, snapshot: Snapshot) -> bool:
        """Record a step without a motion."""
        self.log.note(snapshot.motion, Steps(1))
        self.history.replace(snapshot)
        return False

    def _advance(self, now: Snapshot, after: Snapshot, looked: bool = False) -> bool:
        """Record a motion from `now`. looked: the step began with another look."""
        self.log.note_on(now.motion, looked)
        self.history.append(after)
        return True

    def _look_for_points(self) -> Snapshot:
        """Look again with the arm held still, because too few points were visible."""
        now = self.snapshot
        again = self._retargeted(now, self._seen(now.theta, now, look=now.look + 1, status=now.awake_status))
        self.history.replace(again)
        return again

    def _servo_can_go_on(self, now: Snapshot) -> bool:
        """Whether the servo can lead on without own points: it predicts images, and the demonstrator is visible."""
        return now.servo_state is not None and now.servo.predicts and now.shows_demonstrator

    def _retargeted(self, now: Snapshot, after: Snapshot) -> Snapshot:
        """Retarget the servo if the demonstrator has moved by itself, and drop the rest of a long motion."""
        if after.servo_state is None or after.transfer is None or now.shows_same_demonstrator(after):
            return after
        state = after.servo.retarget(after.servo_state, self.observation(after))
        return after.with_fields(servo_state=state, target=None)

    def observe(self, theta: NDArray[np.float64], like: Snapshot, **changes: Any) -> Snapshot:
        """Evaluate what the learner would see with its arm at theta. Nothing moves, and nothing is recorded.

        Parameters
        ----------
        theta : (m,) array
            Posture of the learner [rad].
        like : Snapshot
            Gives all other fields.
        **changes
            Fields that differ from those of `like`.

        Returns
        -------
        Snapshot
            Views, transfer and E at theta.

        Raises
        ------
        ValueError
            For eyes of your own at another posture than the present one: they see the arm only where it is.
        """
        if not self.observer.sees_any_posture and not np.array_equal(theta, self.snapshot.theta):
            raise ValueError("eyes of your own see the arm only where it stands: let it move there, and look()")
        return self._seen(theta, like, **changes)

    def look(self) -> bool:
        """Look again without a motion. A servo at rest resumes if the demonstrator has moved.

        A real demonstrator moves by itself; in a scene `pose` moves it.

        Returns
        -------
        bool
            Whether the demonstrator has moved.
        """
        now = self.snapshot
        after = self._retargeted(now, self._seen(now.theta, now, look=now.look + 1))
        moved = not now.shows_same_demonstrator(after)
        self.log.note(now.motion, Looks(1))
        wakes = after.transfer is not None and (moved or now.transfer is None)
        self.history.replace(after.with_fields(status=after.awake_status) if wakes else after)
        return moved

    def observation(self, now: Snapshot) -> Observation:
        """Select what a servo is given of a snapshot.

        Parameters
        ----------
        now : Snapshot
            Of this session.

        Returns
        -------
        Observation
            Image points and displacements, no posture.
        """
        noise_px, start = self.observer.image_noise_std(now.settings), now.settings.start_rad
        demo_seen, seen = now.views.visible[:, :2], now.views.visible[:, 2:]
        average, demo_noise_px = now.demonstrator_average(noise_px, self.observer.fixed_noise_px())
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
            n_visible=now.shown,
            n_partial=now.half_shown,
            n_rig_hypotheses=0 if now.rectification is None else len(now.rectification.perturbed),
            rectification=now.rectification,
            max_step=now.settings.max_step,
            max_restarts=now.settings.restarts,
            seed=now.settings.seed,
        )

    def predicted_residuals(self, now: Snapshot, mirror_columns: bool = True) -> ResidualFunction:
        """Make the function that a servo calls for the residuals of images that it predicts.

        Parameters
        ----------
        now : Snapshot
            Gives the demonstrator's images.
        mirror_columns : bool
            As of `PredictedResiduals`.

        Returns
        -------
        ResidualFunction
            Own images (..., N, 4) px → residuals (..., n, C) px.
        """
        recent, noise_px = self.history.recent(RECENT), self.observer.image_noise_std(now.settings)
        velocity = target_velocity([one.views for one in recent[-VELOCITY_LOOKS:]])
        return now.predicted_residuals(velocity, noise_px, recent, mirror_columns)

"""The loop of the paper. A session can be posed, stepped, undone and scrubbed. It knows no page and no file.

The method is `Session.step`, in the order of the paper:

    posture → body points in 3-D → four views → transfer → recovered points → residual e → E → servo → next posture

Every pass leaves one immutable `Snapshot`. Panels, plots, exports and tests all read this record.
"""

import copy
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..estimation.outliers import reject_outliers
from ..estimation.prediction import VELOCITY_LOOKS, target_velocity
from ..estimation.rectification import MAX_LOOKS, update_rectification
from ..estimation.residuals import ResidualFunction
from ..estimation.transfers import TransferFunction, TransferMethod, transfer_method
from ..estimation.views import FourViews
from ..geometry.rectification import Rectification
from ..sensing.renamed import current_settings, level_outside
from ..servo import Observation, Servo, ServoMethod, servo_method
from ..servo.observation import Visit, repeat_xy
from ..servo.status import ServoStatus
from ..simulation.eyes import SimulatedEyes, open_eyes
from ..simulation.scene import Scene
from ..simulation.world import World
from .embodiment import (
    Arm,
    Embodiment,
    Eyes,
    Observer,
    Opener,
    require_in_workspace,
    round_to_degrees,
    to_degrees,
    waypoints,
)
from .history import MAX_HISTORY, RECENT, History
from .real_robot import RealRobotOpener
from .script import (
    Action,
    Begin,
    Calibrate,
    ChangeSettings,
    ClearCalibration,
    Log,
    Looks,
    MoveDemonstrator,
    Script,
    Steps,
)
from .self_calibration import MIN_POSTURES, SelfCalibration, calibration_postures
from .settings import OWN, Settings, convert_fields, warn_of_radians
from .simulated_robot import OpenEyes, SimulatedRobot, SimulatedRobotOpener
from .snapshot import RunResult, Snapshot, exchanged, predicted_residuals, probes, require_given, status_of

RESTARTING_FIELDS = (  # a change of the body, of the sensor or of the arm's limits starts the session anew
    "scene", "robot", "joints", "points", "body_points", "start_deg", "undistort", "sensor", "delay", "workspace_deg",
)  # fmt: skip
PATIENCE = 100  # looks in a row with too few points, after which a run is given up
CustomTransfer = str | TransferMethod | TransferFunction
CustomServo = str | ServoMethod | Servo
NO_VIEWS = FourViews(np.empty((0, 4)), np.empty((0, 4)), np.empty((0, 4), bool))


class Session:
    """A learner that imitates a demonstrator, and the history of its motions.

    A session is not thread-safe: one thread steps it.

    Parameters
    ----------
    settings : Settings, optional
        All that the run depends on. `Settings()`, the best method, by default.
    open_eyes : callable, optional
        open_eyes(sensor, scene, points) makes the simulated cameras and arms.
    dense : int, optional
        How many of the last motions the history keeps completely. All by default.
    transfer, servo : optional
        In place of those that the settings name: another name, or one of your own. A transfer is a function of
        `FourViews` or a `TransferMethod`; a servo is an object with `start` and `step` (`Servo`). The settings then
        name it "own", and no link or file can hold it.

    Attributes
    ----------
    history : History
        All snapshots, by motion.
    workspace : tuple of NDArray
        Lowest and highest angles that the arm may be sent to, (m,) rad each.
    observer, embodiment, log
        How the bodies are seen, the arm, and the actions so far (`Session.script`).

    Raises
    ------
    ValueError
        For settings that contradict the scene.
    TypeError
        For an object that is no settings, transfer or servo.
    """

    embodiment: Embodiment
    observer: Observer
    workspace: tuple[NDArray[np.float64], NDArray[np.float64]]
    history: History
    log: Log

    def __init__(
        self,
        settings: Settings | None = None,
        *,
        open_eyes: OpenEyes = open_eyes,
        dense: int | None = None,
        transfer: CustomTransfer | None = None,
        servo: CustomServo | None = None,
    ):
        if not isinstance(settings, Settings | None):
            raise TypeError(f"settings must be Settings(…), got {settings!r}")
        self._set_up(SimulatedRobotOpener(open_eyes), settings or Settings(), dense, transfer, servo)

    @classmethod
    def of(
        cls,
        arm: Arm,
        eyes: Eyes,
        *,
        name: str = "own",
        dense: int | None = None,
        transfer: CustomTransfer | None = None,
        servo: CustomServo | None = None,
        **changes: Any,
    ) -> "Session":
        """Put the loop on a robot and cameras of your own. The arm goes to its start at once.

        Parameters
        ----------
        arm : Arm
        eyes : Eyes
        name : str
            Of the arm. A calibration is only used with an arm of the same name.
        dense, transfer, servo
            As of `Session`.
        **changes
            Fields of `Settings` that differ from `Settings.best()`: frames (images averaged at each posture), rectify,
            start_deg (in place of the arm's start), seed, max_step_deg, workspace_deg and restarts. The limits hold for
            every motion, also for undo and reset. Only the first motion, to the start, may be of any length, because
            the arm's posture before it is unknown.

        Raises
        ------
        ValueError
            For settings that only a scene has, and for impossible limits, postures or images.
        TypeError
            For an arm or eyes that lack a member.
        """
        session = cls.__new__(cls)
        session._set_up(RealRobotOpener(arm, eyes, name), Settings.best(**changes), dense, transfer, servo)
        return session

    def _set_up(
        self,
        opener: Opener,
        settings: Settings,
        dense: int | None,
        transfer: CustomTransfer | None,
        servo: CustomServo | None,
    ) -> None:
        self._open, self._dense = opener, dense
        given = {"transfer": transfer, "servo": servo}
        names = {field: one if isinstance(one, str) else OWN for field, one in given.items() if one is not None}
        self._custom = CustomMethods(
            None if isinstance(transfer, str | None) else transfer_method(transfer),
            None if isinstance(servo, str | None) else servo_method(servo),
        )
        self.begin(msgspec.structs.replace(settings, **names))

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

    @property
    def script(self) -> Script:
        """The actions that lead to the snapshot shown. Raises ValueError where they are not known."""
        return self.log.script(self.cursor)

    @property
    def eyes(self) -> SimulatedEyes:
        """The simulated cameras and arms. Raises ValueError for an arm and eyes of your own."""
        if not isinstance(self.embodiment, SimulatedRobot):
            raise ValueError("an arm and eyes of your own have no scene, no world and no truth")
        return self.embodiment.eyes

    @property
    def world(self) -> World:
        """The simulated world: the ground truth, for viewers only."""
        return self.eyes.world

    @property
    def scene(self) -> Scene:
        """The scene of the simulated world."""
        return self.world.scene

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
            Stop after so many looks in a row with too few points.
        each : callable
            Called with the snapshot after each motion.
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
        return RunResult(motions, travel, joint_travel, self.snapshot)

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
        if now.is_rehearsing:
            return self._step_calibration(now)
        too_few_points = now.transfer is None and now.target is None
        if too_few_points:
            now = self._look_for_points()
            if now.transfer is None and not self._servo_can_go_on(now):
                return self._stay(now)
        if now.motion >= MAX_HISTORY:
            return self._stay(now.with_fields(status=ServoStatus.MAX_MOTIONS))
        if now.target is not None:
            status = status_of(now.servo_state, ServoStatus.MOVING)
            return self._advance(now, self._moved(now, now.target, probe=now.probe, status=status))
        state, displacement = self._ask_servo(now)  # residual e, E → servo
        if exchanged(state) != exchanged(now.servo_state):
            now = self._seen(now.theta, now, servo_state=state)
        if not displacement.any():
            return self._stay(_at_rest(now, state))
        target = now.commanded + displacement  # → next posture
        changes = {"probe": probes(state), "status": status_of(state, ServoStatus.MOVING), "servo_state": state}
        return self._advance(now, self._moved(now, target, **changes), looked=too_few_points)

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
        seen = like.with_fields(theta=theta, views=views, n_rejected=n_rejected, rectification=rectification, **changes)
        if seen.transfer is None:  # → transfer: fundamental matrices
            return seen.with_fields(E=np.nan, status=ServoStatus.TOO_FEW_POINTS)
        E = float(seen.transfer.conflict(views.used))  # → recovered points → residual e → E
        if np.isnan(E):
            raise ValueError(f"the transfer {seen.method.title!r} maps visible points to NaN")
        return seen.with_fields(E=E)

    def _four_views(self, theta: NDArray[np.float64], like: Snapshot, **changes: Any) -> tuple[FourViews, int]:
        """The image points of both bodies without outliers, and how many points became unusable by that.

        The servo's correction of swapped points is applied.
        """
        settings, look = changes.get("settings", like.settings), changes.get("look", like.look)
        views = self.observer.four_views(settings, theta, changes.get("theta_demo", like.theta_demo), look)
        views = views.permuted(exchanged(changes.get("servo_state", like.servo_state)))
        past, last = self.history.recent(MAX_LOOKS), self.history.present
        noise_px = self.observer.image_noise_std(settings)
        inliers = reject_outliers(views, [one.views for one in past], last.rectification, noise_px, look)
        return inliers, int(np.count_nonzero(views.usable & ~inliers.usable))

    def _rectification(self, views: FourViews, settings: Settings) -> Rectification | None:
        """Rectify the images where their matches show that the cameras are not parallel; None where they are."""
        if settings.rectify == "off":
            return None
        past, last = self.history.recent(MAX_LOOKS), self.history.present
        refresh = last.settings != settings
        return update_rectification(
            views, [one.views for one in past], last.rectification, last.motion, refresh=refresh
        )

    def _ask_servo(self, now: Snapshot) -> tuple[Any, NDArray[np.float64]]:
        """The servo's next state, and the displacement that it asks for, (m,) rad."""
        servo, seen = now.servo, self.observation(now)
        state = servo.start(seen) if now.servo_state is None else now.servo_state
        answer = servo.step(state, seen, self.predicted_residuals(now, servo.mirror_columns))
        if not (isinstance(answer, tuple) and len(answer) == 2):
            raise TypeError(f"the servo {servo.title!r} must return its state and its motion, (m,) rad, got {answer!r}")
        if answer[0] is None and state is not None:
            raise TypeError(f"the servo {servo.title!r} returned None as its next state; only stateless servos may")
        state, displacement = answer[0], np.asarray(answer[1], float)
        if displacement.shape != now.theta.shape or not np.isfinite(displacement).all():
            expected = f"{len(now.theta)} finite angles in rad"
            raise ValueError(f"the servo {servo.title!r} must return its state and {expected}, got {displacement}")
        target = now.commanded + displacement
        if (np.abs(target - target.clip(*self.workspace)) >= 2 * np.pi).any():
            asked = f"the servo {servo.title!r} asks for a motion of {displacement} rad"
            warnings.warn(f"{asked}, a turn or more beyond the limits: are these degrees?", stacklevel=level_outside())
        return state, displacement

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
        again = self._retargeted(now, self._seen(now.theta, now, look=now.look + 1, status=_awake(now)))
        self.history.replace(again)
        return again

    def _servo_can_go_on(self, now: Snapshot) -> bool:
        """Whether the servo can lead on without own points: it predicts images, and the demonstrator is visible."""
        return now.servo_state is not None and now.servo.predicts and now.shows_demonstrator

    def _retargeted(self, now: Snapshot, after: Snapshot) -> Snapshot:
        """Tell the servo if the demonstrator has moved by itself, and drop the rest of a long motion."""
        if after.servo_state is None or after.transfer is None or _same_demonstrator(now, after):
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
            Gives all other fields, except `changes`.

        Raises
        ------
        ValueError
            For eyes of your own at another posture than the present one: they see the arm only where it is.
        """
        if not self.observer.sees_any_posture and not np.array_equal(theta, self.snapshot.theta):
            raise ValueError("eyes of your own see the arm only where it stands: let it move there, and look()")
        return self._seen(theta, like, **changes)

    def look(self) -> bool:
        """Look again without a motion. Return whether the demonstrator has moved; a servo at rest then resumes.

        A real demonstrator moves by itself; in a scene `pose` moves it.
        """
        now = self.snapshot
        after = self._retargeted(now, self._seen(now.theta, now, look=now.look + 1))
        moved = not _same_demonstrator(now, after)
        self.log.note(now.motion, Looks(1))
        wakes = after.transfer is not None and (moved or now.transfer is None)
        self.history.replace(after.with_fields(status=_awake(after)) if wakes else after)
        return moved

    def observation(self, now: Snapshot) -> Observation:
        """The image points and displacements that a servo is given of a snapshot."""
        start, seen = now.settings.start_rad, now.views.visible[:, 2:]
        known = now.calibration if now.calibration is not None and len(now.calibration) >= MIN_POSTURES else None
        noise_px = self.observer.image_noise_std(now.settings)
        return Observation(
            own=now.views.own if now.views.complete else np.where(repeat_xy(seen), now.views.own, np.nan),
            seen=seen,
            E=now.E,
            displacement=now.commanded - start,
            lower=self.workspace[0] - start,
            upper=self.workspace[1] - start,
            motion=now.motion,
            noise_px=noise_px if known is None else max(noise_px, known.noise_px),
            calibration=() if known is None else known.seen_from(self.embodiment.lower - start),
            n_visible=now.shown,
            n_partial=now.half_shown,
            n_rig_hypotheses=0 if now.rectification is None else len(now.rectification.perturbed),
            rectification=now.rectification,
            max_step=now.settings.max_step,
            max_restarts=now.settings.restarts,
        )

    def predicted_residuals(self, now: Snapshot, mirror_columns: bool = True) -> ResidualFunction:
        """The residuals of images that a servo predicts, against the demonstrator of the present snapshot."""
        recent, noise_px = self.history.recent(RECENT), self.observer.image_noise_std(now.settings)
        velocity = target_velocity([one.views for one in recent[-VELOCITY_LOOKS:]])
        return predicted_residuals(now, velocity, noise_px, recent, mirror_columns)

    def change(self, **fields: Any) -> None:
        """Change fields of the settings from here on.

        A new scene, layout, start or workspace starts the session anew. Any other change evaluates the present again.
        A new servo starts to learn where the arm is. Raises ValueError, with the session as it was.
        """
        fields = current_settings(fields)
        settings = msgspec.structs.replace(self.settings, **fields)
        self._custom.require(settings)
        if any(getattr(settings, name) != getattr(self.settings, name) for name in RESTARTING_FIELDS):
            self.begin(settings)
            return
        changed = {name: getattr(settings, name) for name in fields}
        now = self.snapshot.with_fields(converged_transfer=None)
        if settings.servo != now.settings.servo:
            now = now.with_fields(servo_state=None)
        warn_of_radians(settings)
        self._pose(self.embodiment.demonstrator(settings), settings, now, ChangeSettings(changed))

    def pose(self, theta_demo: ArrayLike) -> None:
        """Move the demonstrator to theta_demo, (m,) rad, and look again.

        Raises ValueError, with the session as it was, for a posture outside its limits.
        """
        theta_demo = self.embodiment.require_posture(theta_demo, "demonstrator's")
        self._pose(theta_demo, self.settings, self.snapshot, MoveDemonstrator(tuple(theta_demo.tolist())))

    def _pose(self, theta_demo: NDArray[np.float64], settings: Settings, now: Snapshot, action: Action) -> None:
        """Go on from `now` with other settings and the demonstrator at theta_demo, (m,) rad."""
        if np.isfinite(theta_demo).all():
            theta_demo = round_to_degrees(theta_demo, self.embodiment.lower, self.embodiment.upper)
            settings = msgspec.structs.replace(settings, demonstrator_deg=to_degrees(theta_demo))
        theta_demo = self.embodiment.settle_demonstrator(theta_demo)
        now = self._seen(now.theta, now, settings=settings, theta_demo=theta_demo, status=_awake(now), target=None)
        if now.servo_state is not None:
            state = now.servo.retarget(now.servo_state, self.observation(now))
            now = now.with_fields(servo_state=state)
        self.log.note(now.motion, action)
        self.history.replace(now)

    def calibrate(self, count: int, seed: int, within_deg: float | None = None) -> SelfCalibration:
        """Visit `calibration_postures` now, without a demonstrator, and return what was seen of the own body."""
        self.begin_calibration(self.calibration_postures(count, seed, within_deg))
        while self.snapshot.is_rehearsing:
            self.step()
        assert self.snapshot.calibration is not None
        return self.snapshot.calibration

    def calibration_postures(self, count: int, seed: int, within_deg: float | None = None) -> NDArray[np.float64]:
        """Draw postures, (count, m) rad, for `begin_calibration` from the workspace.

        within_deg: keep each joint within this distance of where the arm is now. Raises ValueError for fewer than
        MIN_POSTURES.
        """
        low, high = self.workspace
        if within_deg is not None:
            here, reach = self.snapshot.commanded, np.radians(within_deg)
            low, high = np.maximum(low, here - reach), np.minimum(high, here + reach)
        return calibration_postures(low, high, count, np.random.default_rng(seed))

    def begin_calibration(self, postures: NDArray[np.float64]) -> None:
        """Visit these postures, (K, m) rad, in the next steps, and record what is seen of the own body; then imitate.

        The servo starts afresh, and an earlier calibration is dropped. Raises ValueError, with the session as it was,
        for a posture outside the limits, or fewer than MIN_POSTURES.
        """
        if len(postures) < MIN_POSTURES:
            raise ValueError(f"needs {MIN_POSTURES} postures or more, got {len(postures)}")
        possible = [self.embodiment.require_posture(theta, "the rehearsed") for theta in postures]
        pending = np.array([require_in_workspace(theta, *self.workspace, "the rehearsed") for theta in possible])
        settings, body = self.settings, self.embodiment.body(self.settings)
        calibration = SelfCalibration(body, settings.scene_title, self.observer.image_noise_std(settings))
        fields = {"calibration": calibration, "pending_postures": pending, "servo_state": None, "target": None}
        self.log.note(self.cursor, Calibrate(tuple(map(tuple, pending.tolist()))))
        self.history.replace(self.snapshot.with_fields(status=ServoStatus.REHEARSING, **fields))

    def _step_calibration(self, now: Snapshot) -> bool:
        """Move to the next posture of the calibration, and record what is seen there."""
        assert now.pending_postures is not None and now.calibration is not None
        pending, calibration = now.pending_postures, now.calibration
        after = self._moved(now, pending[0], probe=True)
        if after.target is None:  # it has arrived
            displacement = after.commanded - self.embodiment.lower
            calibration = calibration.with_visit(Visit.of(displacement, after.views.own, after.views.visible[:, 2:]))
            pending = pending[1:]
        status = ServoStatus.REHEARSING if len(pending) else _awake(after)
        after = after.with_fields(calibration=calibration, pending_postures=pending, status=status)
        return self._advance(now, after)

    def use_calibration(self, calibration: SelfCalibration | None) -> None:
        """Imitate with a calibration that was recorded elsewhere, or with none. The servo starts afresh.

        Raises ValueError, with the session as it was, for a calibration of another body.
        """
        if calibration is not None:
            self.embodiment.body(self.settings).require(calibration.body)
        now = self.snapshot
        if calibration is None:
            self.log.note(now.motion, ClearCalibration())
        else:
            self.log.invalidate(now.motion)
        fields = {"calibration": calibration, "pending_postures": None, "servo_state": None, "target": None}
        self.history.replace(now.with_fields(status=_awake(now), **fields))

    def play(self, script: Script) -> None:
        """Begin anew with the script's settings and repeat its actions. Raises ValueError for an impossible one."""
        self.begin(script.settings)
        for action in script.actions:
            self.do(action)

    def do(self, action: Action) -> None:
        """Repeat one recorded action. Raises ValueError for an impossible one."""
        if isinstance(action, Steps | Looks):
            for _ in range(action.times):
                self.step() if isinstance(action, Steps) else self.look()
        elif isinstance(action, MoveDemonstrator):
            self.pose(action.theta_demo)
        elif isinstance(action, ChangeSettings):
            self.change(**convert_fields(action.fields))
        elif isinstance(action, Calibrate):
            self.begin_calibration(np.array(action.postures, float))
        elif isinstance(action, Begin):
            self.begin(action.settings)
        else:
            self.use_calibration(None)

    def undo(self) -> bool:
        """Go one motion back. The later motions stay until the next step. Return False at the start."""
        return self.scrub(self.cursor - 1)

    def scrub(self, motion: int) -> bool:
        """Show the snapshot after a number of motions, or the nearest kept one. Return False if there is none."""
        sent, found = self.snapshot.commanded, self.history.scrub(motion)
        if found:
            self.embodiment.revisit(self.settings, sent, self.snapshot.commanded)
        return found

    def reset(self) -> None:
        """Go back to the start, with the present settings."""
        self.begin(self.settings)

    def resume(self, history: Sequence[Snapshot], cursor: int, log: Log | None = None) -> None:
        """Continue another session from its history, its cursor and its log, if that is known.

        Raises ValueError, with the session as it was, if the other's settings are not possible here.
        """
        shown = history[cursor]
        self._begin(shown.settings, CustomMethods(shown.custom_transfer, shown.custom_servo))
        self.observer, sent = self.embodiment.observer(history[0].theta), self.snapshot.commanded
        self.history, self.log = self._history(history, cursor), Log.unknown() if log is None else log.copy()
        self.embodiment.revisit(self.settings, sent, self.snapshot.commanded)

    def copy(self) -> "Session":
        """A copy that does not follow this session. Any thread may read it."""
        other = copy.copy(self)
        other.history = History(self.history, self.cursor, joints=self.history.joints)
        other.log = self.log.copy()
        return other

    def begin(self, settings: Settings) -> None:
        """Start anew, at motion 0. A calibration of the same body is kept.

        Raises ValueError, with the session as it was, for impossible settings.
        """
        warn_of_radians(settings)
        self._begin(settings, self._custom)

    def _begin(self, settings: Settings, custom: "CustomMethods") -> None:
        custom.require(settings)
        kept, sent = (self.snapshot.calibration, self.snapshot.commanded) if hasattr(self, "history") else (None, None)
        begun = self._open(settings, sent)
        settings, self.embodiment, self.workspace = begun.settings, begun.embodiment, begun.workspace
        theta = begun.theta
        calibration = kept if kept is not None and kept.body == self.embodiment.body(settings) else None
        log = Log(Script(settings)) if calibration is None else self.log.begin(self.cursor, settings)
        self.observer = self.embodiment.observer(theta)
        blank = Snapshot(
            settings=settings, motion=0, look=0, theta=theta, theta_demo=begun.theta_demo, views=NO_VIEWS,
            rectification=None, E=np.nan, commanded=begun.start, moved=np.zeros_like(begun.start), probe=False,
            status=ServoStatus.READY, servo_state=None, lag=None, converged_transfer=None, calibration=calibration,
            custom_transfer=custom.transfer, custom_servo=custom.servo,
        )  # fmt: skip
        self.history = self._history([blank], 0)
        self.history.replace(self._seen(theta, blank))
        self.log, self._custom = log, custom

    def _history(self, snapshots: Sequence[Snapshot], cursor: int) -> History:
        joints = self.embodiment.body(snapshots[cursor].settings).joints
        return History(snapshots, cursor, self._dense, joints)


class CustomMethods(NamedTuple):
    """A transfer and a servo that were given to the session itself, which settings call OWN; None for none."""

    transfer: TransferMethod | None = None
    servo: ServoMethod | None = None

    def require(self, settings: Settings) -> None:
        """Raise ValueError for settings that name a method that was not given."""
        for name, given in zip(self._fields, self):
            if getattr(settings, name) == OWN:
                require_given(name, given)


def _at_rest(now: Snapshot, state: Any) -> Snapshot:
    """The snapshot at which a servo, in this state, asks for no motion."""
    status = status_of(state, ServoStatus.SETTLED)
    status = ServoStatus.NO_PROGRESS if status == ServoStatus.MOVING else status
    converged_transfer = now.transfer if status.is_at_minimum else now.converged_transfer
    return now.with_fields(servo_state=state, status=status, converged_transfer=converged_transfer)


def _same_demonstrator(now: Snapshot, after: Snapshot) -> bool:
    before, demo = now.views.demo, after.views.demo
    return before is demo or np.array_equal(before, demo, equal_nan=True)


def _awake(now: Snapshot) -> ServoStatus:
    """The status of a snapshot whose servo will be asked again."""
    return ServoStatus.READY if now.motion == 0 else ServoStatus.MOVING

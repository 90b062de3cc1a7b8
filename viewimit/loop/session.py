"""A session: what a learner went through, which can be posed, changed, calibrated, undone and replayed.

`learner.Learner` makes each pass of the loop. A session knows no page and no file.
"""

import copy
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NoReturn

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from ..estimation.residuals import ResidualFunction
from ..estimation.transfers import TransferFunction, TransferMethod, transfer_method
from ..estimation.views import FourViews
from ..geometry.arrays import Floats
from ..servo import Observation, Servo, ServoMethod, servo_method
from ..servo.status import ServoStatus
from ..simulation.eyes import SimulatedEyes, open_eyes
from ..simulation.scene import Scene
from ..simulation.world import World
from .arm_and_eyes import Arm, Eyes, require_in_workspace, round_to_degrees, to_degrees
from .history import MAX_HISTORY, RECENT, History
from .learner import Embodiment, Learner, Observer, same_demonstrator
from .real_robot import RealRobot
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
from .snapshot import CustomMethods, Limits, RunResult, Snapshot

RESTARTING_FIELDS = (  # a change of the body, of the sensor or of the arm's limits restarts the session
    "scene", "robot", "joints", "points", "body_points", "start_deg", "undistort", "sensor", "dynamics", "delay",
    "workspace_deg", "matched",
)  # fmt: skip
CustomTransfer = str | TransferMethod | TransferFunction
CustomServo = str | ServoMethod | Servo
PATIENCE = 100  # looks in a row with too few points, after which a run is given up
NO_VIEWS = FourViews(np.empty((0, 4)), np.empty((0, 4)), np.empty((0, 4), bool))


class Session:
    """A learner that imitates a demonstrator, and the history of its motions.

    A session is not thread-safe: one thread steps it.

    Parameters
    ----------
    settings : Settings, optional
        What the run depends on. `Settings()`, the best method, by default.
    open_eyes : callable, optional
        open_eyes(sensor, scene, points) makes the simulated cameras.
    dense : int, optional
        How many of the last motions the history keeps completely. All by default.
    transfer, servo : optional
        Replaces the one that the settings name: another name, or one of your own. A transfer is a function of
        `FourViews` or a `TransferMethod`; a servo is an object with `start` and `step` (`Servo`). The settings then
        name it "own", and no link or file can hold it.

    Attributes
    ----------
    history : History
        All snapshots, by motion.
    log : Log
        The actions so far (`Session.script`).
    learner : Learner
        The arm and its eyes.

    Raises
    ------
    ValueError
        For settings that contradict the scene.
    TypeError
        For an object that is no settings, transfer or servo.
    """

    history: History
    log: Log
    learner: Learner

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
            Moves its joints, and names their limits.
        eyes : Eyes
            Find the points in both cameras' images.
        name : str
            Of the arm. A calibration is only used with an arm of the same name.
        dense, transfer, servo
            As of `Session`.
        **changes
            Fields of `Settings` that differ from `Settings()`: frames (images averaged at each posture), rectify,
            matched, start_deg (replaces the arm's start), seed, max_step_deg and workspace_deg. The limits
            hold for every motion, also for undo and reset. Only the first motion, to the start, may be of any length,
            because the arm's posture before it is unknown.

        Raises
        ------
        ValueError
            For settings that only a scene has, and for impossible limits, postures or images.
        TypeError
            For an arm or eyes that lack a member.
        """
        session = cls.__new__(cls)
        session._set_up(RealRobot(arm, eyes, name), Settings(**changes), dense, transfer, servo)
        return session

    def _set_up(
        self,
        opener: SimulatedRobotOpener | RealRobot,
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
    def embodiment(self) -> Embodiment:
        """The arm, and its view of the demonstrator."""
        return self.learner.embodiment

    @property
    def observer(self) -> Observer:
        """How both bodies are seen."""
        return self.learner.observer

    @property
    def workspace(self) -> Limits:
        """Lowest and highest angles that the arm may be sent to, (m,) rad each."""
        return self.learner.workspace

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

    @property
    def _past(self) -> list[Snapshot]:
        return self.history.recent(RECENT)

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
        joints = self.scene.moving_joints if isinstance(self.embodiment, SimulatedRobot) else ()
        return RunResult(motions, travel, joint_travel, self.snapshot, joints)

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
        looked = now.is_blind and not now.is_rehearsing
        if looked:  # again with the arm held still, as too few points were visible
            now = self.learner.look(self._past, status=now.awake_status)
            self.history.replace(now)
        after = now if looked and now.leaves_servo_blind else self.learner.step(self._past)
        if after.motion == now.motion:
            self.log.note(now.motion, Steps(1))
            self.history.replace(after)
            return False
        self.log.note_on(now.motion, looked)
        self.history.append(after)
        return True

    def look(self) -> bool:
        """Look again without a motion. A servo at rest resumes if the demonstrator has moved.

        A real demonstrator moves by itself; in a scene `pose` moves it.

        Returns
        -------
        bool
            Whether the demonstrator has moved.
        """
        now, after = self.snapshot, self.learner.look(self._past)
        moved = not same_demonstrator(now, after)
        self.log.note(now.motion, Looks(1))
        wakes = after.transfer is not None and (moved or now.transfer is None)
        self.history.replace(after.with_fields(status=after.awake_status) if wakes else after)
        return moved

    def observe(self, theta: Floats, like: Snapshot, **changes: Any) -> Snapshot:
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
        return self.learner.seen(self._past, theta, like, **changes)

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
        return self.learner.observation(now)

    def predicted_residuals(self, now: Snapshot) -> ResidualFunction:
        """Make the function that a servo calls for the residuals of images that it predicts.

        Parameters
        ----------
        now : Snapshot
            Gives the demonstrator's images.

        Returns
        -------
        ResidualFunction
            Own images (..., N, 4) px → residuals (..., n, C) px.
        """
        return self.learner.predicted_residuals(self._past, now, now.servo.mirror_columns)

    def change(self, **fields: Any) -> None:
        """Change fields of the settings from here on.

        A new scene, layout, start or workspace restarts the session. After any other change the present is evaluated
        again. A new servo starts to learn where the arm is.

        Parameters
        ----------
        **fields
            Fields of `Settings` and their values.

        Raises
        ------
        ValueError
            For impossible settings. The session stays as it was.
        """
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
        """Move the demonstrator, and look again.

        Parameters
        ----------
        theta_demo : (m,) array
            Its posture [rad].

        Raises
        ------
        ValueError
            For a posture outside its limits. The session stays as it was.
        """
        theta_demo = self.embodiment.require_posture(theta_demo, "demonstrator's")
        self._pose(theta_demo, self.settings, self.snapshot, MoveDemonstrator(tuple(theta_demo.tolist())))

    def _pose(self, theta_demo: Floats, settings: Settings, now: Snapshot, action: Action) -> None:
        """Go on from `now` with other settings and the demonstrator at theta_demo, (m,) rad."""
        if np.isfinite(theta_demo).all():
            theta_demo = round_to_degrees(theta_demo, self.embodiment.lower, self.embodiment.upper)
            settings = msgspec.structs.replace(settings, demonstrator_deg=to_degrees(theta_demo))
        theta_demo = self.embodiment.settle_demonstrator(theta_demo)
        changes = {"settings": settings, "theta_demo": theta_demo, "status": now.awake_status, "target": None}
        now = self.learner.retargeted(self.learner.seen(self._past, now.theta, now, **changes))
        self.log.note(now.motion, action, merge_poses=isinstance(self.embodiment, SimulatedRobot))
        self.history.replace(now)

    def calibrate(self, count: int, seed: int, within_deg: float | None = None) -> SelfCalibration:
        """Visit `calibration_postures` now, without a demonstrator, and record the own body.

        Parameters
        ----------
        count, seed, within_deg
            As of `calibration_postures`.

        Returns
        -------
        SelfCalibration
            Images of the own body.
        """
        self.begin_calibration(self.calibration_postures(count, seed, within_deg))
        while self.snapshot.is_rehearsing:
            self.step()
        assert self.snapshot.calibration is not None
        return self.snapshot.calibration

    def calibration_postures(self, count: int, seed: int, within_deg: float | None = None) -> Floats:
        """Draw postures for `begin_calibration` from the workspace.

        Parameters
        ----------
        count : int
            Number of postures, MIN_POSTURES or more.
        seed : int
            Of the draw.
        within_deg : float, optional
            Largest distance of each joint from where the arm is now [degrees].

        Returns
        -------
        (count, m) array
            Postures [rad].
        """
        low, high = self.workspace
        if within_deg is not None:
            here, reach = self.snapshot.commanded, np.radians(within_deg)
            low, high = np.maximum(low, here - reach), np.minimum(high, here + reach)
        return calibration_postures(low, high, count, np.random.default_rng(seed))

    def begin_calibration(self, postures: Floats) -> None:
        """Visit postures in the next steps, record the own body there, and then imitate.

        The servo restarts, and an earlier calibration is dropped.

        Parameters
        ----------
        postures : (K, m) array
            MIN_POSTURES or more [rad].

        Raises
        ------
        ValueError
            For too few postures, or one outside the limits. The session stays as it was.
        """
        if len(postures) < MIN_POSTURES:
            raise ValueError(f"needs {MIN_POSTURES} postures or more, got {len(postures)}")
        possible = [self.embodiment.require_posture(theta, "the rehearsed") for theta in postures]
        pending = np.array([require_in_workspace(theta, *self.workspace, "the rehearsed") for theta in possible])
        body, noise_px = self.embodiment.body(self.settings), self.observer.image_noise_std(self.settings)
        self.log.note(self.cursor, Calibrate(tuple(map(tuple, pending.tolist()))))
        calibration = SelfCalibration(body, self.settings.scene_title, noise_px)
        self._begin_again(status=ServoStatus.REHEARSING, calibration=calibration, pending_postures=pending)

    def use_calibration(self, calibration: SelfCalibration | None) -> None:
        """Imitate with a calibration that was recorded elsewhere, or with none. The servo restarts.

        Parameters
        ----------
        calibration : SelfCalibration or None
            Of the same body.

        Raises
        ------
        ValueError
            For a calibration of another body. The session stays as it was.
        """
        now = self.snapshot
        if calibration is None:
            self.log.note(now.motion, ClearCalibration())
        else:
            self.embodiment.body(self.settings).require(calibration.body)
            self.log.invalidate(now.motion)
        self._begin_again(status=now.awake_status, calibration=calibration, pending_postures=None)

    def _begin_again(self, **changes: Any) -> None:
        """Let the servo start again with a calibration, of which postures may be pending."""
        self.history.replace(self.snapshot.with_fields(servo_state=None, target=None, **changes))

    def play(self, script: Script) -> None:
        """Begin with a script's settings and repeat its actions.

        Parameters
        ----------
        script : Script
            As `Session.script`. ValueError if an action is impossible.
        """
        for _ in self.passes(script):
            pass

    def passes(self, script: Script) -> Iterator[None]:
        """Play a script as `play` does, and yield after each pass of the loop.

        Parameters
        ----------
        script : Script
            As `Session.script`. ValueError if an action is impossible.

        Yields
        ------
        None
            After the beginning, and after each step, look and other action.
        """
        self.begin(script.settings)
        yield
        for action in script.actions:
            for _ in range(action.times if isinstance(action, Steps | Looks) else 1):
                self._play(action)
                yield

    def _play(self, action: Action) -> None:
        """Repeat a recorded action, or one of its times. Raises ValueError for an impossible one."""
        match action:
            case Steps():
                self.step()
            case Looks():
                self.look()
            case MoveDemonstrator():
                self.pose(action.theta_demo)
            case ChangeSettings():
                self.change(**convert_fields(action.fields))
            case Calibrate():
                self.begin_calibration(np.array(action.postures, float))
            case Begin():
                self.begin(action.settings)
            case ClearCalibration():
                self.use_calibration(None)
            case _:
                never: NoReturn = action  # a type checker finds an action that is missing above
                raise TypeError(f"no action of a script: {never!r}")

    def undo(self) -> bool:
        """Go one motion back. The later motions stay until the next step.

        Returns
        -------
        bool
            False at the start.
        """
        return self.scrub(self.cursor - 1)

    def scrub(self, motion: int) -> bool:
        """Show the snapshot after a number of motions, or the nearest kept one.

        Parameters
        ----------
        motion : int
            The number of motions.

        Returns
        -------
        bool
            False if there is no such snapshot.
        """
        sent, found = self.snapshot.commanded, self.history.scrub(motion)
        if found:
            self.embodiment.revisit(self.settings, sent, self.snapshot.commanded)
        return found

    def reset(self) -> None:
        """Go back to the start, with the present settings."""
        self.begin(self.settings)

    def resume(self, history: Sequence[Snapshot], cursor: int, log: Log | None = None) -> None:
        """Continue another session.

        Parameters
        ----------
        history : sequence of Snapshot
            Of the other session.
        cursor : int
            Index of its present snapshot.
        log : Log, optional
            Its actions, if they are known.

        Raises
        ------
        ValueError
            If its settings are not possible here. The session stays as it was.
        """
        shown = history[cursor]
        self._begin(shown.settings, CustomMethods(shown.custom_transfer, shown.custom_servo))
        sent, observer = self.snapshot.commanded, self.embodiment.observer(history[0].theta)
        self.learner = replace(self.learner, observer=observer)
        self.history, self.log = self._history(history, cursor), Log.unknown() if log is None else log.copy()
        self.embodiment.revisit(self.settings, sent, self.snapshot.commanded)

    def copy(self) -> "Session":
        """Copy the session. Any thread may read the copy.

        Returns
        -------
        Session
            One that does not follow this session.
        """
        other = copy.copy(self)
        other.history = History(self.history, self.cursor, joints=self.history.joints)
        other.log = self.log.copy()
        return other

    def begin(self, settings: Settings) -> None:
        """Restart at motion 0. A calibration of the same body is kept.

        Parameters
        ----------
        settings : Settings
            Of the new run.

        Raises
        ------
        ValueError
            For impossible settings. The session stays as it was.
        """
        warn_of_radians(settings)
        self._begin(settings, self._custom)

    def _begin(self, settings: Settings, custom: CustomMethods) -> None:
        custom.require(settings)
        kept, sent = (self.snapshot.calibration, self.snapshot.commanded) if hasattr(self, "history") else (None, None)
        embodiment, begun = self._open(settings, sent)
        settings = begun.settings
        calibration = kept if kept is not None and kept.body == embodiment.body(settings) else None
        log = Log(Script(settings)) if calibration is None else self.log.begin(self.cursor, settings)
        learner = Learner(embodiment, embodiment.observer(begun.theta), begun.workspace)
        blank = Snapshot(
            settings=settings, motion=0, look=0, theta=begun.theta, theta_demo=begun.theta_demo, views=NO_VIEWS,
            rectification=None, E=np.nan, commanded=begun.start, moved=np.zeros_like(begun.start), probe=False,
            status=ServoStatus.READY, servo_state=None, lag=None, converged_transfer=None, calibration=calibration,
            custom_transfer=custom.transfer, custom_servo=custom.servo,
        )  # fmt: skip
        first = learner.seen([blank], begun.theta, blank)
        self.learner, self.log, self._custom = learner, log, custom
        self.history = self._history([first], 0)

    def _history(self, snapshots: Sequence[Snapshot], cursor: int) -> History:
        joints = self.embodiment.body(snapshots[cursor].settings).joints
        return History(snapshots, cursor, self._dense, joints)

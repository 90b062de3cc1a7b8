"""The loop of the paper as a session that can be posed, stepped, undone and scrubbed. No page in here.

    posture → body points → four views → transfer → recovered points → residual e → E → servo → next posture

Between views and transfer the images are rectified, where the cameras ask for it.

Every pass leaves one immutable Snapshot, which panels, plots, exports and tests all read.
"""

import copy
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
from ..sensing.renamed import current_settings
from ..servo import Observation, Servo, ServoMethod, servo_method
from ..servo.observation import Visit
from ..servo.status import ServoStatus
from ..simulation.eyes import SimulatedEyes, open_eyes
from ..simulation.scene import Scene
from ..simulation.world import World
from .embodiment import Arm, Embodiment, Eyes, Observer, Opener, degrees, round_to_degrees, waypoints, within
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
from .snapshot import RunResult, Snapshot, exchanged, given_own, predicted_residuals, probes, status_of

BEGIN_ANEW = (  # what changes body or camera
    "scene", "robot", "joints", "points", "body_points", "start_deg", "undistort", "sensor", "delay", "workspace_deg",
)  # fmt: skip
PATIENCE = 100  # looks in a row with too few points, after which a run is given up
GivenTransfer = str | TransferMethod | TransferFunction
GivenServo = str | ServoMethod | Servo
NOTHING_SEEN = FourViews(np.empty((0, 4)), np.empty((0, 4)), np.empty((0, 4), bool))


class Session:
    """One learner, one demonstrator, one history. Not thread-safe: one thread steps it.

    settings: `Settings()`, the best method, if None. transfer, servo: in place of those of the settings, a name or one
    of your own, which settings then call OWN: a function of `FourViews` or a `TransferMethod`, and an object with
    `start` and `step` (`Servo`). No link or file holds them. open_eyes(camera, scene, points): what it looks
    with and moves by; dense: how many of the last motions its history keeps all of, None for all. workspace: the lowest
    and the highest angles that its arm may be sent to, (m,) rad each. Raises ValueError, with the session as it was,
    for settings that cannot be; TypeError for what is no transfer or no servo.
    """

    embodiment: Embodiment
    observer: Observer
    workspace: tuple[NDArray, NDArray]
    history: History
    log: Log

    def __init__(
        self,
        settings: Settings | None = None,
        open_eyes: OpenEyes = open_eyes,
        dense: int | None = None,
        transfer: GivenTransfer | None = None,
        servo: GivenServo | None = None,
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
        transfer: GivenTransfer | None = None,
        servo: GivenServo | None = None,
        **changes: Any,
    ) -> "Session":
        """With an arm and eyes of one's own: no scene, no world, no truth. The arm goes to its start at once.

        name: of the arm, by which a rehearsal knows its own; dense, transfer, servo: as of `Session`; changes: fields
        of `Settings` that differ from `Settings.best()`: frames (looks averaged at each posture), rectify, start_deg
        (in place of the arm's start), seed, and how far the arm may go: max_step_deg, workspace_deg and restarts. These
        hold for all that it is sent to, undo and reset included, but the very first motion, to its start, may be of any
        length, as nobody knows where the arm stood before. Raises ValueError for settings that only a scene has, and
        for limits, postures and looks that are none; TypeError for an arm or eyes that lack a member.
        """
        session = cls.__new__(cls)
        session._set_up(RealRobotOpener(arm, eyes, name), Settings.best(**changes), dense, transfer, servo)
        return session

    def _set_up(
        self,
        opener: Opener,
        settings: Settings,
        dense: int | None,
        transfer: GivenTransfer | None,
        servo: GivenServo | None,
    ) -> None:
        self._open, self._dense = opener, dense
        named = {"transfer": transfer, "servo": servo}
        chosen = {name: one if isinstance(one, str) else OWN for name, one in named.items() if one is not None}
        self._own = OwnMethods(
            None if isinstance(transfer, str | None) else transfer_method(transfer),
            None if isinstance(servo, str | None) else servo_method(servo),
        )
        self.begin(msgspec.structs.replace(settings, **chosen))

    @property
    def snapshot(self) -> Snapshot:
        """The present, or the moment of history that the cursor is on."""
        return self.history.present

    @property
    def cursor(self) -> int:
        """How many motions lie before the moment shown."""
        return self.history.cursor

    @property
    def settings(self) -> Settings:
        return self.snapshot.settings

    @property
    def script(self) -> Script:
        """What leads to the moment shown, played in a new session. Raises ValueError where that is not known."""
        return self.log.script(self.cursor)

    @property
    def eyes(self) -> SimulatedEyes:
        """Of a learner in a scene. Raises ValueError for an arm and eyes of one's own."""
        if not isinstance(self.embodiment, SimulatedRobot):
            raise ValueError("an arm and eyes of your own have no scene, no world and no truth")
        return self.embodiment.eyes

    @property
    def world(self) -> World:
        """The truth, for viewers only."""
        return self.eyes.world

    @property
    def scene(self) -> Scene:
        return self.world.scene

    def run(
        self,
        max_motions: int = MAX_HISTORY,
        patience: int = PATIENCE,
        each: Callable[[Snapshot], None] = lambda moment: None,
    ) -> RunResult:
        """Step until the servo rests, that many motions lie behind, or too few points were seen in `patience` looks in
        a row → why it ended, and the last moment. each: called with the moment after each motion."""
        in_vain, motions, travel, joint_travel = 0, 0, 0.0, np.zeros_like(self.snapshot.moved)
        while self.snapshot.motion < max_motions and in_vain < patience:
            if self.step():
                moved = np.abs(self.snapshot.moved)
                in_vain, motions, travel = 0, motions + 1, travel + float(moved.max())
                joint_travel += moved
                each(self.snapshot)
            elif self.snapshot.status == ServoStatus.TOO_FEW_POINTS:
                in_vain += 1
            else:
                break
        return RunResult(motions, travel, joint_travel, self.snapshot)

    def step(self) -> bool:
        """One pass: ask the servo, move, look. False if the servo rests or the arm must hold still.

        A motion that is longer than the settings allow takes several passes; the servo is asked again after the last.
        From a moment in the past the later history is dropped.
        """
        if self.snapshot.is_rehearsing:
            self._step_calibration(self.snapshot)
            return True
        held = self.snapshot.transfer is None and self.snapshot.target is None
        now = self._with_points() if held else self.snapshot
        if held and now.transfer is None and not self._knows_on(now):
            self.log.note(now.motion, Steps(1))
            return False
        if now.motion >= MAX_HISTORY:
            self.log.note(now.motion, Steps(1))
            self.history.replace(now.with_fields(status=ServoStatus.MAX_MOTIONS))
            return False
        if now.target is not None:
            self.log.note_on(now.motion, looked=False)
            status = status_of(now.servo_state, ServoStatus.MOVING)
            self.history.append(self._moved(now, now.target, probe=now.probe, status=status))
            return True
        state, displacement = self._ask(now)  # residual e → E → servo
        if exchanged(state) != exchanged(now.servo_state):
            now = self._observed(now.theta, now, servo_state=state)
        if not displacement.any():
            self.log.note(now.motion, Steps(1))
            self.history.replace(_resting(now, state))
            return False
        self.log.note_on(now.motion, looked=held)
        target, status, probe = now.commanded + displacement, status_of(state, ServoStatus.MOVING), probes(state)
        after = self._moved(now, target, probe=probe, status=status, servo_state=state)
        self.history.append(after)
        return True

    def observe(self, theta: NDArray, like: Snapshot, **changes) -> Snapshot:
        """What would be seen, recovered and evaluated at `theta`, (m,) rad: nothing moves, nothing is kept.

        like: what it is in all else but `changes`, fields by name. Raises ValueError for a posture other than the
        present one with eyes of one's own, which see the arm only where it stands.
        """
        if not self.observer.anywhere and not np.array_equal(theta, self.snapshot.theta):
            raise ValueError("eyes of your own see the arm only where it stands: let it move there, and look()")
        return self._observed(theta, like, **changes)

    def _observed(self, theta: NDArray, like: Snapshot, **changes) -> Snapshot:
        """As `observe`; with eyes of one's own where the arm now stands."""
        settings, demo = changes.get("settings", like.settings), changes.get("theta_demo", like.theta_demo)
        look, before = changes.get("look", like.look), self.history.recent(MAX_LOOKS)
        views = self.observer.four_views(settings, theta, demo, look)  # posture → four views
        views = views.permuted(exchanged(changes.get("servo_state", like.servo_state)))
        past, last = [moment.views for moment in before], before[-1]
        views = reject_outliers(views, past, last.rectification, self.observer.image_noise_std(settings), look)
        rectification = None
        if settings.rectify != "off":
            changed = last.settings != settings
            rectification = update_rectification(views, past, last.rectification, last.motion, refresh=changed)
        seen = like.with_fields(theta=theta, views=views, rectification=rectification, **changes)
        if seen.transfer is None:  # → transfer
            return seen.with_fields(E=np.nan, status=ServoStatus.TOO_FEW_POINTS)
        return seen.with_fields(E=float(seen.transfer.conflict(views.used)))  # → recovered points → e → E

    def look(self) -> bool:
        """Look again where the arm stands → whether the demonstrator is seen elsewhere, for which a servo at rest wakes
        up. A demonstrator of one's own may have moved; in a scene `pose` moves it."""
        now = self.snapshot
        after = self._followed(now, self._observed(now.theta, now, look=now.look + 1))
        moved = not _same_demonstrator(now, after)
        self.log.note(now.motion, Looks(1))
        wakes = after.transfer is not None and (moved or now.transfer is None)
        self.history.replace(after.with_fields(status=_awake(after)) if wakes else after)
        return moved

    def observation(self, now: Snapshot) -> Observation:
        """What a servo is told of a moment of the history."""
        start = now.settings.start_rad
        known = now.calibration if now.calibration is not None and len(now.calibration) >= MIN_POSTURES else None
        noise_px = self.observer.image_noise_std(now.settings)
        return Observation(
            own=now.views.own,
            seen=now.views.visible[:, 2:],
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

    def predicted_residuals(self, now: Snapshot) -> ResidualFunction:
        """What a servo may ask at a moment, the present one, about images that it predicts."""
        moments, noise_px = self.history.recent(RECENT), self.observer.image_noise_std(now.settings)
        velocity = target_velocity([moment.views for moment in moments[-VELOCITY_LOOKS:]])
        return predicted_residuals(now, velocity, noise_px, moments)

    def change(self, **fields) -> None:
        """New settings from here on. A new scene, layout, start or workspace begins anew; all else re-observes the
        present.

        A new servo starts learning afresh, where the arm now stands. Raises ValueError, with the session as it was.
        """
        fields = current_settings(fields)
        settings = msgspec.structs.replace(self.settings, **fields)
        self._own.require(settings)
        if any(getattr(settings, name) != getattr(self.settings, name) for name in BEGIN_ANEW):
            self.begin(settings)
            return
        changed = {name: getattr(settings, name) for name in fields}
        now = self.snapshot.with_fields(converged_transfer=None)
        if settings.servo != now.settings.servo:
            now = now.with_fields(servo_state=None)
        warn_of_radians(settings)
        self._pose(self.embodiment.demonstrator(settings), settings, now, ChangeSettings(changed))

    def pose(self, theta_demo: ArrayLike) -> None:
        """Move the demonstrator to theta_demo, (m,) rad, at any time; the learner looks again.

        Raises ValueError, with the session as it was, for a posture out of its limits.
        """
        theta_demo = self.embodiment.require_posture(theta_demo, "demonstrator's")
        self._pose(theta_demo, self.settings, self.snapshot, MoveDemonstrator(tuple(theta_demo.tolist())))

    def begin_calibration(self, postures: NDArray) -> None:
        """Go through these, (K, m) rad, in the next steps, with nobody to imitate, and keep what is seen of the own
        body; then imitate. The servo begins afresh, and what was rehearsed before is forgotten.

        Raises ValueError, with the session as it was, for a posture out of the limits or fewer than MIN_POSTURES.
        """
        if len(postures) < MIN_POSTURES:
            raise ValueError(f"needs {MIN_POSTURES} postures or more, got {len(postures)}")
        possible = [self.embodiment.require_posture(theta, "the rehearsed") for theta in postures]
        pending_postures = np.array([within(theta, *self.workspace, "the rehearsed") for theta in possible])
        settings = self.settings
        body = SelfCalibration(
            self.embodiment.body(settings), settings.scene_called, self.observer.image_noise_std(settings)
        )
        now = self.snapshot.with_fields(
            calibration=body,
            pending_postures=pending_postures,
            servo_state=None,
            status=ServoStatus.REHEARSING,
            target=None,
        )
        self.log.note(now.motion, Calibrate(tuple(map(tuple, pending_postures.tolist()))))
        self.history.replace(now)

    def calibrate(self, count: int, seed: int, within_deg: float | None = None) -> SelfCalibration:
        """Go through `calibration_postures` now, with nobody to imitate, and return what was seen of the own body."""
        self.begin_calibration(self.calibration_postures(count, seed, within_deg))
        while self.snapshot.is_rehearsing:
            self.step()
        assert self.snapshot.calibration is not None
        return self.snapshot.calibration

    def calibration_postures(self, count: int, seed: int, within_deg: float | None = None) -> NDArray:
        """Postures, (count, m) rad, for `begin_calibration`, drawn with a seed from the workspace.

        within_deg: keep each joint within this distance of where the arm is now. Raises ValueError for fewer than
        MIN_POSTURES.
        """
        low, high = self.workspace
        if within_deg is not None:
            here, reach = self.snapshot.commanded, np.radians(within_deg)
            low, high = np.maximum(low, here - reach), np.minimum(high, here + reach)
        return calibration_postures(low, high, count, np.random.default_rng(seed))

    def use_calibration(self, body: SelfCalibration | None) -> None:
        """Imitate with what was rehearsed elsewhere, or None. The servo begins afresh.

        Raises ValueError, with the session as it was, for a rehearsal of another body, with what differs.
        """
        if body is not None:
            self.embodiment.body(self.settings).require(body.body)
        now = self.snapshot
        if body is None:
            self.log.note(now.motion, ClearCalibration())
        else:
            self.log.invalidate(now.motion)
        anew = {"pending_postures": None, "servo_state": None, "status": _awake(now), "target": None}
        self.history.replace(now.with_fields(calibration=body, **anew))

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
        """One motion back; the later ones stay until the next step. False at the start."""
        return self.scrub(self.cursor - 1)

    def scrub(self, motion: int) -> bool:
        """Show the moment after that many motions, or the one that stands in its place. False if there is none."""
        sent, found = self.snapshot.commanded, self.history.scrub(motion)
        if found:
            self.embodiment.revisit(self.settings, sent, self.snapshot.commanded)
        return found

    def reset(self) -> None:
        """Back to the start, with the settings as they are now."""
        self.begin(self.settings)

    def resume(self, history: Sequence[Snapshot], cursor: int, log: Log | None = None) -> None:
        """Go on from what another session has left: its history, the motion that it showed, and how it came there, if
        that is known.

        Raises ValueError, with the session as it was, if its settings cannot be here.
        """
        shown = history[cursor]
        self._begin(shown.settings, OwnMethods(shown.custom_transfer, shown.custom_servo))
        self.observer, sent = self.embodiment.looks(history[0].theta), self.snapshot.commanded
        self.history, self.log = self._history(history, cursor), Log.unknown() if log is None else log.copy()
        self.embodiment.revisit(self.settings, sent, self.snapshot.commanded)

    def copy(self) -> "Session":
        """That does not follow any more; to be read, by any thread."""
        other = copy.copy(self)
        other.history = History(self.history, self.cursor, joints=self.history.joints)
        other.log = self.log.copy()
        return other

    def begin(self, settings: Settings) -> None:
        """Begin anew, at motion 0, with what was rehearsed if that was of the same body.

        Raises ValueError, with the session as it was, if the settings cannot be.
        """
        warn_of_radians(settings)
        self._begin(settings, self._own)

    def _begin(self, settings: Settings, own: "OwnMethods") -> None:
        own.require(settings)
        kept, sent = (self.snapshot.calibration, self.snapshot.commanded) if hasattr(self, "history") else (None, None)
        begun = self._open(settings, sent)
        settings, self.embodiment, self.workspace = begun.settings, begun.embodiment, begun.workspace
        theta = begun.theta
        body = kept if kept is not None and kept.body == self.embodiment.body(settings) else None
        log = _log_anew(settings, None if body is None else self)
        self.observer = self.embodiment.looks(theta)
        blank = Snapshot(
            settings=settings, motion=0, look=0, theta=theta, theta_demo=begun.theta_demo, views=NOTHING_SEEN,
            rectification=None, E=np.nan, commanded=begun.start, moved=np.zeros_like(begun.start), probe=False,
            status=ServoStatus.READY, servo_state=None, lag=None, converged_transfer=None, calibration=body,
            custom_transfer=own.transfer, custom_servo=own.servo,
        )  # fmt: skip
        self.history = self._history([blank], 0)
        self.history.replace(self._observed(theta, blank))
        self.log, self._own = log, own

    def _history(self, moments: Sequence[Snapshot], cursor: int) -> History:
        """Of this session's arm, from these moments on."""
        joints = self.embodiment.body(moments[cursor].settings).joints
        return History(moments, cursor, self._dense, joints)

    def _with_points(self) -> Snapshot:
        """The present; looked at again, with the arm held still, if too few points were seen."""
        now = self.snapshot
        if now.transfer is None:
            again = self._observed(now.theta, now, look=now.look + 1, status=_awake(now))
            now = self._followed(now, again)
            self.history.replace(now)
        return now

    def _knows_on(self, now: Snapshot) -> bool:
        """Whether its servo can tell a way on from where too few points are in sight: the demonstrator is seen."""
        begun = now.servo_state is not None
        return begun and now.servo.predicts and now.shows_demonstrator

    def _ask(self, now: Snapshot) -> tuple[Any, NDArray]:
        """The servo's next state, and the displacement that it wants, (m,) rad."""
        servo, seen = now.servo, self.observation(now)
        state = servo.start(seen) if now.servo_state is None else now.servo_state
        answer = servo.step(state, seen, self.predicted_residuals(now))
        if not (isinstance(answer, tuple) and len(answer) == 2):
            raise TypeError(f"the servo {servo.title!r} must return its state and its motion, (m,) rad, got {answer!r}")
        state, displacement = answer[0], np.asarray(answer[1], float)
        if displacement.shape != now.theta.shape or not np.isfinite(displacement).all():
            wanted = f"{len(now.theta)} finite angles in rad"
            raise ValueError(f"the servo {servo.title!r} must return its state and {wanted}, got {displacement}")
        return state, displacement

    def _moved(self, now: Snapshot, target: NDArray, **changes) -> Snapshot:
        """The moment after a motion to the target, (m,) rad, within the workspace and as far as one motion may go; it
        changes these fields as well."""
        target = target.clip(*self.workspace)
        commanded, *left = waypoints(now.commanded, target, now.settings.max_step)
        theta = self.embodiment.drive(now.settings, now.theta, now.commanded, commanded)  # → next posture
        waited, lag = self.observer.wait(now, theta)
        after = self._observed(  # → four views → transfer → recovered points → e → E
            theta, now, motion=now.motion + 1, look=now.look + 1 + waited, lag=lag, commanded=commanded,
            moved=theta - now.theta, target=target if left else None, **changes,
        )  # fmt: skip
        return self._followed(now, after)

    def _followed(self, now: Snapshot, after: Snapshot) -> Snapshot:
        """The later moment, its servo told if the demonstrator has moved by itself, and where it was on its way to
        forgotten."""
        if after.servo_state is None or after.transfer is None or _same_demonstrator(now, after):
            return after
        state = after.servo.retarget(after.servo_state, self.observation(after))
        return after.with_fields(servo_state=state, target=None)

    def _step_calibration(self, now: Snapshot) -> None:
        """On to the next posture to watch itself in, and keep what is seen there."""
        assert now.pending_postures is not None and now.calibration is not None
        target, left = now.pending_postures[0], now.pending_postures[1:]
        after, body = self._moved(now, target, probe=True), now.calibration
        if after.target is None:
            visit = Visit.of(after.commanded - self.embodiment.lower, after.views.own, after.views.visible[:, 2:])
            body = body.with_visit(visit)
        else:
            left = now.pending_postures
        status = ServoStatus.REHEARSING if len(left) else _awake(after)
        self.log.note_on(now.motion, looked=False)
        self.history.append(after.with_fields(calibration=body, pending_postures=left, status=status))

    def _pose(self, theta_demo: NDArray, settings: Settings, now: Snapshot, action: Action) -> None:
        """Go on from `now` with other settings and the demonstrator at theta_demo, (m,) rad, within its limits."""
        if np.isfinite(theta_demo).all():
            theta_demo = round_to_degrees(theta_demo, self.embodiment.lower, self.embodiment.upper)
            settings = msgspec.structs.replace(settings, demonstrator_deg=degrees(theta_demo))
        theta_demo = self.embodiment.pose(theta_demo)
        now = self._observed(now.theta, now, settings=settings, theta_demo=theta_demo, status=_awake(now), target=None)
        if now.servo_state is not None:
            state = now.servo.retarget(now.servo_state, self.observation(now))
            now = now.with_fields(servo_state=state)
        self.log.note(now.motion, action)
        self.history.replace(now)


class OwnMethods(NamedTuple):
    """What a session was given itself, which settings call OWN; None for none."""

    transfer: TransferMethod | None = None
    servo: Servo | None = None

    def require(self, settings: Settings) -> None:
        """Raises ValueError for settings that name one that was not given."""
        for name, given in zip(self._fields, self):
            if getattr(settings, name) == OWN:
                given_own(name, given)


def _log_anew(settings: Settings, before: Session | None) -> Log:
    """Of a session that begins; before: the one as it was, of which a rehearsal is kept."""
    if before is None:
        return Log(Script(settings))
    try:
        script = before.script
    except ValueError:
        return Log.unknown()
    return Log(Script(script.settings, (*script.actions, Begin(settings))))


def _resting(now: Snapshot, state: Any) -> Snapshot:
    """The moment at which a servo, now in this state, wants no motion any more."""
    status = status_of(state, ServoStatus.SETTLED)
    status = ServoStatus.NO_PROGRESS if status == ServoStatus.MOVING else status
    converged_transfer = now.transfer if status.is_at_minimum else now.converged_transfer
    return now.with_fields(servo_state=state, status=status, converged_transfer=converged_transfer)


def _same_demonstrator(now: Snapshot, after: Snapshot) -> bool:
    before, demo = now.views.demo, after.views.demo
    return before is demo or np.array_equal(before, demo, equal_nan=True)


def _awake(now: Snapshot) -> ServoStatus:
    """The status of a moment at which the servo has to be asked again."""
    return ServoStatus.READY if now.motion == 0 else ServoStatus.MOVING

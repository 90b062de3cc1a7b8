"""The loop of the paper as a session that can be posed, stepped, undone and scrubbed. No page in here.

    posture → four views → transfer → recovered points → residual e → E → servo → next posture

Every pass leaves one immutable Snapshot, which panels, plots, exports and tests all read.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .evaluation import residual
from .geometry.affine import MIN_POINTS
from .perception import frames
from .perception.latency import MOST_LAG, lag_of
from .servo import SERVOS, Observation
from .simulation.eyes import open_eyes
from .simulation.scene import Scene, load_scene
from .simulation.world import Disturbance, World
from .snapshot import USUAL_POINTS, Settings, Snapshot, derived
from .transfer import TRANSFERS
from .transfer.noise import noise_weight
from .views import FourViews

DEMO_LOOK, OWN_LOOK, REST_LOOK = 0, 1, 4  # streams of the seed: demonstrator, once; own body, at every motion, at rest
REST_LOOKS = 8  # images of the own body at rest, from which the learner knows their noise
BEGIN_ANEW = ("scene", "robot", "joints", "points", "start_deg", "camera", "delay")  # what changes body or camera
UNDISTURBED = Disturbance()
MAX_HISTORY, RECENT = 100_000, 64  # motions a session makes; and keeps with all that follows from them
STRIDE = 32  # of motions long past one in so many is kept, if not all are


class Session:
    """One learner, one demonstrator, one history. Not thread-safe: one thread steps it.

    open_eyes(camera, scene, points): what it looks with and moves by, as `simulation.eyes` has it; dense: how many of
    the last motions are kept, None for all. Of older ones every STRIDE-th is, and stands in place of those after it.
    Raises ValueError, with the session as it was, for settings that cannot be.
    """

    def __init__(self, settings: Settings | None = None, open_eyes: Callable = open_eyes, dense: int | None = None):
        self._open_eyes, self._built, self._dense = open_eyes, None, dense
        self.history: list[Snapshot]
        self.cursor: int
        self.begin(settings or Settings())

    @property
    def snapshot(self) -> Snapshot:
        """The present, or the moment of history that the cursor is on."""
        return self.history[self.cursor]

    @property
    def settings(self) -> Settings:
        return self.snapshot.settings

    @property
    def world(self) -> World:
        """The truth, for viewers only."""
        return self.eyes.world

    @property
    def scene(self) -> Scene:
        return self.world.scene

    def step(self) -> bool:
        """One pass: ask the servo, move, look. False if the servo rests or the arm must hold still.

        From a moment in the past the later history is dropped.
        """
        now = self.snapshot
        if now.transfer is None:  # too few points: hold still and look again
            now = self.observe(now.theta, now, look=now.look + 1, status=_awake(now))
            self._replace(now)
            if now.transfer is None:
                return False
        if now.motion >= MAX_HISTORY:
            self._replace(replace(now, status="stopped"))
            return False
        servo, seen = SERVOS[now.settings.servo], self.observation(now)
        state = servo.start(seen) if now.servo_state is None else now.servo_state
        state, displacement = servo.step(state, seen, self._conflict(now))
        if not np.any(displacement):
            status = "stalled" if state.status == "moving" else state.status
            frozen = now.transfer if status == "converged" else now.frozen
            self._replace(replace(now, servo_state=state, status=status, frozen=frozen))
            return False
        commanded = np.clip(now.commanded + displacement, self.scene.lower, self.scene.upper)
        theta = self.eyes.drive(now.settings, now.theta, now.commanded, commanded)
        waited, lag = self._wait(theta, now)
        look = now.look + 1 + waited
        after = self.observe(theta, now, motion=now.motion + 1, look=look, status=state.status, lag=lag)
        moved = theta - now.theta
        after = replace(after, commanded=commanded, moved=moved, probe=state.probe, servo_state=state)
        self.history[self.cursor + 1 :] = [after]
        self.cursor += 1
        if self.cursor >= RECENT:
            self.history[self.cursor - RECENT].fade()
        if self._dense is not None and (self.cursor - self._dense) % STRIDE == 0:
            self._thin(self.cursor - self._dense - STRIDE)
        return True

    def observe(self, theta: NDArray, like: Snapshot, settings: Settings | None = None, **changes) -> Snapshot:
        """What would be seen, recovered and evaluated at `theta`, (m,) rad: nothing moves, nothing is kept."""
        settings = settings or like.settings
        views = self._look(theta, like.theta_demo, settings, changes.get("look", like.look))
        found, E = derived(views, settings.transfer), np.nan
        if found["transfer"] is None:
            changes["status"] = "stopped"
        else:
            E = float(found["transfer"].conflict(views.used))
        return replace(like, settings=settings, theta=theta, views=views, E=E, **found, **changes)

    def observation(self, now: Snapshot) -> Observation:
        """What a servo is told of a moment of the history."""
        start = np.radians(now.settings.start_deg)
        return Observation(
            own=now.views.own,
            seen=now.views.visible[:, 2:],
            E=now.E,
            displacement=now.commanded - start,
            lower=self.scene.lower - start,
            upper=self.scene.upper - start,
            motion=now.motion,
            noise_px=self._noise_at_rest(now.settings),
        )

    def change(self, **fields) -> None:
        """New settings from here on. A new scene, layout or start begins anew; all else re-observes the present.

        A new servo starts learning afresh, where the arm now stands.
        """
        settings = msgspec.structs.replace(self.settings, **fields)
        if any(getattr(settings, name) != getattr(self.settings, name) for name in BEGIN_ANEW):
            self.begin(settings)
            return
        now = replace(self.snapshot, frozen=None)
        if settings.servo != now.settings.servo:
            now = replace(now, servo_state=None)
        rest = np.array(self.scene.posture_deg)[self.scene.moving]
        self.pose(np.radians(_given(settings.demonstrator_deg, rest)), settings, now)

    def pose(self, theta_demo: ArrayLike, settings: Settings | None = None, now: Snapshot | None = None) -> None:
        """Move the demonstrator to theta_demo, (m,) rad, at any time; the learner looks again."""
        now, settings = now or self.snapshot, settings or self.settings
        theta_demo = self.scene.require_posture(theta_demo, "demonstrator's")
        settings = msgspec.structs.replace(settings, demonstrator_deg=_degrees(theta_demo))
        now = replace(now, theta_demo=self.eyes.settle(theta_demo))
        now = self.observe(now.theta, now, settings, status=_awake(now))
        if now.servo_state is not None:
            state = SERVOS[settings.servo].retarget(now.servo_state, self.observation(now))
            now = replace(now, servo_state=state)
        self._replace(now)

    def undo(self) -> bool:
        """One motion back; the later ones stay until the next step."""
        return self.scrub(self.cursor - 1)

    def scrub(self, motion: int) -> bool:
        """Show the moment after that many motions, or the one that stands in its place. False if there is none."""
        if not 0 <= motion < len(self.history):
            return False
        self.cursor = self.history[motion].motion
        return True

    def reset(self) -> None:
        """Back to the start, with the settings as they are now."""
        self.begin(self.settings)

    def resume(self, history: Sequence[Snapshot], cursor: int) -> None:
        """Go on from what another session has left: its history, and the motion that it showed."""
        self.begin(history[cursor].settings)
        self.history, self.cursor = list(history), cursor
        for moment in self.history[: max(cursor - RECENT, 0)]:
            moment.fade()
        if self._dense is not None:
            for first in range(0, cursor - self._dense - STRIDE + 1, STRIDE):
                self._thin(first)

    def _thin(self, first: int) -> None:
        """Let the moment after so many motions stand for those until the next one that is kept."""
        if first >= 0:
            self.history[first + 1 : first + STRIDE] = [self.history[first]] * (STRIDE - 1)

    def begin(self, settings: Settings) -> None:
        """Begin anew, at motion 0. Raises ValueError, with the session as it was, if the settings cannot be."""
        scene = load_scene(settings.scene, settings.robot, settings.joints)
        if settings.points == USUAL_POINTS:
            settings = msgspec.structs.replace(settings, points=scene.layout_near(USUAL_POINTS))
        rest = np.array(scene.posture_deg)[scene.moving]
        demo = scene.require_posture(np.radians(_given(settings.demonstrator_deg, rest)), "demonstrator's")
        start = scene.require_posture(np.radians(_given(settings.start_deg, scene.start_deg)), "learner's start")
        settings = msgspec.structs.replace(settings, demonstrator_deg=_degrees(demo), start_deg=_degrees(start))
        build = settings.camera, scene, settings.points
        if build != self._built:
            self.eyes, self._built = self._open_eyes(*build), build
        demo, standing, empty = self.eyes.settle(demo), self.eyes.settle(start), np.empty((0, 4))
        nothing = FourViews(empty, empty, np.empty((0, 4), bool))
        blank = Snapshot(
            settings, 0, 0, standing, demo, nothing, np.empty(0, bool), None, np.inf, empty, empty, np.nan,
            start, np.zeros_like(start), False, "ready", None, None, None,
        )  # fmt: skip
        self._demo_look, self._rest = None, None
        self.history, self.cursor = [self.observe(standing, blank)], 0

    def _demo_drift(self) -> NDArray:
        """(N, 4) px: how far the demonstrator's points go in the next motion, if they have gone on during the last two.

        One jump is no drift: both displacements must point the same way.
        """
        recent = [moment.views.demo for moment in self.history[max(self.cursor - 2, 0) : self.cursor + 1]]
        if len(recent) < 3 or recent[1] is recent[2]:  # it was not even looked at again
            return np.zeros(())
        before, last = np.nan_to_num(np.diff(recent, axis=0))  # NaN: not seen
        return last if np.vdot(before, last) > 0 else np.zeros(())

    def _wait(self, theta: NDArray, now: Snapshot) -> tuple[int, int | None]:
        """After a motion to theta: for how many looks to wait until the picture shows it, and what is known of the lag.

        Nobody tells how late pictures come: the first motion that shows does.
        """
        if now.lag is not None:
            return now.lag, now.lag

        def own(after: int) -> tuple[NDArray, NDArray]:
            pictured = theta if after >= now.settings.delay else now.theta
            return merged_look(now.settings, self.eyes.own_images(pictured), OWN_LOOK, now.look + 1 + after)

        lag = lag_of((now.views.own, now.views.visible[:, 2:]), own, self._noise_at_rest(now.settings))
        return MOST_LAG if lag is None else lag, lag

    def _look(self, theta: NDArray, theta_demo: NDArray, settings: Settings, look: int) -> FourViews:
        """The own body is looked at anew; the demonstrator only when it or its disturbance has changed."""
        key = theta_demo.tobytes(), disturbance(settings), settings.frames, settings.seed
        if self._demo_look is None or self._demo_look[0] != key:
            images = self.eyes.demo_images(theta_demo)
            self._demo_look = key, merged_look(settings, images, DEMO_LOOK)
        demo, demo_visible = self._demo_look[1]
        own, own_visible = merged_look(settings, self.eyes.own_images(theta), OWN_LOOK, look)
        return FourViews(demo, own, np.concatenate([demo_visible, own_visible], -1))

    def _noise_at_rest(self, settings: Settings) -> float:
        """Standard deviation of a coordinate, as averaged, from single images of the own body at the start, px."""
        key = disturbance(settings), settings.seed, settings.frames
        if self._rest is None or self._rest[0] != key:
            measured = 0.0
            if key[0] != UNDISTURBED:
                images = self.eyes.own_images(self.history[0].theta)
                looks = key[0].frames(*images, [settings.seed, REST_LOOK], REST_LOOKS)
                measured = frames.noise(*looks) / np.sqrt(settings.frames)
            self._rest = key, float(np.hypot(measured, self.eyes.noise_px))
        return self._rest[1]

    def _replace(self, snapshot: Snapshot) -> None:
        self.history[self.cursor :] = [snapshot]

    def _conflict(self, now: Snapshot) -> Callable[[NDArray], NDArray]:
        """Residuals that own images (..., N, 4) would have against the demonstrator as now seen.

        Of the points that are known in all of them; by the transfer chosen or by another one's name; weighed, if own
        images (N, 4) are given as `like`, as the noise of the demonstrator's would spread over those. Behind a moving
        demonstrator seen with noise the transfer of the last convergence serves (Section 5.4): fitted anew at postures
        apart it would add its own noise to theirs.
        """
        drift = self._demo_drift()
        demo, demo_seen = now.views.demo + drift, now.views.visible[:, :2].all(-1)
        frozen = now.frozen if drift.any() and self._noise_at_rest(now.settings) > 0 else None

        def predicted(own: NDArray, by: str | None = None, like: NDArray | None = None) -> NDArray:
            known = demo_seen & np.isfinite(own).all(-1).reshape(-1, len(demo_seen)).all(0)
            if known.sum() < MIN_POINTS:  # nothing can be told of such images: they are to be avoided
                return np.full((*own.shape[:-2], 1, 4), np.inf)
            imagined = FourViews(demo[known], own[..., known, :], now.views.visible[known])
            transfer = TRANSFERS[by or now.settings.transfer](imagined) if by or frozen is None else frozen
            e = residual(transfer, imagined)
            if like is None or transfer.weighs_noise:
                return e
            return e @ noise_weight(imagined.with_own(like[known]))

        return predicted


def disturbance(settings: Settings) -> Disturbance:
    return Disturbance(settings.noise_px, settings.missing, settings.outliers)


def merged_look(settings: Settings, images: tuple[NDArray, NDArray], *stream: int) -> tuple[NDArray, NDArray]:
    """What is seen of images (N, 4) px, (N, 2): as many frames as are set, disturbed and merged."""
    seed = [settings.seed, *stream]
    spoilt = disturbance(settings)
    if settings.frames == 1 or spoilt == UNDISTURBED:
        return spoilt.apply(*images, seed)
    return frames.merge(*spoilt.frames(*images, seed, settings.frames))


def _awake(now: Snapshot) -> str:
    return "ready" if now.motion == 0 else "moving"


def _given(value, default):
    return default if value is None else value


def _degrees(theta: NDArray) -> tuple[float, ...]:
    return tuple(float(angle) for angle in np.round(np.degrees(theta), 9))

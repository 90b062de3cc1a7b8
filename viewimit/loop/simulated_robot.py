"""A learner in a simulated scene: how it sees both bodies, and how its arm moves.

The images are disturbed and averaged as the settings say, and perhaps late. With equal seeds the learner sees the same
to the last bit: every look has its own stream of the seed.
"""

import hashlib
from collections.abc import Callable
from typing import ClassVar

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..estimation.views import FourViews
from ..geometry.arrays import Floats
from ..sensing.frames import MAX_LATENCY_LOOKS, average_frames, estimate_latency, noise_std
from ..simulation.arms import SimulatedArm, open_arm
from ..simulation.disturbances import (
    ArmDisturbance,
    ImageDisturbance,
    MatchDisturbance,
    SightDisturbance,
    any_active,
    disturb,
    disturbed_frames,
    mismatch_points,
)
from ..simulation.eyes import SimulatedEyes
from ..simulation.scene import Scene, load_scene
from .arm_and_eyes import SessionStart, require_in_workspace, round_to_degrees, to_degrees, workspace
from .self_calibration import Body
from .settings import USUAL_POINTS, Settings
from .snapshot import Images, Snapshot

# streams of the seed: the demonstrator, in each posture; the own body, at every motion and at rest; which points are
# swapped; the order of points without names
DEMO_LOOK, OWN_LOOK, REST_LOOK, MATCH, ORDER = 0, 1, 4, 5, 6
REST_LOOKS = 8  # images of the own body at rest that measure the noise

OpenEyes = Callable[[str, Scene, int], SimulatedEyes]  # sensor, scene, points


class SimulatedObserver:
    """How both bodies are seen. theta_rest: (m,) rad, the learner's start, where it measures the noise of images."""

    sees_any_posture: ClassVar[bool] = True  # False: only the posture where the arm is

    def __init__(self, eyes: SimulatedEyes, theta_rest: Floats):
        self._eyes, self._theta_rest = eyes, theta_rest
        self._demo: tuple[tuple, Images] | None = None  # cache: key, images
        self._demo_exact: tuple[bytes, Images] | None = None  # cache: posture, images without disturbances
        self._noise: tuple[tuple, float] | None = None
        self._visible: NDArray[np.bool_] | None = None

    def four_views(self, settings: Settings, theta: Floats, theta_demo: Floats, look: int) -> FourViews:
        """Look at both bodies. theta, theta_demo: (m,) rad; look: its number, of the own body."""
        demo, demo_visible = self.demo(settings, theta_demo)
        own, own_visible = self.own(settings, theta, look)
        visible = np.concatenate([demo_visible, own_visible], -1)
        if self._visible is None or self._visible.tobytes() != visible.tobytes():
            self._visible = visible  # mostly the same at every look: shared by all snapshots
        return FourViews(demo, own, self._visible)

    def own(self, settings: Settings, theta: Floats, look: int) -> Images:
        """Look at the own body. theta: (m,) rad."""
        return observed_images(settings, self._eyes.own_images(theta), OWN_LOOK, look)

    def demo(self, settings: Settings, theta_demo: Floats, look: int | None = None) -> Images:
        """The demonstrator's images: those of its first look, new ones only if it or a disturbance has changed.

        theta_demo: (m,) rad; look: number of a later look, which has its own noise.
        """
        amounts = settings.amounts(SightDisturbance)
        key = theta_demo.tobytes(), amounts, settings.frames, settings.seed, settings.matched
        if look is not None and any_active(settings.amounts(ImageDisturbance)):
            return self._demo_look(settings, theta_demo, look)
        if self._demo is None or self._demo[0] != key:
            self._demo = key, self._demo_look(settings, theta_demo)
        return self._demo[1]

    def fixed_noise_px(self) -> float:
        """Return the part of the noise that no averaging reduces: standard deviation [px]."""
        return float(self._eyes.noise_px)

    def _demo_look(self, settings: Settings, theta_demo: Floats, *look: int) -> Images:
        if self._demo_exact is None or self._demo_exact[0] != theta_demo.tobytes():
            self._demo_exact = theta_demo.tobytes(), self._eyes.demo_images(theta_demo)
        images = observed_images(settings, self._demo_exact[1], DEMO_LOOK, *stream_of(theta_demo), *look)
        points, visible = mismatch_points(settings.amounts(MatchDisturbance), *images, [settings.seed, MATCH])
        if not settings.matched:
            order = demo_order(settings, len(points))
            points, visible = points[order], visible[order]
        return points, visible

    def image_noise_std(self, settings: Settings) -> float:
        """Standard deviation of an averaged coordinate [px], measured in images of the own body at the start."""
        amounts = settings.amounts(ImageDisturbance)
        key = amounts, settings.seed, settings.frames
        if self._noise is None or self._noise[0] != key:
            measured = 0.0
            if any_active(amounts):
                images = self._eyes.own_images(self._theta_rest)
                looks = disturbed_frames(amounts, *images, [settings.seed, REST_LOOK], REST_LOOKS)
                measured = noise_std(*looks) / np.sqrt(settings.frames)
            self._noise = key, float(np.hypot(measured, self._eyes.noise_px))
        return self._noise[1]

    def wait_for_motion(self, now: Snapshot, theta: Floats) -> tuple[int, int | None]:
        """Count the looks until an image shows the motion from `now` to theta, (m,) rad, and estimate the latency.

        The first motion that shows gives the latency of all.
        """
        if now.lag is not None:
            return now.lag, now.lag

        def look(after: int) -> Images:
            return self.own(now.settings, theta if after >= now.settings.delay else now.theta, now.look + 1 + after)

        lag = estimate_latency((now.views.own, now.views.visible[:, 2:]), look, self.image_noise_std(now.settings))
        return MAX_LATENCY_LOOKS if lag is None else lag, lag


def demo_order(settings: Settings, count: int) -> NDArray[np.int_]:
    """The order in which the demonstrator's points come without names, (count,) indices."""
    return np.random.default_rng([settings.seed, ORDER]).permutation(count)


def stream_of(theta: Floats) -> list[int]:
    """Stream of a posture, (m,) rad: its angles in millionths of a degree, so that other postures have other noise."""
    return (np.floor(np.degrees(theta) * 1e6 + 0.5).astype(np.int64) % 2**32).tolist()


def observed_images(settings: Settings, images: Images, *stream: int) -> Images:
    """The images that the learner sees: disturbed, and averaged over `Settings.frames`. stream: of the seed."""
    seed, amounts = [settings.seed, *stream], settings.amounts(ImageDisturbance)
    if settings.frames == 1 or not any_active(amounts):
        return disturb(amounts, *images, seed)
    return average_frames(*disturbed_frames(amounts, *images, seed, settings.frames))


class SimulatedRobot:
    """The learner's arm, of m joints, and its view of the demonstrator. Postures are (m,) rad."""

    def __init__(self, eyes: SimulatedEyes, arm: SimulatedArm, scene: Scene):
        self.eyes, self.arm, self._scene = eyes, arm, scene
        self.lower, self.upper = scene.lower, scene.upper  # asked for at every motion

    def require_posture(self, theta: ArrayLike, whose: str) -> Floats:
        """Return a copy of theta, (m,) rad. Raises ValueError for a wrong count, NaN or limits exceeded."""
        return self._scene.require_posture(theta, whose)

    def body(self, settings: Settings) -> Body:
        """What a calibration with these settings would hold for."""
        scene = self._scene
        placed = repr(list(map(tuple, settings.body_points))) if settings.body_points else ""
        return Body(
            robot=scene.robot,
            joints=tuple(scene.moving_joints),
            span_deg=tuple(round(high - low, 6) for low, high in scene.range_deg),
            points=settings.points,
            sensor=settings.sensor,
            undistort=scene.head.undistort,
            layout=hashlib.sha256(placed.encode()).hexdigest()[:12] if placed else "",
        )

    def demonstrator(self, settings: Settings) -> Floats:
        """The demonstrator's posture by the settings, (m,) rad. Raises ValueError for one beyond its limits."""
        return _demonstrator(settings, self._scene)

    def settle_demonstrator(self, theta_demo: Floats) -> Floats:
        """Move the demonstrator to a posture. Return where it comes to rest, (m,) rad each."""
        return self.arm.settle(theta_demo)

    def drive(self, settings: Settings, theta: Floats, sent: Floats, commanded: Floats) -> Floats:
        """Move the learner's arm. Return where it comes to rest, (m,) rad.

        settings: give the disturbances; theta, sent, commanded: (m,) rad, where it is, was last sent and is sent now.
        """
        return self.arm.drive(settings.amounts(ArmDisturbance), settings.start_rad, theta, sent, commanded)

    def revisit(self, settings: Settings, sent: Floats, commanded: Floats) -> None:
        """Nothing to do: a simulated arm has no posture of its own."""

    def observer(self, theta_rest: Floats) -> SimulatedObserver:
        """An observer of both bodies, which measures the noise with the arm at rest at theta_rest, (m,) rad."""
        return SimulatedObserver(self.eyes, theta_rest)


class SimulatedRobotOpener:
    """Brings both arms to their first postures. Eyes and arm serve until what they are made of changes."""

    def __init__(self, open_eyes: OpenEyes):
        self._open_eyes = open_eyes
        self._opened: tuple[tuple[str, Scene, int, str], SimulatedRobot] | None = None

    def __call__(self, settings: Settings, sent: Floats | None) -> tuple[SimulatedRobot, SessionStart]:
        scene = load_scene(settings.scene, settings.robot, settings.joints, settings.undistort, settings.body_points)
        settings, demo, start = _complete(settings, scene)
        key = settings.sensor, scene, settings.points, settings.dynamics
        if self._opened is None or self._opened[0] != key:
            eyes = self._open_eyes(settings.sensor, scene, settings.points)
            self._opened = key, SimulatedRobot(eyes, open_arm(settings.dynamics, scene), scene)
        learner = self._opened[1]
        demo, standing = learner.arm.settle(demo), learner.arm.settle(start)
        return learner, SessionStart(settings, start, standing, demo, workspace(settings, scene.lower, scene.upper))


def complete(settings: Settings) -> Settings:
    """The settings as a session has them that begins with these: completed from the scene.

    Raises ValueError as `Session` does.
    """
    scene = load_scene(settings.scene, settings.robot, settings.joints, body_points=settings.body_points)
    return _complete(settings, scene)[0]


def _complete(settings: Settings, scene: Scene) -> tuple[Settings, Floats, Floats]:
    """The completed settings, and the postures of the demonstrator and of the learner's start, (m,) rad."""
    anyway = settings.points == USUAL_POINTS or settings.body_points is not None
    points = scene.layout_near(USUAL_POINTS) if anyway else settings.points
    start_deg = scene.start_deg if settings.start_deg is None else settings.start_deg
    demo = round_to_degrees(_demonstrator(settings, scene), scene.lower, scene.upper)
    low, high = workspace(settings, scene.lower, scene.upper)
    start = require_in_workspace(
        scene.require_posture(np.radians(start_deg), "learner's start"), low, high, "learner's start"
    )
    start = round_to_degrees(start, low, high)
    fields = {"points": points, "demonstrator_deg": to_degrees(demo), "start_deg": to_degrees(start)}
    return msgspec.structs.replace(settings, **fields), demo, start


def _demonstrator(settings: Settings, scene: Scene) -> Floats:
    """(m,) rad, from the settings, or else the scene. Raises ValueError for a posture beyond its limits."""
    if settings.demonstrator_deg is None:
        posture_deg = np.array(scene.posture_deg)[scene.moving]
    else:
        posture_deg = np.array(settings.demonstrator_deg, float)
    return scene.require_posture(np.radians(posture_deg), "demonstrator's")

"""What a learner gets to see of two bodies: so many frames of each as are set, disturbed, merged, and perhaps late.

With equal seeds it sees the same to the last bit. Every look has a stream of the seed for itself.
"""

import hashlib
from collections.abc import Callable, Sequence
from typing import ClassVar

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..estimation.views import FourViews
from ..sensing import frames
from ..sensing.frames import MAX_LATENCY_LOOKS, estimate_latency, noise_std
from ..simulation.disturbances import (
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
from .embodiment import SessionStart, degrees, round_to_degrees, within, workspace
from .self_calibration import Body
from .settings import USUAL_POINTS, BodyPoint, Settings
from .snapshot import Snapshot

DEMO_LOOK, OWN_LOOK, REST_LOOK, MATCH = 0, 1, 4, 5  # streams of the seed: demonstrator, once; own body, at every
# motion, at rest; which of the demonstrator's points are swapped
REST_LOOKS = 8  # images of the own body at rest, from which the learner knows their noise

Images = tuple[NDArray, NDArray]  # of one body in a pair of views: points (N, 4) px, visible (N, 2) bool


class SimulatedObserver:
    """Looks with `eyes`. theta_rest: (m,) rad, the learner's start, where it measures the noise of its images."""

    anywhere: ClassVar[bool] = True

    def __init__(self, eyes: SimulatedEyes, theta_rest: NDArray):
        self._eyes, self._theta_rest = eyes, theta_rest
        self._demo: tuple[tuple, Images] | None = None  # what it depends on, what was seen
        self._noise: tuple[tuple, float] | None = None
        self._visible: NDArray | None = None

    def four_views(self, settings: Settings, theta: NDArray, theta_demo: NDArray, look: int) -> FourViews:
        """theta, theta_demo: (m,) rad; look: which one it is, of the own body."""
        demo, demo_visible = self.demo(settings, theta_demo)
        own, own_visible = self.own(settings, theta, look)
        visible = np.concatenate([demo_visible, own_visible], -1)
        if self._visible is None or self._visible.tobytes() != visible.tobytes():
            self._visible = visible  # mostly all, at every look: kept once
        return FourViews(demo, own, self._visible)

    def own(self, settings: Settings, theta: NDArray, look: int) -> Images:
        """The own body, looked at anew. theta: (m,) rad."""
        return average_frames(settings, self._eyes.own_images(theta), OWN_LOOK, look)

    def demo(self, settings: Settings, theta_demo: NDArray) -> Images:
        """The demonstrator, looked at anew only when it, or its disturbance, has changed. theta_demo: (m,) rad."""
        key = theta_demo.tobytes(), settings.amounts(SightDisturbance), settings.frames, settings.seed
        if self._demo is None or self._demo[0] != key:
            images = average_frames(settings, self._eyes.demo_images(theta_demo), DEMO_LOOK)
            self._demo = key, mismatch_points(settings.amounts(MatchDisturbance), *images, [settings.seed, MATCH])
        return self._demo[1]

    def image_noise_std(self, settings: Settings) -> float:
        """Standard deviation of a coordinate, as averaged, from single images of the own body at the start, px."""
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

    def wait(self, now: Snapshot, theta: NDArray) -> tuple[int, int | None]:
        """After a motion from `now` to theta, (m,) rad → for how many looks to wait until an image shows it, and what
        is known of the lag, in looks: None if the motion does not show.

        Nobody tells how late images come: the first motion that shows does.
        """
        if now.lag is not None:
            return now.lag, now.lag

        def look(after: int) -> Images:
            return self.own(now.settings, theta if after >= now.settings.delay else now.theta, now.look + 1 + after)

        lag = estimate_latency((now.views.own, now.views.visible[:, 2:]), look, self.image_noise_std(now.settings))
        return MAX_LATENCY_LOOKS if lag is None else lag, lag


def average_frames(settings: Settings, images: Images, *stream: int) -> Images:
    """What is seen of images: as many frames as are set, disturbed and merged. stream: of the seed."""
    seed, amounts = [settings.seed, *stream], settings.amounts(ImageDisturbance)
    if settings.frames == 1 or not any_active(amounts):
        return disturb(amounts, *images, seed)
    return frames.average_frames(*disturbed_frames(amounts, *images, seed, settings.frames))


OpenEyes = Callable[[str, Scene, int], SimulatedEyes]


class SimulatedRobot:
    """See `protocol.Embodiment`."""

    def __init__(self, eyes: SimulatedEyes, scene: Scene):
        self.eyes, self._scene = eyes, scene
        self.lower, self.upper = scene.lower, scene.upper  # asked for at every motion

    def require_posture(self, theta: ArrayLike, whose: str) -> NDArray:
        return self._scene.require_posture(theta, whose)

    def body(self, settings: Settings) -> Body:
        scene = self._scene
        return Body(
            robot=scene.robot,
            joints=tuple(scene.moving_joints),
            span_deg=tuple(round(high - low, 6) for low, high in scene.range_deg),
            points=settings.points,
            sensor=settings.sensor,
            undistort=scene.head.undistort,
            layout="" if settings.body_points is None else _digest(settings.body_points),
        )

    def demonstrator(self, settings: Settings) -> NDArray:
        return _demonstrator(settings, self._scene)

    def pose(self, theta_demo: NDArray) -> NDArray:
        return self.eyes.settle(theta_demo)

    def drive(self, settings: Settings, theta: NDArray, sent: NDArray, commanded: NDArray) -> NDArray:
        return self.eyes.drive(settings, theta, sent, commanded)

    def revisit(self, settings: Settings, sent: NDArray, commanded: NDArray) -> None:
        """A simulated arm is wherever it is looked at."""

    def looks(self, theta_rest: NDArray) -> SimulatedObserver:
        return SimulatedObserver(self.eyes, theta_rest)


def _digest(points: Sequence[BodyPoint]) -> str:
    return hashlib.sha256(repr([tuple(point) for point in points]).encode()).hexdigest()[:12]


class SimulatedRobotOpener:
    """See `protocol.Opener`. open_eyes(camera, scene, points): what the learner looks with and moves by; the same ones
    serve until any of these changes."""

    def __init__(self, open_eyes: OpenEyes):
        self._open_eyes = open_eyes
        self._opened: tuple[tuple[str, Scene, int], SimulatedRobot] | None = None

    def __call__(self, settings: Settings, sent: NDArray | None) -> SessionStart:
        scene = load_scene(settings.scene, settings.robot, settings.joints, settings.undistort, settings.body_points)
        settings, demo, start = _complete(settings, scene)
        wanted = settings.sensor, scene, settings.points
        if self._opened is None or self._opened[0] != wanted:
            self._opened = wanted, SimulatedRobot(self._open_eyes(*wanted), scene)
        learner = self._opened[1]
        demo, standing = learner.eyes.settle(demo), learner.eyes.settle(start)
        return SessionStart(settings, learner, start, standing, demo, workspace(settings, scene.lower, scene.upper))


def complete(settings: Settings) -> Settings:
    """As a session has them that begins with these: with what the scene says where they leave it open.

    Raises ValueError as `Session` does.
    """
    scene = load_scene(settings.scene, settings.robot, settings.joints, body_points=settings.body_points)
    return _complete(settings, scene)[0]


def _complete(settings: Settings, scene: Scene) -> tuple[Settings, NDArray, NDArray]:
    """And the postures of the demonstrator and of the learner's start, (m,) rad."""
    anyway = settings.points == USUAL_POINTS or settings.body_points is not None
    points = scene.layout_near(USUAL_POINTS) if anyway else settings.points
    start_deg = scene.start_deg if settings.start_deg is None else settings.start_deg
    demo = round_to_degrees(_demonstrator(settings, scene), scene.lower, scene.upper)
    low, high = workspace(settings, scene.lower, scene.upper)
    start = within(scene.require_posture(np.radians(start_deg), "learner's start"), low, high, "learner's start")
    start = round_to_degrees(start, low, high)
    fields = {"points": points, "demonstrator_deg": degrees(demo), "start_deg": degrees(start)}
    return msgspec.structs.replace(settings, **fields), demo, start


def _demonstrator(settings: Settings, scene: Scene) -> NDArray:
    """(m,) rad, of the settings or else the scene's own. Raises ValueError if it is out of limits."""
    if settings.demonstrator_deg is None:
        posture_deg = np.array(scene.posture_deg)[scene.moving]
    else:
        posture_deg = np.array(settings.demonstrator_deg, float)
    return scene.require_posture(np.radians(posture_deg), "demonstrator's")

"""A learner in a simulated scene: its limits are the scene's, and the truth is known to viewers."""

import hashlib
from collections.abc import Callable, Sequence

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...simulation.eyes import SimulatedEyes
from ...simulation.scene import Scene, load_scene
from ..body_image import Body
from ..looking import Observer
from ..settings import USUAL_POINTS, BodyPoint, Settings
from .motion_limits import within, workspace
from .protocol import Beginning

OpenEyes = Callable[[str, Scene, int], SimulatedEyes]


class InScene:
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
            camera=settings.camera,
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

    def looks(self, theta_rest: NDArray) -> Observer:
        return Observer(self.eyes, theta_rest)


def _digest(points: Sequence[BodyPoint]) -> str:
    return hashlib.sha256(repr([tuple(point) for point in points]).encode()).hexdigest()[:12]


class SceneOpener:
    """See `protocol.Opener`. open_eyes(camera, scene, points): what the learner looks with and moves by; the same ones
    serve until any of these changes."""

    def __init__(self, open_eyes: OpenEyes):
        self._open_eyes = open_eyes
        self._opened: tuple[tuple[str, Scene, int], InScene] | None = None

    def __call__(self, settings: Settings, sent: NDArray | None) -> Beginning:
        scene = load_scene(settings.scene, settings.robot, settings.joints, settings.undistort, settings.body_points)
        settings, demo, start = _complete(settings, scene)
        wanted = settings.camera, scene, settings.points
        if self._opened is None or self._opened[0] != wanted:
            self._opened = wanted, InScene(self._open_eyes(*wanted), scene)
        learner = self._opened[1]
        demo, standing = learner.eyes.settle(demo), learner.eyes.settle(start)
        return Beginning(settings, learner, start, standing, demo, workspace(settings, scene.lower, scene.upper))


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
    demo = told(_demonstrator(settings, scene), scene.lower, scene.upper)
    low, high = workspace(settings, scene.lower, scene.upper)
    start = within(scene.require_posture(np.radians(start_deg), "learner's start"), low, high, "learner's start")
    start = told(start, low, high)
    fields = {"points": points, "demonstrator_deg": degrees(demo), "start_deg": degrees(start)}
    return msgspec.structs.replace(settings, **fields), demo, start


def _demonstrator(settings: Settings, scene: Scene) -> NDArray:
    """(m,) rad, of the settings or else the scene's own. Raises ValueError if it is out of limits."""
    if settings.demonstrator_deg is None:
        posture_deg = np.array(scene.posture_deg)[scene.moving]
    else:
        posture_deg = np.array(settings.demonstrator_deg, float)
    return scene.require_posture(np.radians(posture_deg), "demonstrator's")


def told(theta: NDArray, lower: NDArray, upper: NDArray) -> NDArray:
    """A posture within its limits, (m,) rad each, as settings that tell of it in degrees have it, to the last bit: with
    them a run is to repeat itself."""
    return np.clip(np.radians(degrees(theta)), lower, upper)


def degrees(theta: NDArray) -> tuple[float, ...]:
    """rad → degrees, without what conversion adds."""
    return tuple(float(angle) for angle in np.round(np.degrees(theta), 9))

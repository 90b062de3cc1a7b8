"""Of the step in which the eyes move back: how far the smallest E is from the demonstrator, and what depth has to do
with it."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from viewimit.estimation.views import FourViews
from viewimit.loop.session import Session
from viewimit.simulation.camera import Camera

from ..stage import Stage
from ..works.minimum import Biases
from .measure import Measure

TIMES_ASKED = 10.0  # the distance


def _bias(stage: Stage) -> float:
    """Degrees from the smallest E to the demonstrator here, the joint that is farthest."""
    found = stage.made.get("minimum")
    return np.nan if found is None else float(np.degrees(np.abs(found - stage.moment.theta_demo).max()))


def _bias_at(times: float) -> Callable[[Stage], float]:
    """By the session's transfer, at so many times the distance."""

    def of(stage: Stage) -> float:
        found: Biases | None = stage.made.get("biases")
        if found is None:
            return np.nan
        return float(found.degrees[stage.session.settings.transfer][np.flatnonzero(found.times == times)[0]])

    return of


def depth_taken_out(session: Session, theta_demo: NDArray, theta: NDArray) -> FourViews:
    """What the same eyes would see if each showed an arm as if all of it were as far away as its points' middle: affine
    cameras, which differ from the real ones in depth alone."""
    world = session.world
    demo = _affine(world.demo_cameras, world.points_world(theta_demo, world.T_world_demo))
    own = _affine(world.own_cameras, world.points_world(theta, world.T_world_own))
    return FourViews(demo, own, np.ones((len(demo), 4), bool))


def _affine(cameras: tuple[Camera, Camera], points: NDArray) -> NDArray:
    """(N, 4) px: each camera's projection to first order about the middle of the points, (N, 3) m in the world."""
    middle = points.mean(0)
    images = []
    for camera in cameras:
        aside = 1e-4 * np.eye(3)
        near = np.concatenate([middle + aside, middle - aside, middle[None]])
        seen = camera.project(near.T)[0].T
        slope = (seen[:3] - seen[3:6]) / 2e-4  # (3, 2) px a metre
        images.append(seen[6] + (points - middle) @ slope)
    return np.concatenate(images, 1)


def _E_without_depth(stage: Stage) -> float:
    """px², at this moment's postures."""
    moment = stage.moment
    if moment.transfer is None:
        return np.nan
    views = depth_taken_out(stage.session, moment.theta_demo, moment.theta)
    used = FourViews(views.demo[moment.usable], views.own[moment.usable], views.visible[moment.usable])
    return float(moment.fit(used).conflict(used))


MEASURES: Mapping[str, Measure] = {
    "bias": Measure(_bias, "°"),
    "bias at once the distance": Measure(_bias_at(1.0), "°", 1),
    "bias at ten times the distance": Measure(_bias_at(TIMES_ASKED), "°"),
    "E without depth": Measure(_E_without_depth, " px²"),
}

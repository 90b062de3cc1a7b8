"""Where E is least when images are noisy: another posture each time, and how far these lie apart.

All runs are searched at once by damped Gauss-Newton steps from the demonstrator's own posture, so it is for people, not
for a servo.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..estimation.views import FourViews
from ..simulation.world import World

ROUNDS = 6
STEP = 1e-3  # rad, of the differences
DAMPING, LESS, MORE = (
    1e-3,
    0.2,
    8.0,
)  # of the mean curvature, at first; times that after a step that helped, that did not


def scatter(
    world: World,
    fit: Callable,
    theta_demo: ArrayLike,
    noise_px: float,
    frames: int,
    runs: int,
    rng: np.random.Generator,
    of_demo: bool = True,
) -> NDArray:
    """The learner's postures with the smallest E, (runs, m) rad, about the demonstrator's, theta_demo, (m,) rad.

    noise_px: standard deviation of a coordinate in every image, of which `frames` are averaged; of_demo: whether the
    demonstrator's images have noise too. Raises ValueError for a posture at which a point is out of sight.
    """
    theta_demo = np.asarray(theta_demo, float)
    demo, visible = world.demo_images(theta_demo)
    if not (visible.all() and world.own_images(theta_demo)[1].all()):
        raise ValueError("a scatter needs all points in all four images at the demonstrator's posture")

    def noise() -> NDArray:
        return rng.normal(0.0, noise_px, (runs, frames, *demo.shape)).mean(1)

    own_noise = noise()
    demos = demo + (noise() if of_demo else np.zeros_like(own_noise))

    def residual_at(theta: NDArray) -> NDArray:
        views = FourViews(demos, world.own_images(theta.T)[0] + own_noise, np.ones(1, bool))
        return fit(views).residual(views).reshape(runs, -1)

    return _least(residual_at, np.tile(theta_demo, (runs, 1)), world.scene.lower, world.scene.upper)


def _least(residual_at: Callable[[NDArray], NDArray], theta: NDArray, low: NDArray, high: NDArray) -> NDArray:
    """residual_at: (runs, m) rad → (runs, n) px, each run its own; theta: the starts."""
    e, m = residual_at(theta), theta.shape[1]
    damping = np.full(len(theta), DAMPING)
    for _ in range(ROUNDS):
        J = np.stack([(residual_at(theta + STEP * aside) - e) / STEP for aside in np.eye(m)], -1)
        normal, gradient = np.einsum("rni,rnj->rij", J, J), np.einsum("rni,rn->ri", J, e)
        damped = normal + (damping * np.trace(normal, axis1=1, axis2=2) / m)[:, None, None] * np.eye(m)
        tried = np.clip(theta - np.linalg.solve(damped, gradient[..., None])[..., 0], low, high)
        e_tried = residual_at(tried)
        better = np.square(e_tried).sum(-1) < np.square(e).sum(-1)
        theta, e = np.where(better[:, None], tried, theta), np.where(better[:, None], e_tried, e)
        damping *= np.where(better, LESS, MORE)
    return theta

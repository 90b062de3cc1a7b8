"""A trust-region servo on a linear image model, ŷ(θ) = y_c + J (θ - c), with Broyden's updates of J (Broyden 1965).

The servo learns the images, not E: the residual is a known function of images, so E can be predicted at any posture.
One probe of each joint gives a first J. Then the arm goes to the minimum of the predicted E inside a trust region, and
each motion improves J. The region is resized by the ratio of the actual to the predicted reduction of E (Nocedal and
Wright, Algorithm 4.1). The best posture visited is its centre c; the arm never goes back to it. The servo never claims
to have converged: that the next step is short is no evidence.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import ResidualFunction
from ..estimation.transfers.transfer import conflict
from .image_jacobian import MIN_STEP_RAD, BroydenModel
from .least_squares import minimise
from .observation import Observation, Visit, probe_motion
from .status import ServoStatus

INITIAL_RADIUS, MAX_RADIUS, MIN_RADIUS = np.radians((25.0, 45.0, 0.02))
MIN_REDUCTION = 0.01  # share of E: if a step cut short by the region predicts more, the servo has made no progress
SHRINK_BELOW, GROW_ABOVE = 0.25, 0.6  # ratios of actual to predicted reduction


@dataclass(frozen=True)
class BroydenState:
    """State of `Broyden`."""

    model: BroydenModel  # of the own images
    best: Visit  # with the smallest E
    radius: float  # rad: of the trust region, per joint
    joints_to_probe: tuple[int, ...]
    predicted_reduction: float | None = None  # px²: of E by the last motion; None after a probe
    best_E: float | None = None  # px²; None where it must be evaluated again
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False
    reductions: tuple[float, float] | None = None  # px²: predicted and actual, of the motion judged last


class Broyden:
    """Trust-region servo on images with Broyden's updates."""

    def start(self, observation: Observation) -> BroydenState:
        """Return the state before the first motion."""
        model = BroydenModel.start(observation)
        joints = tuple(range(len(observation.displacement)))
        return BroydenState(model, model.last, float(INITIAL_RADIUS), joints)

    def retarget(self, state: BroydenState, observation: Observation) -> BroydenState:
        """Keep the image model; reset the region and the prediction, which were about another E."""
        return replace(
            state, radius=float(INITIAL_RADIUS), predicted_reduction=None, best_E=None, status=ServoStatus.MOVING
        )

    def step(
        self, state: BroydenState, observation: Observation, residuals: ResidualFunction
    ) -> tuple[BroydenState, NDArray[np.float64]]:
        """Return the next state and the motion, (m,) rad."""
        state = _update_region(_update_model(state, observation), observation.E, residuals)
        if state.joints_to_probe:
            return _probe(state, observation)
        centre = state.best.displacement
        low = np.maximum(observation.lower, centre - state.radius)
        high = np.minimum(observation.upper, centre + state.radius)
        shape, at_centre = state.best.own.shape, _known_images(state.model, state.best.own)
        per_rad = state.model.jacobian.reshape(-1, len(centre)).T

        def predicted_residuals(theta: NDArray[np.float64]) -> NDArray[np.float64]:
            return residuals(at_centre + ((theta - centre) @ per_rad).reshape(theta.shape[:-1] + shape))

        found = minimise(predicted_residuals, centre[None], low, high)
        reduction = found.E_first - found.E
        step = found.theta - observation.displacement
        if np.max(np.abs(step)) < MIN_STEP_RAD:
            # whether the region, and not the model, has made the step short
            is_cut = state.radius < 2 * MIN_STEP_RAD and reduction > MIN_REDUCTION * observation.E
            status = ServoStatus.NO_PROGRESS if is_cut else ServoStatus.SETTLED
            return replace(state, predicted_reduction=None, status=status, probe=False), np.zeros_like(step)
        return replace(state, predicted_reduction=reduction, status=ServoStatus.MOVING, probe=False), step


def _update_model(state: BroydenState, observation: Observation) -> BroydenState:
    """Learn from the last motion, and predict the points that the best visit did not show."""
    model = state.model.update(observation, 0.0) if state.probe else state.model.update(observation)
    best = state.best
    best = replace(best, own=np.where(np.isnan(best.own), model.predict(best.displacement), best.own))
    return replace(state, model=model, best=best)


def _update_region(state: BroydenState, E_here: float, residuals: ResidualFunction) -> BroydenState:
    """Keep the better of the best and the last visit, and resize the region by the ratio of the reductions.

    If E has changed by itself, or points are hidden, E at both visits is evaluated again on the images: otherwise it
    would be of different points.
    """
    here, E_best = state.model.last, state.best_E
    if E_best is None or not (here.seen.all() and state.best.seen.all()):
        images = _known_images(state.model, np.stack([state.best.own, here.own]))
        E_best, E_here = map(float, conflict(residuals(images)))
    radius, reductions = state.radius, None
    if state.predicted_reduction is not None:
        reductions = state.predicted_reduction, E_best - E_here
        ratio = (E_best - E_here) / max(state.predicted_reduction, 1e-12)
        step = np.max(np.abs(here.displacement - state.best.displacement))
        if ratio < SHRINK_BELOW:
            radius = max(0.4 * step, MIN_RADIUS)
        elif ratio > GROW_ABOVE and step > 0.8 * radius:
            radius = min(2 * radius, MAX_RADIUS)
    best, best_E = (here, E_here) if E_here <= E_best else (state.best, E_best)
    return replace(state, best=best, best_E=best_E, radius=float(radius), reductions=reductions)


def _known_images(model: BroydenModel, own: NDArray[np.float64]) -> NDArray[np.float64]:
    """Images (..., N, 4) px, NaN for points of whose motion the model knows too little."""
    return np.where(model.rarely_seen[:, None], np.nan, own)


def _probe(state: BroydenState, observation: Observation) -> tuple[BroydenState, NDArray[np.float64]]:
    joint, *rest = state.joints_to_probe
    state = replace(state, joints_to_probe=tuple(rest), predicted_reduction=None, status=ServoStatus.MOVING, probe=True)
    return state, probe_motion(joint, observation)

"""A servo that learns the image, not E: ŷ(θ) = y_c + J (θ - c), J by Broyden's updates.

The residual is a known function of images, so every candidate is judged on the images it is predicted to give.
One probe a joint makes a first J; then the argmin of the predicted E inside a trust region is visited, the E then
measured judges the region, and the motion itself improves J (Broyden 1965). The best posture visited is
the centre c; the arm never drives back to it. It never claims to have converged: that the next step is small is no
evidence.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..estimation.equations import Equation, angles, short
from ..estimation.residuals import ResidualFunction, conflict
from .image_model import ImageModel
from .least_squares import minimise
from .observation import Observation, Visit, probe_of
from .servo import Moment
from .status import ServoStatus

_LAW = r"\hat{𝐲}(𝛉)=𝐲_c+𝐉\,(𝛉-𝐜),\quad 𝛉^{*}=\underset{|𝛉-𝐜|_{\infty}\le D}{\mathrm{arg\,min}}\;E(\hat{𝐲}(𝛉))"
FIRST_RADIUS, MAX_RADIUS, MIN_RADIUS = np.radians((25.0, 45.0, 0.02))
DONE_STEP = np.radians(0.1)  # a motion shorter than this is not worth making
GAIN_LEFT = 0.01  # share of E that a step cut short by the region must still promise to count as stalled
SHRINK_BELOW, GROW_ABOVE = 0.25, 0.6  # ratios of actual to predicted decrease


@dataclass(frozen=True)
class BroydenState:
    """model: of the own images; best: the visit with the smallest E; radius: rad; promised: decrease of E predicted
    for the motion just made, None after a probe; judged: decreases of E promised and found, px², of the motion
    judged last; best_E: px², None where it must be asked for; probes: joints still to probe."""

    model: ImageModel
    best: Visit
    radius: float
    probes: tuple[int, ...]
    promised: float | None = None
    best_E: float | None = None
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False
    judged: tuple[float, float] | None = None


@dataclass(frozen=True)
class Broyden:
    """See the module. It has no constants to tune beyond the module's."""

    title = "Broyden on images"
    assumes = "That the images follow the joints nearly linearly; what E would be is asked, not tried."
    limitations = "Flat valleys and missing points: it may stop degrees away, and does not know whether it has arrived."
    slow = False
    predicts = False
    stored = (BroydenState, ImageModel, Visit)

    def start(self, seen: Observation) -> BroydenState:
        model = ImageModel.start(seen)
        return BroydenState(model, model.last, float(FIRST_RADIUS), tuple(range(len(seen.displacement))))

    def retarget(self, state: BroydenState, seen: Observation) -> BroydenState:
        """What was learned of the own images stays; the region and the promise were about another E."""
        return replace(state, radius=float(FIRST_RADIUS), promised=None, best_E=None, status=ServoStatus.MOVING)

    def step(self, state: BroydenState, seen: Observation, residuals: ResidualFunction) -> tuple[BroydenState, NDArray]:
        state = _judge(_learn(state, seen), seen.E, residuals)
        if state.probes:
            return _probe(state, seen)
        low = np.maximum(seen.lower, state.best.displacement - state.radius)
        high = np.minimum(seen.upper, state.best.displacement + state.radius)
        centre = state.best.displacement

        shape, told = state.best.own.shape, _told(state.model, state.best.own)
        per_rad = state.model.jacobian.reshape(-1, len(centre)).T

        def residual_at(theta: NDArray) -> NDArray:
            return residuals(told + ((theta - centre) @ per_rad).reshape(theta.shape[:-1] + shape))

        found = minimise(residual_at, centre[None], low, high)
        promised = found.E_first - found.E
        step = found.theta - seen.displacement
        if np.max(np.abs(step)) < DONE_STEP:
            bounded = state.radius < 2 * DONE_STEP and promised > GAIN_LEFT * seen.E
            # the region, not the model, made the step short
            status = ServoStatus.NO_PROGRESS if bounded else ServoStatus.SETTLED
            return replace(state, promised=None, status=status, probe=False), np.zeros_like(step)
        return replace(state, promised=promised, status=ServoStatus.MOVING, probe=False), step

    def equations(self, state: BroydenState | None, moment: Moment) -> tuple[Equation, ...]:
        if state is None:
            return (Equation("", "no motion yet", _LAW, wide=True),)
        if state.probe:
            note = f"This motion, ({angles(moment.moved)}), is a probe: it teaches a first column of J."
        else:
            note = f"D = {np.degrees(state.radius):.3g}°. {_outcome(state, moment)}"
        return (Equation("", "servo: the images are learned, not E", _LAW, note=note),)

    def says(self, state: BroydenState, status: ServoStatus) -> str:
        if status == ServoStatus.MOVING:
            return "a probe, to learn how the images move" if state.probe else ""
        return f"next step under {np.degrees(DONE_STEP):g}°" if status == ServoStatus.SETTLED else ""


def _outcome(state: BroydenState, moment: Moment) -> str:
    """What the last motion has promised and brought; where points are missing, E at both ends is of others, and only
    the motion before has been judged, on points known at both."""
    if moment.status in (ServoStatus.SETTLED, ServoStatus.NO_PROGRESS):
        return f"The next step would be below {np.degrees(DONE_STEP):g}°: the servo rests."
    if state.promised is None or state.best_E is None or not np.isfinite(moment.E):
        return ""
    made = f"θ* − c = ({angles(moment.displacement - state.best.displacement)}). "
    promised = f"E was to fall by <b>{short(state.promised)}</b>"
    if not (moment.seen.all() and state.best.seen.all()):
        before = "" if state.judged is None else _fell(*state.judged)
        return f"{made}{promised} px².{before}"
    return f"{made}{promised}, and fell by <b>{short(state.best_E - moment.E)}</b> px²."


def _fell(promised: float, found: float) -> str:
    return f" Before: to fall by <b>{short(promised)}</b>, fell by <b>{short(found)}</b> px²."


def _learn(state: BroydenState, seen: Observation) -> BroydenState:
    """From the last motion; what the best visit did not show is completed by what is seen now."""
    model = state.model.learn(seen, 0.0) if state.probe else state.model.learn(seen)
    best = state.best
    best = replace(best, own=np.where(np.isnan(best.own), model.predict(best.displacement), best.own))
    return replace(state, model=model, best=best)


def _judge(state: BroydenState, E_here: float, residuals: ResidualFunction) -> BroydenState:
    """Keep the better of the best and the last visit, and size the region by how true the promise was.

    Where E changed by itself, or points are missing so that E is of others each time, both are judged anew on
    their images.
    """
    here, E_best = state.model.last, state.best_E
    if E_best is None or not (here.seen.all() and state.best.seen.all()):
        E_best, E_here = map(float, conflict(residuals(_told(state.model, np.stack([state.best.own, here.own])))))
    radius, judged = state.radius, None
    if state.promised is not None:
        judged = state.promised, E_best - E_here
        ratio = (E_best - E_here) / max(state.promised, 1e-12)
        step = np.max(np.abs(here.displacement - state.best.displacement))
        if ratio < SHRINK_BELOW:
            radius = max(0.4 * step, MIN_RADIUS)
        elif ratio > GROW_ABOVE and step > 0.8 * radius:
            radius = min(2 * radius, MAX_RADIUS)
    best, best_E = (here, E_here) if E_here <= E_best else (state.best, E_best)
    return replace(state, best=best, best_E=best_E, radius=float(radius), judged=judged)


def _told(model: ImageModel, own: NDArray) -> NDArray:
    """Images (..., N, 4) px, NaN for points of which the model knows too little."""
    return np.where(model.rarely_seen[:, None], np.nan, own)


def _probe(state: BroydenState, seen: Observation) -> tuple[BroydenState, NDArray]:
    joint, *rest = state.probes
    return replace(state, probes=tuple(rest), promised=None, status=ServoStatus.MOVING, probe=True), probe_of(
        joint, seen
    )

"""Control by inference in a learned generative model, after Gothoskar et al. 2020.

The model generates the own images from the joint displacements θ: a chain of joints turns the points of the body, and
two projective cameras see them. Nothing of it is known before: the axis of each joint, the places of the points, the
link of each, and both cameras are learned together from the images of all visits. The point X, which ℓ joints move, is
seen by the camera [A t; v 1] at

    y(θ) = (A x + t) / (1 + v·x),     x = T_1(θ_1) ... T_ℓ(θ_ℓ) X,     T_j a turn about the axis a_j through c_j.

The law makes a probe of each joint. Then it fits the model by least squares, infers the posture whose predicted images
agree best with the demonstrator, and goes there. What it sees there is another visit to learn from. It settles where
the inferred posture is the present one.

References
----------
Gothoskar et al., "Learning a generative model for robot control using visual feedback", 2020, arXiv:2003.04474.
Tomasi and Kanade, "Shape and motion from image streams under orthography", IJCV 9(2), 1992.
Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, chapter 3: products of exponentials.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, islice

import numpy as np
from numpy.typing import NDArray

from viewimit.estimation.residuals import ResidualFunction
from viewimit.estimation.transfers.transfer import conflict
from viewimit.geometry.kinematics.bundle import levenberg_marquardt
from viewimit.servo.image_jacobian import MIN_STEP_RAD
from viewimit.servo.least_squares import minimise
from viewimit.servo.observation import Observation, ScaledResiduals, Visit, in_units, probe_motion, repeat_xy, unit_of
from viewimit.servo.status import ServoStatus

T_AT, V_AT, N_CAMERA_PARAMETERS = 12, 16, 22  # A (4 x 3), then t (4) and v (2 x 3) of both cameras, where they begin
MIN_DEPTH = 0.05  # least denominator 1 + v·x, relative to that of the mean point
PERSPECTIVE_STD = 1.0  # of v, a priori: the cameras are affine where the images do not say otherwise
N_STARTS = 4  # initial values of a fit: from the probes, and others at random
START_STD = 0.5  # of their random part, in the standard deviations of the points
MAX_ITER, FTOL = 60, 1e-4  # of a fit
FLOOR_PX, SLACK = 0.02, 1.5  # rms residual that is accepted without noise, and times the noise
MOVED_PX, MOVED_SIGMAS = 0.3, 6.0  # a probe that moves a point by more than both moves its link
N_ROUNDS, N_PLACEMENTS = 3, 3  # of fits and new links; steps that place a point on another link
FD_STEP, REGULARISATION, MAX_MOVE = 1e-6, 1e-9, 1.0  # of these steps: finite differences, share of the trace, length
N_SAMPLES, N_BEST = 256, 3  # postures at which inference begins, and the best of them that are refined
MIN_POINTS, MIN_SINGULAR = 3, 1e-3  # of an initial axis; relative to the largest singular value
UNKNOWN_AXIS = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])  # where no points tell more
MIN_SCALE = 1e-9  # of lengths to divide by
PATIENCE, PROGRESS = 12, 0.99  # motions after which E must have fallen to this share of its minimum

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class GenerativeModel:
    """A chain of joints in two projective cameras. Several at once have leading axes in parameters and points."""

    parameters: Floats  # (..., N_CAMERA_PARAMETERS + 6 m): the cameras; a_j (of any length) and c_j of each joint
    points: Floats  # (..., N, 3): at the reference
    link: NDArray[np.int_]  # (N,): how many joints move a point, from the base outwards
    reference: Floats  # (m,) rad

    def predict(self, displacement: Floats) -> Floats:
        """Images (..., K, N, 4) at displacements (K, m) rad."""
        x = np.broadcast_to(
            self.points[..., None, :, :], (*self.points.shape[:-2], len(displacement), len(self.link), 3)
        )
        joints = self.parameters[..., N_CAMERA_PARAMETERS:].reshape(*self.parameters.shape[:-1], -1, 2, 3)
        for j in reversed(range(displacement.shape[1])):
            axis, centre = joints[..., j, 0, :], joints[..., j, 1, None, None, :]
            turn = rotations(axis, displacement[:, j] - self.reference[j])
            turned = (x - centre) @ turn.swapaxes(-1, -2) + centre
            x = np.where((self.link > j)[:, None], turned, x)
        A, t, v = np.split(self.parameters[..., :N_CAMERA_PARAMETERS], (T_AT, V_AT), axis=-1)
        lead = self.parameters.shape[:-1]
        A, v = A.reshape(*lead, 1, 4, 3), v.reshape(*lead, 1, 2, 3)
        depth = np.maximum(1 + x @ v.swapaxes(-1, -2), MIN_DEPTH)
        return (x @ A.swapaxes(-1, -2) + t[..., None, None, :]) / np.repeat(depth, 2, axis=-1)


def rotations(axis: Floats, angle: Floats) -> Floats:
    """Turns about an axis, (..., 3) of any length, by angles (K,) rad: (..., K, 3, 3), by Rodrigues' formula."""
    x, y, z = np.moveaxis(axis / np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), 1e-12), -1, 0)
    zero = np.zeros_like(x)
    K = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*x.shape, 1, 3, 3)
    angle = angle[:, None, None]
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K)


@dataclass(frozen=True)
class Visits:
    """Images of K visits."""

    displacement: Floats  # (K, m) rad
    images: Floats  # (K, N, 4), 0 where a point is not seen
    seen: NDArray[np.bool_]  # (K, N, 2)

    @classmethod
    def of(cls, visits: tuple[Visit, ...]) -> "Visits":
        """Stack visits."""
        displacement, own, seen = (
            np.stack([getattr(one, name) for one in visits]) for name in ("displacement", "own", "seen")
        )
        return cls(displacement, np.nan_to_num(own), seen)

    def residuals(self, model: GenerativeModel) -> Floats:
        """Predicted minus seen images, (..., K, N, 4), 0 of points that were not seen."""
        return np.where(repeat_xy(self.seen), model.predict(self.displacement) - self.images, 0.0)

    def rms(self, model: GenerativeModel) -> float:
        """Root mean square residual of a coordinate."""
        return float(np.sqrt((self.residuals(model) ** 2).sum() / max(2 * self.seen.sum(), 1)))

    @property
    def known(self) -> NDArray[np.bool_]:
        """(N,): points that both cameras saw at once at some visit."""
        return np.asarray(self.seen.all(-1).any(0))


def fit(visits: Visits, noise: float, previous: GenerativeModel | None) -> GenerativeModel:
    """Fit the model to all visits, from the previous one or from several initial values.

    Parameters
    ----------
    visits : Visits
        In image units; the first 1 + m are the start and a probe of each joint, in their order.
    noise : float
        Standard deviation of an image coordinate.
    previous : GenerativeModel or None
        Fitted to all but the last visits.

    Returns
    -------
    GenerativeModel
        The best of all fits, or the first one that explains the images as well as noise allows.
    """
    initial = initial_models(visits, noise, np.random.default_rng(len(visits.displacement)))
    starts: Iterator[GenerativeModel] = (
        islice(initial, N_STARTS) if previous is None else chain([previous], islice(initial, 1))
    )
    accepted = SLACK * max(noise, FLOOR_PX)
    best = _fit_from(next(starts), visits, noise, accepted)
    while visits.rms(best) >= accepted and (start := next(starts, None)) is not None:
        best = min(best, _fit_from(start, visits, noise, accepted), key=visits.rms)
    return best


def _fit_from(model: GenerativeModel, visits: Visits, noise: float, accepted: float) -> GenerativeModel:
    """Fit cameras, joints and points, and find the link of each point again where noise does not explain the result."""
    prior = np.zeros(len(model.parameters))
    prior[V_AT:N_CAMERA_PARAMETERS] = (max(noise, FLOOR_PX) / PERSPECTIVE_STD) ** 2
    for _ in range(N_ROUNDS):
        model = levenberg_marquardt(model, visits.residuals, prior, FTOL, MAX_ITER)
        if visits.rms(model) < accepted:
            break
        relinked = _with_best_links(model, visits)
        if (relinked.link == model.link).all():
            break
        model = relinked
    return model


def _with_best_links(model: GenerativeModel, visits: Visits) -> GenerativeModel:
    """Let each point be on the link that explains its images best, with cameras and joints as they are."""
    trials = []
    for link in range(1 + visits.displacement.shape[1]):
        trial = replace(model, link=np.full_like(model.link, link))
        for _ in range(N_PLACEMENTS):
            trial = _with_points_placed(trial, visits)
        trials.append(trial)
    squares = np.array([(visits.residuals(trial) ** 2).sum((0, 2)) for trial in trials])
    best = squares.argmin(0)
    points = np.array([trial.points for trial in trials])[best, np.arange(len(best))]
    return replace(model, link=best, points=points)


def _with_points_placed(model: GenerativeModel, visits: Visits) -> GenerativeModel:
    """Place each point by a Gauss-Newton step, with cameras and joints as they are."""
    e = visits.residuals(model)
    stepped = replace(model, points=model.points + FD_STEP * np.eye(3)[:, None])
    parameters = np.broadcast_to(model.parameters, (3, len(model.parameters)))
    J = (visits.residuals(replace(stepped, parameters=parameters)) - e) / FD_STEP
    normal = np.einsum("akni,bkni->nab", J, J)
    trace = np.einsum("naa->n", normal) + MIN_SCALE
    normal = normal + REGULARISATION * trace[:, None, None] * np.eye(3)
    move = np.linalg.solve(normal, np.einsum("akni,kni->na", J, e)[..., None])[..., 0]
    return replace(model, points=model.points - np.clip(move, -MAX_MOVE, MAX_MOVE))


def initial_models(visits: Visits, noise: float, rng: np.random.Generator) -> Iterator[GenerativeModel]:
    """Yield initial values: the affine ones that the probes suggest, then others with random axes.

    Cameras and points are the principal components of all images, as of affine cameras (Tomasi and Kanade 1992). The
    axis of a joint is the one about which its probe turned the points, if that were linear. A point is on the link
    of the last joint whose probe moved it.
    """
    m = visits.displacement.shape[1]
    both = np.asarray(visits.seen.all(-1))
    stacked = visits.images[both]
    t = stacked.mean(0)
    _, scale, axes = np.linalg.svd(stacked - t, full_matrices=False)
    A = np.maximum(scale[:3], MIN_SCALE) / np.sqrt(len(stacked)) * axes[:3].T
    x = (visits.images - t) @ np.linalg.pinv(A).T
    points = np.where(visits.known[:, None], x[both.argmax(0), np.arange(both.shape[1])], 0.0)
    seen_twice = both[:m] & both[1 : m + 1]
    shift = np.abs(np.diff(visits.images[: m + 1], axis=0)).max(-1)
    moved = seen_twice & (shift > max(MOVED_PX, MOVED_SIGMAS * noise))
    link = np.where(seen_twice.any(0), (moved * np.arange(1, m + 1)[:, None]).max(0), m)
    angles = np.diff(visits.displacement[: m + 1], axis=0).diagonal()
    joints = np.array([_axis(x[j, moved[j]], x[j + 1, moved[j]], angles[j]) for j in range(m)])
    cameras = np.concatenate([A.ravel(), t, np.zeros(6)])
    while True:
        yield GenerativeModel(np.concatenate([cameras, joints.ravel()]), points, link, visits.displacement[0])
        joints = joints + START_STD * rng.normal(size=joints.shape)


def _axis(before: Floats, after: Floats, angle: float) -> Floats:
    """Axis and a point on it, (2, 3), about which an angle [rad] turns points, (M, 3), by least squares.

    It is linear, with w along the axis: after - before = angle (w x middle + u), and the point is w x u / |w|².
    """
    if len(before) < MIN_POINTS or not angle:
        return UNKNOWN_AXIS
    x, y, z = (before + after).T / 2
    zero = np.zeros_like(x)
    turned = np.stack([zero, z, -y, -z, zero, x, y, -x, zero], -1).reshape(-1, 3, 3)  # w x middle = turned w
    rows = np.concatenate([turned, np.broadcast_to(np.eye(3), turned.shape)], -1).reshape(-1, 6)
    w, u = np.split(np.linalg.lstsq(rows, (after - before).ravel() / angle, rcond=MIN_SINGULAR)[0], 2)
    length = np.linalg.norm(w)
    return np.stack([w / length, np.cross(w, u) / length**2]) if length > MIN_SCALE else UNKNOWN_AXIS


@dataclass(frozen=True)
class GenerativeState:
    """State of `Generative`."""

    visits: tuple[Visit, ...]
    joints_to_probe: tuple[int, ...]
    unit_px: float
    model: GenerativeModel | None = None
    best_E: float = np.inf  # px²: the smallest E so far
    n_since_best: int = 0  # motions since then
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False


class Generative:
    """Goes where a learned generative model of the own images infers the demonstrator's posture."""

    def start(self, observation: Observation) -> GenerativeState:
        """Return the state before the first motion."""
        return GenerativeState((), tuple(range(len(observation.displacement))), unit_of(observation))

    def restart(self, state: GenerativeState, observation: Observation) -> GenerativeState:
        """Return the state for another descent, from here: visits and model stay."""
        return replace(state, best_E=np.inf, n_since_best=0)

    def step(
        self, state: GenerativeState, observation: Observation, residuals: ResidualFunction
    ) -> tuple[GenerativeState, Floats]:
        """Return the next state and the motion, (m,) rad."""
        m, here = len(observation.displacement), observation.displacement
        scaled = in_units(observation, state.unit_px)
        visits = (*state.visits, Visit.of(here, scaled.own, scaled.seen))
        state = replace(state, visits=visits, status=ServoStatus.MOVING, probe=True)
        if state.joints_to_probe:
            joint, *rest = state.joints_to_probe
            return replace(state, joints_to_probe=tuple(rest)), probe_motion(joint, observation)
        has_progressed = PROGRESS * state.best_E > observation.E
        best_E, n_since_best = (observation.E, 0) if has_progressed else (state.best_E, state.n_since_best + 1)
        state = replace(state, best_E=best_E, n_since_best=n_since_best, probe=False)
        stacked = Visits.of(visits)
        model = fit(stacked, scaled.noise_px, state.model)
        state = replace(state, model=model)
        target = infer(model, stacked.known, scaled, ScaledResiduals(residuals, state.unit_px))
        if target is None or n_since_best >= PATIENCE:
            return replace(state, status=ServoStatus.NO_PROGRESS), np.zeros(m)
        if np.abs(target - here).max() < MIN_STEP_RAD:
            return replace(state, status=ServoStatus.SETTLED), np.zeros(m)
        return state, target - here


def infer(
    model: GenerativeModel, known: NDArray[np.bool_], observation: Observation, residuals: ResidualFunction
) -> Floats | None:
    """Return the posture whose predicted images leave the least E, (m,) rad; None with too few known points."""

    def residual_at(theta: Floats) -> Floats:
        images = model.predict(theta.reshape(-1, theta.shape[-1]))
        return residuals(np.where(known[:, None], images, np.nan).reshape(*theta.shape[:-1], *images.shape[1:]))

    rng = np.random.default_rng([observation.seed, observation.motion])
    samples = rng.uniform(observation.lower, observation.upper, (N_SAMPLES, len(observation.lower)))
    E = conflict(residual_at(samples))
    if not np.isfinite(E).any():
        return None
    starts = np.concatenate([observation.displacement[None], samples[np.argsort(E)[:N_BEST]]])
    return minimise(residual_at, starts, observation.lower, observation.upper).theta

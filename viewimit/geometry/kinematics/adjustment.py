"""Kinematics from images, all visits together: bundle adjustment over the frame, the twists and the points.

Levenberg and Marquardt's steps on what is left in the images, the points eliminated from each by Schur's complement
(Triggs et al. 2000). It needs no good start: the affine frame and joints that do not turn will do.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..rectification import Rectification
from .clusters import Seen, moved_points
from .model import FRAME, ProjectiveKinematics, StereoFrame

STEP = 1e-6  # of difference quotients
ROUNDS, RETRIES = 30, 6
FIRST_DAMPING, LESS, MORE = 1e-3, 0.1, 10.0
GAIN, NOTHING = 1e-3, 1e-9  # share of what is left, that a round must gain; px, rms, that is nothing
STEADY = 1e-9  # of the normal equations' diagonal, added to it
AFFINE = 3.0  # standard deviation of the frame's parameters, where noise leaves them open
EXACT = 1e-2  # px, rms of what images without noise may leave
SURELY, SLACK = 4.0, 1.2  # standard deviations of the mean square; times the noise, as that is measured itself


@dataclass(frozen=True)
class Adjustment:
    """seen: of known points alone; coordinates: (K, N, 3), of these images in the kinematics' frame; noise_px: of an
    image coordinate, standard deviation."""

    seen: Seen
    coordinates: NDArray
    noise_px: float

    @property
    def least_px(self) -> float:
        return max(self.noise_px, EXACT)

    @property
    def freedom(self) -> int:
        """Coordinates that the parameters and points do not fit by themselves."""
        parameters = FRAME + 6 * self.seen.displacement.shape[1]
        return 3 * (int(np.count_nonzero(self.seen.whole)) - self.seen.points) - parameters

    def of_known(self, found: ProjectiveKinematics) -> "Adjustment":
        """To the images of those points alone of which it knows."""
        return replace(self, seen=self.seen.only(~found.unknown))

    def left(self, found: ProjectiveKinematics) -> NDArray:
        """(..., K, N, 3) px, 0 of what was not seen. found: with (..., P) parameters and (..., N, 3) points."""
        off = found.coordinates(self.seen.displacement) - self.coordinates
        return np.where(self.seen.whole[..., None], off * found.frame.spread, 0.0)

    def squares(self, found: ProjectiveKinematics) -> NDArray:
        """(N,) px², the mean square of what is left of each point, a coordinate."""
        return (self.left(found) ** 2).sum((0, 2)) / np.maximum(3 * self.seen.whole.sum(0), 1)

    def explained(self, found: ProjectiveKinematics) -> bool:
        """Whether what is left is noise."""
        freedom = max(self.freedom, 1)
        mean = float((self.left(found) ** 2).sum()) / freedom
        return mean < (SLACK * self.least_px) ** 2 * (1 + SURELY * np.sqrt(2 / freedom))

    def adjusted(self, begun: ProjectiveKinematics) -> ProjectiveKinematics | None:
        """The nearest to all images from there; None if it does not explain them."""
        found, prior = begun, self.prior(len(begun.parameters))
        left, damping = self.left(found), FIRST_DAMPING
        square = float((left**2).sum() + prior @ found.parameters**2)
        for _ in range(ROUNDS):
            if square < left.size * NOTHING**2:
                break
            stepped, gained = self._stepping(found, left, prior), 0.0
            for _ in range(RETRIES):
                trial = stepped(damping)
                trial_left = self.left(trial)
                gained = square - float((trial_left**2).sum() + prior @ trial.parameters**2)
                if gained > 0:
                    break
                damping *= MORE
            if not gained > 0:
                break
            found, left, square, damping = trial, trial_left, square - gained, damping * LESS
            if gained < GAIN * square:
                break
        return found if self.explained(found) else None

    def prior(self, parameters: int) -> NDArray:
        """(P,) px², weights: what noise leaves open of the frame is as in an affine one."""
        weights = np.zeros(parameters)
        weights[:FRAME] = (self.noise_px / AFFINE) ** 2
        return weights

    def derivatives(self, found: ProjectiveKinematics, left: NDArray) -> NDArray:
        """(P + 3, K, N, 3) px: of what is left, by each parameter, and by each coordinate of its point."""
        P = len(found.parameters)
        parameters = found.parameters + STEP * np.eye(P + 3, P)
        shape = found.shape + STEP * np.eye(P + 3, 3, -P)[:, None, :]
        return np.nan_to_num((self.left(replace(found, parameters=parameters, shape=shape)) - left) / STEP)

    def _stepping(
        self, found: ProjectiveKinematics, left: NDArray, prior: NDArray
    ) -> Callable[[float], ProjectiveKinematics]:
        """A damping → where the linear model there leads."""
        J, P = self.derivatives(found, left), len(found.parameters)
        A, B, C = products(J, P)
        A = A + np.diag(prior)
        g = J[:P].reshape(P, -1) @ left.ravel() + prior * found.parameters
        h = np.einsum("akni,kni->na", J[P:], left)
        own, of_points = np.diag(A), np.einsum("naa->na", C)

        def stepped(damping: float) -> ProjectiveKinematics:
            raised = damping * of_points + STEADY * of_points.sum(1, keepdims=True) + np.finfo(float).tiny
            inverse = np.linalg.inv(C + raised[..., None] * np.eye(3))
            BC = B @ inverse
            reduced = A + np.diag(damping * own + STEADY * own.mean()) - np.tensordot(BC, B, ([0, 2], [0, 2]))
            step = np.linalg.solve(reduced, np.tensordot(BC, h, ([0, 2], [0, 1])) - g)
            shape = found.shape - np.einsum("nab,nb->na", inverse, h + np.tensordot(B, step, ([1], [0])))
            return replace(found, parameters=found.parameters + step, shape=shape)

        return stepped


def products(J: NDArray, parameters: int) -> tuple[NDArray, NDArray, NDArray]:
    """The normal equations of derivatives (P + 3, K, N, 3): A (P, P) of the parameters, C (N, 3, 3) of the points,
    B (N, P, 3) of both."""
    of_all = J[:parameters].reshape(parameters, -1)
    by_point = np.moveaxis(J, 2, 0).reshape(J.shape[2], len(J), -1)
    both = by_point @ by_point[:, parameters:].swapaxes(1, 2)
    return of_all @ of_all.T, both[:, :parameters], both[:, parameters:]


# Projective kinematics that explain the images of a body at all postures visited, if there are any.

FORESEEN = 1e-6  # px: what is foretold without noise is as far off, and nothing is to be learned from less
IN_SPACE = 3.0  # times the noise: rms distance of images from a hyperplane, which those of parallel cameras have
FEWEST = 4  # points that span a space
NEAR = np.radians(40.0)  # from the first visit, of visits to begin with
OF_ONE = 16.0  # times the noise's square, of a point that was placed by a single image
CLEARLY = 4.0  # times as much by other joints


def fit_kinematics(
    seen: Seen, noise_px: float, rectification: Rectification | None = None, before: ProjectiveKinematics | None = None
) -> ProjectiveKinematics | None:
    """What explains all visits as well as noise allows, None if nothing is found that does. noise_px: of an image
    coordinate, standard deviation; before: what explained all visits but the last."""
    if before is not None and (before.rectification is None) != (rectification is None):
        before = None
    if before is not None and noise_px == 0 and before.rectification is rectification and _foresaw(before, seen):
        return before
    if len(seen.displacement) <= seen.displacement.shape[1] or seen.points < FEWEST:
        return None
    grouped = moved_points(seen, noise_px)
    if grouped is None:
        return None
    images = np.where(seen.whole[..., None], seen.images, 0.0)
    images = images if rectification is None else rectification.apply(images)
    begun = before or _anew(seen, images, rectification)
    if begun.frame.off > max(EXACT, IN_SPACE * noise_px):
        return None
    coordinates = begun.frame.coordinates(images)
    moved, told = grouped
    moved = np.where(begun.unknown[:, None], moved, begun.moved)
    begun = replace(begun, moved=moved, rectification=rectification)
    begun = begun.with_points(told & begun.unknown, seen, coordinates)
    whole = Adjustment(seen, coordinates, noise_px)
    found = _adjusted(begun, whole, anew=before is None)
    if found is None:
        return None
    more = _with_others(found, found.unknown & (seen.whole.sum(0) > 1), whole)
    return found if more is found else whole.of_known(more).adjusted(more) or found


def _anew(seen: Seen, images: NDArray, rectification: Rectification | None) -> ProjectiveKinematics:
    """That knows nothing yet. images: (K, N, 4) px, rectified."""
    (_, points), joints = seen.whole.shape, seen.displacement.shape[1]
    frame = StereoFrame.of(images[seen.whole])
    return ProjectiveKinematics.unmoved(points, joints, seen.displacement[0], frame, rectification)


def _foresaw(before: ProjectiveKinematics, seen: Seen) -> bool:
    """Whether nothing is left to learn of the last visit."""
    last = seen.whole[-1]
    if before.unknown.any() or not last.any():
        return False
    return bool(np.abs(before.predict(seen.displacement[-1]) - seen.images[-1])[last].max() < FORESEEN)


def _adjusted(begun: ProjectiveKinematics, whole: Adjustment, anew: bool) -> ProjectiveKinematics | None:
    """anew: beginning with visits that are near, and again with other joints for the points that contradict."""
    known = whole.of_known(begun)
    if known.freedom < 1:
        return None
    if not anew:
        return known.adjusted(begun) or _regrouped(begun, known)
    near = np.abs(known.seen.displacement - begun.reference).max(1) < NEAR
    if near.sum() <= len(begun.reference) or near.all():
        return known.adjusted(begun)
    first = Adjustment(known.seen.at(near), known.coordinates[near], known.noise_px).adjusted(begun)
    return None if first is None else known.adjusted(first) or _regrouped(first, known)


def _regrouped(begun: ProjectiveKinematics, known: Adjustment) -> ProjectiveKinematics | None:
    """With those points moved by other joints that contradict. Noise may hide at first that a joint moves one."""
    if known.noise_px == 0:
        return None
    other = _with_others(begun, known.squares(begun) > OF_ONE * known.least_px**2, known)
    return None if other is begun else known.adjusted(other)


def _with_others(found: ProjectiveKinematics, points: NDArray, whole: Adjustment) -> ProjectiveKinematics:
    """With these points, (N,) bool, moved by the joints that all their images tell, where these tell one answer."""
    known = found.moved[~found.unknown]
    but_one = known[:, None] ^ np.eye(known.shape[1], dtype=bool)
    patterns, most = np.unique([*known, *but_one.reshape(-1, known.shape[1])], axis=0), OF_ONE * whole.least_px**2
    for point in np.flatnonzero(points):
        one = np.arange(len(points)) == point
        trials = [replace(found, moved=np.where(one[:, None], pattern, found.moved)) for pattern in patterns]
        trials = [trial.with_points(one, whole.seen, whole.coordinates) for trial in trials]
        squares = [float(whole.squares(trial)[point]) for trial in trials]
        best, *others = np.argsort(squares)
        clear = CLEARLY * max(squares[best], whole.least_px**2)
        if squares[best] < most and all(squares[other] > clear for other in others):
            found = trials[best]
    return found

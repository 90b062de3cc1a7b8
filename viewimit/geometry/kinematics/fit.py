"""Projective kinematics that explain the images of a body at all postures visited, if there are any."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..rectification import Rectification
from .adjustment import EXACT, Adjustment
from .frame import StereoFrame
from .groups import moved_points
from .model import ProjectiveKinematics
from .seen import Seen

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

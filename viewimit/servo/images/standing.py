"""Where an arm stands by its images, once these have contradicted where it was sent.

An arm that moves in steps, or against a stop, shows an image that it has shown before, though it was sent elsewhere and
the image was to change. Nothing that it was sent by tells its posture any more. Then the same image is the same
posture, and another one is where its images say, as far as they can be predicted: a prior of SLACK about where it was
sent counts for the rest (maximum a posteriori, Gauss and Newton's steps).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..observation import Visit, by_coordinate
from .surrogate import learn

SAME = 2.0  # standard deviations of a coordinate: images that differ by less, root mean square, are the same
FORESEEN = 2.0  # times as much was to change where it did not
SLIGHT = np.radians(0.1)  # off, a joint, which is not worth probing anew
LEAST_PX = 1e-3  # in place of a smaller noise
SLACK, ROUNDS = np.radians(0.3), 4


def contradicts(known: tuple[Visit, ...], here: Visit, noise_px: float) -> bool:
    """Whether an image was seen before that was to be another one, by more than is unsure. known: visits; here:
    displaced by where it was sent; noise_px: of an image coordinate, standard deviation."""
    if len(known) <= len(here.displacement):
        return False
    displacement = np.array([visit.displacement for visit in known])
    apart = np.abs(displacement - here.displacement).max(1) > SLIGHT
    there = displacement[_same(known, here, noise_px) & apart]
    if not len(there):
        return False
    model = learn(list(known), len(known) - 1, noise_px)
    unsure = model.spread(here.displacement[None])[0] / (SAME * FORESEEN)
    surely = np.maximum(unsure, max(noise_px, LEAST_PX))
    change = (model.predict(there) - model.predict(here.displacement)) / (SAME * surely[:, None])
    change = np.abs(np.nan_to_num(change[:, here.seen.all(-1)])).reshape(len(there), -1)
    most = np.median(change, 1) > 1  # of a few points wrong places at other visits foretell anything
    return bool((most & (np.sqrt((change**2).mean(1)) > FORESEEN)).any())


def standing(known: tuple[Visit, ...], sent: Visit, noise_px: float) -> tuple[Visit, bool]:
    """The same, displaced by what its images tell, and whether the arm was there before. sent: displaced by where it
    was sent."""
    same = _same(known, sent, noise_px).nonzero()[0]
    if len(same):
        return Visit(known[same[-1]].displacement, sent.own, sent.seen), True
    model, start = learn(list(known), len(known) - 1, noise_px), sent.displacement
    weight = by_coordinate(sent.seen) / np.hypot(model.spread(start[None])[0], LEAST_PX)[:, None]
    theta, prior = start, np.eye(len(start)) / SLACK**2
    for _ in range(ROUNDS):
        off = np.nan_to_num(weight * (model.predict(theta) - sent.own)).ravel()
        J = np.nan_to_num(weight * model.slopes(theta)).reshape(len(start), -1)
        theta = theta - np.linalg.solve(J @ J.T + prior, J @ off + prior @ (theta - start))
    return Visit(theta, sent.own, sent.seen), False


def _same(visits: Sequence[Visit], here: Visit, noise_px: float) -> NDArray:
    """(n,) bool: which of them show the same images as here, by the coordinates seen in both."""
    own, seen = np.array([visit.own for visit in visits]), np.array([visit.seen for visit in visits])
    both = by_coordinate(seen & here.seen)
    square, count = np.where(both, own - here.own, 0.0) ** 2, both.sum((1, 2))
    return (count > 0) & (square.sum((1, 2)) <= (SAME * max(noise_px, LEAST_PX)) ** 2 * count)

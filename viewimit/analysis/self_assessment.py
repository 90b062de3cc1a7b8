"""What a learner can say about its present posture, from its own images and motions alone.

It uses the servo's own convergence test if the servo makes one. Otherwise the same test is made from the visited
postures: the image model predicts how E rises about the posture, and the visits show how it did.
"""

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..loop.session import Session
from ..loop.snapshot import Snapshot
from ..servo.least_squares import Minimum, minimise
from ..servo.observation import ScaledResiduals, Visit, in_units, unit_of
from ..servo.trust_region.convergence import Certificate, certify
from ..servo.trust_region.gaussian_process import MIN_NOISE_PX, GaussianProcessImages
from ..servo.trust_region.local_model import EstimationData, local_model

MAX_VISITS = 60  # used for the image model, evenly spaced over all motions
SEARCH_RADIUS_RAD = np.radians(8.0)  # within which a lower E is looked for
AT_MINIMUM_RAD = np.radians(1.5)  # a posture nearer than this to the predicted minimum is at a local minimum


@dataclass(frozen=True)
class Assessment:
    """The learner's own judgement of its posture."""

    certificate: Certificate
    max_displacement: float  # rad, the longest semi-axis of the level set of E: how far off the posture can be
    distance: float  # rad, to the predicted minimum of E, at most SEARCH_RADIUS_RAD
    unobservable: list[int]  # indices of the unobservable joints, worst first

    @property
    def std_per_px(self) -> NDArray[np.float64]:
        """(m,) rad/px, the standard error of each joint per pixel of noise."""
        return self.certificate.std_per_px

    @property
    def at_local_minimum(self) -> bool:
        return self.distance < AT_MINIMUM_RAD


_ASSESSED: WeakKeyDictionary[Snapshot, Assessment | None] = WeakKeyDictionary()  # a snapshot is drawn many times


def assess(session: Session) -> Assessment | None:
    """Assess the session's present posture.

    Returns None without a transfer, before as many motions as there are joints, and with too few points for any E.
    """
    now = session.snapshot
    if now.transfer is None or session.cursor < len(now.theta):
        return None
    if now not in _ASSESSED:
        _ASSESSED[now] = _assess(session, now, session.cursor)
    return _ASSESSED[now]


def _assess(session: Session, now: Snapshot, cursor: int) -> Assessment | None:
    seen = session.observation(now)
    unit_px = unit_of(seen)
    seen, residuals = in_units(seen, unit_px), ScaledResiduals(session.predicted_residuals(now), unit_px)
    kept = np.unique(np.linspace(0, cursor, MAX_VISITS).round().astype(int)).tolist()
    visits = tuple(_visit(session.history[k], unit_px) for k in kept)
    model = GaussianProcessImages.fit(visits, len(visits) - 1, max(seen.noise_px, MIN_NOISE_PX))
    here = seen.displacement
    low, high = np.maximum(seen.lower, here - SEARCH_RADIUS_RAD), np.minimum(seen.upper, here + SEARCH_RADIUS_RAD)
    found = minimise(lambda theta: residuals(model.predict(theta)), here[None], low, high)
    if not np.isfinite(found.E):
        return None
    certificate = now.certificate
    if certificate is None:
        points = np.asarray(np.isfinite(model.at_centre).all(-1))
        certificate = certify(
            local_model(EstimationData(visits, len(visits) - 1, seen.E, points, model, seen, residuals), found, here)
        )
        certificate = certificate.per_pixel(unit_px)
    distance = float(np.abs(found.theta - here).max())
    return Assessment(
        certificate, _max_displacement(seen.E, found), distance, certificate.reportable_joints(now.status)
    )


def _max_displacement(E: float, found: Minimum) -> float:
    flattest = float(np.linalg.eigvalsh(found.hessian / 2)[0])
    return float(np.sqrt(E / max(flattest, 1e-12)))


def _visit(moment: Snapshot, unit_px: float) -> Visit:
    displacement = moment.commanded - moment.settings.start_rad
    return Visit.of(displacement, moment.views.own / unit_px, moment.views.visible[:, 2:])

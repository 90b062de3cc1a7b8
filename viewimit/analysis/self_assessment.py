"""What a learner can say about its present posture, from its own images and motions alone.

The servo's own certificate is used if it has one. Otherwise the body that explains the visited images predicts how E
rises about the posture, and that gives the standard error of each joint.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.kinematics.clusters import Observations
from ..geometry.kinematics.own_body import learn
from ..loop.session import Session
from ..loop.snapshot import Snapshot
from ..servo import Certificate
from ..servo.certificate import MAX_STD_PER_PX
from ..servo.least_squares import Minimum, minimise, standard_deviations
from ..servo.observation import ScaledResiduals, in_units, unit_of

MAX_VISITS = 20  # that the body is learned from, evenly spaced over all motions
SEARCH_RADIUS_RAD = np.radians(8.0)  # within which a lower E is looked for
AT_MINIMUM_RAD = np.radians(1.5)  # a posture nearer than this to the predicted minimum is at a local minimum


@dataclass(frozen=True)
class Assessment:
    """The learner's own judgement of its posture."""

    certificate: Certificate
    max_displacement: float  # rad, the longest semi-axis of the level set of E: how far off the posture can be
    distance: float  # rad, to the predicted minimum of E, at most SEARCH_RADIUS_RAD

    @property
    def std_per_px(self) -> NDArray[np.float64]:
        """(m,) rad/px, the standard error of each joint per pixel of noise."""
        return self.certificate.std_per_px

    @property
    def unobservable(self) -> list[int]:
        """Indices of the unobservable joints, worst first."""
        return self.certificate.unobservable_joints

    @property
    def at_local_minimum(self) -> bool:
        return self.distance < AT_MINIMUM_RAD


def assess(session: Session) -> Assessment | None:
    """Assess the session's present posture.

    Returns None without a transfer, before as many motions as there are joints, with too few points for any E, and if
    no body of rigid links explains the own images.
    """
    now = session.snapshot
    if now.transfer is None or session.cursor < len(now.theta):
        return None
    seen, cursor = session.observation(now), session.cursor
    unit_px = unit_of(seen)
    seen, residuals = in_units(seen, unit_px), ScaledResiduals(session.predicted_residuals(now), unit_px)
    kept = np.unique(np.linspace(0, cursor, MAX_VISITS).round().astype(int)).tolist()
    body = learn(_visits([session.history[k] for k in kept], unit_px), seen.noise_px, seen.rectification)
    if body is None:
        return None
    here = body.here
    low, high = np.maximum(seen.lower, here - SEARCH_RADIUS_RAD), np.minimum(seen.upper, here + SEARCH_RADIUS_RAD)
    found = minimise(lambda theta: residuals(body.kinematics.predict(theta)), here[None], low, high)
    if not np.isfinite(found.E):
        return None
    distance = float(np.abs(found.theta - here).max())
    certificate = now.certificate or _certificate(found, seen.noise_px, unit_px)
    return Assessment(certificate, _max_displacement(seen.E, found), distance)


def _visits(moments: list[Snapshot], unit_px: float) -> Observations:
    """The own images of some moments in image units, with where the arm was sent."""
    displacement = np.array([moment.commanded - moment.settings.start_rad for moment in moments])
    visible = np.array([moment.views.visible[:, 2:].all(-1) for moment in moments])
    own = np.array([moment.views.own for moment in moments]) / unit_px
    return Observations(displacement, np.where(visible[..., None], own, np.nan), visible)


def _certificate(found: Minimum, noise_px: float, unit_px: float) -> Certificate:
    """What noise makes of the minimum; where E leaves more than noise, that counts as noise. Images are in units."""
    per_unit = standard_deviations(found.hessian, found.points)
    noise = max(noise_px, np.sqrt(found.E / 2))  # E is the mean square of two residual coordinates
    std_per_px = per_unit / unit_px
    return Certificate(np.where(std_per_px < MAX_STD_PER_PX, per_unit * noise, np.inf), std_per_px)


def _max_displacement(E: float, found: Minimum) -> float:
    flattest = float(np.linalg.eigvalsh(found.hessian / 2)[0])
    return float(np.sqrt(E / max(flattest, 1e-12)))

"""What a learner can tell of the posture in which it rests, from its own images and motions alone.

It is the servo's own certificate, if that gives one, or else made by the same rules from the postures visited: the
images that they predict tell how E should rise about the posture, and the E measured there how it did.
"""

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..loop.session import Session
from ..loop.snapshot import Snapshot
from ..servo.images.surrogate import LEAST_NOISE, learn
from ..servo.least_squares import Minimum, minimise
from ..servo.observation import ScaledResiduals, Visit, in_units, unit_of
from ..servo.trust_region.convergence import Certificate, certify
from ..servo.trust_region.local_model import Known, survey

VISITS = 60  # evenly from all motions
REACH = np.radians(8.0)  # about the posture, within which a lower E is looked for
NEAR = np.radians(1.5)  # a posture nearer than that to where E should be least counts as there


@dataclass(frozen=True)
class Assessment:
    """room: rad, how far off a posture can be that has such an E; lower: rad, how far away E should be least, at most
    REACH; untold: indices of the joints that nothing tells, the worst first."""

    certificate: Certificate
    room: float
    lower: float
    untold: list[int]

    @property
    def spread(self) -> NDArray:
        """(m,) rad/px, what a pixel of noise would turn each joint by."""
        return self.certificate.spread

    @property
    def least(self) -> bool:
        """Whether E is as small here as it is going to be."""
        return self.lower < NEAR


_ASSESSED: WeakKeyDictionary[Snapshot, Assessment | None] = WeakKeyDictionary()  # a moment is drawn many times


def assess(session: Session) -> Assessment | None:
    """Of the present moment; None without a transfer, before as many motions as there are joints, or where too few
    points are known for any E."""
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
    kept = np.unique(np.linspace(0, cursor, VISITS).round().astype(int)).tolist()
    visits = tuple(_visit(session.history[k], unit_px) for k in kept)
    model = learn(list(visits), len(visits) - 1, max(seen.noise_px, LEAST_NOISE))
    here = seen.displacement
    low, high = np.maximum(seen.lower, here - REACH), np.minimum(seen.upper, here + REACH)
    found = minimise(lambda theta: residuals(model.predict(theta)), here[None], low, high)
    if not np.isfinite(found.E):
        return None
    certificate = now.certificate
    if certificate is None:
        points = np.isfinite(model.at_centre).all(-1)
        certificate = certify(
            survey(Known(visits, len(visits) - 1, seen.E, points, model, seen, residuals), found, here)
        )
        certificate = certificate.per_pixel(unit_px)
    lower = float(np.abs(found.theta - here).max())
    return Assessment(certificate, _room(seen.E, found), lower, certificate.named(now.status))


def _room(E: float, found: Minimum) -> float:
    flattest = float(np.linalg.eigvalsh(found.hessian / 2)[0])
    return float(np.sqrt(E / max(flattest, 1e-12)))


def _visit(moment: Snapshot, unit_px: float) -> Visit:
    displacement = moment.commanded - moment.settings.start_rad
    return Visit.of(displacement, moment.views.own / unit_px, moment.views.visible[:, 2:])

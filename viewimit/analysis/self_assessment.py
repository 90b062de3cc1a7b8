"""What a learner can tell of the posture in which it rests, from its own images and motions alone.

How its images change about the posture is learned from those visited, as a servo does. The conflict of images so
predicted tells, by E = δθᵀQδθ, how far off it may be, and what a pixel of noise would cost at each joint.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..servo.image_model import Visit, by_coordinate
from ..servo.minimise import minimise
from ..servo.surrogate import LEAST_NOISE, learn
from ..session import Session
from ..snapshot import Snapshot
from .observability import untold_joints

VISITS = 60  # evenly from all motions
REACH = np.radians(8.0)  # about the posture, within which a lower E is looked for
NEAR = np.radians(1.5)  # a posture nearer than that to where E should be least counts as there
CERTAIN = np.radians(0.5)  # rather more than servos ask for
NOISE_FLOOR = 2.5  # E up to so many times the noise's square is noise
NO_CONFLICT = 0.01  # px², which nobody could see


@dataclass(frozen=True)
class Assessment:
    """spread: (m,) rad/px, what a pixel of noise would turn each joint by; room: rad, how far off a posture can be that
    has such an E; lower: rad, how far away E should be least, at most REACH; explained: no more of E is left than
    noise makes, or than could be seen."""

    spread: NDArray
    room: float
    lower: float
    explained: bool

    @property
    def untold(self) -> list[int]:
        """Indices of the joints that nothing tells, the worst first."""
        return untold_joints(self.spread)

    @property
    def certain(self) -> bool:
        """Whether what is left of E leaves no room for a displacement."""
        return not self.untold and (self.explained or self.room < CERTAIN)

    @property
    def least(self) -> bool:
        """Whether E is as small here as it is going to be."""
        return self.lower < NEAR


def assess(session: Session) -> Assessment | None:
    """Of the present moment; None without a transfer, or before as many motions as there are joints."""
    now, cursor = session.snapshot, session.cursor
    if now.transfer is None or cursor < len(now.theta):
        return None
    seen, conflict = session.observation(now), session.predicted_conflict(now)
    kept = np.unique(np.linspace(0, cursor, VISITS).round().astype(int)).tolist()
    model = learn([_visit(session.history[k]) for k in kept], len(kept) - 1, max(seen.noise_px, LEAST_NOISE))
    here = seen.displacement
    low, high = np.maximum(seen.lower, here - REACH), np.minimum(seen.upper, here + REACH)
    found = minimise(lambda theta: conflict(model.predict(theta)), here[None], low, high)
    flattest = float(np.linalg.eigvalsh(found.hessian / 2)[0])
    return Assessment(
        spread=found.spread(1.0),
        room=float(np.sqrt(now.E / max(flattest, 1e-12))),
        lower=float(np.abs(found.theta - here).max()),
        explained=bool(now.E < max(NOISE_FLOOR * seen.noise_px**2, NO_CONFLICT)),
    )


def _visit(moment: Snapshot) -> Visit:
    seen = moment.views.visible[:, 2:]
    own = np.where(by_coordinate(seen), moment.views.own, np.nan)
    return Visit(moment.commanded - moment.settings.start_rad, own, seen)

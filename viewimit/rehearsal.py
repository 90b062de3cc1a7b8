"""A learner watches itself, with nobody to imitate, before it imitates."""

import numpy as np

from .body_image import BodyImage, postures_apart
from .session import Session


def rehearse(session: Session, count: int, seed: int, within_deg: float | None = None) -> BodyImage:
    """Motions through `count` postures far from each other, within so many degrees of where a session stands, or over
    the whole range of its joints → what was seen. seed: of the postures. Raises ValueError for too few of them."""
    low, high = session.embodiment.lower, session.embodiment.upper
    if within_deg is not None:
        here, reach = session.snapshot.commanded, np.radians(within_deg)
        low, high = np.maximum(low, here - reach), np.minimum(high, here + reach)
    session.rehearse(postures_apart(low, high, count, np.random.default_rng(seed)))
    while session.snapshot.rehearses:
        session.step()
    body = session.snapshot.body
    assert body is not None
    return body

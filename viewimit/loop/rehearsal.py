"""A learner watches itself, with nobody to imitate, before it imitates."""

import numpy as np

from .body_image import BodyImage, rehearsal_postures
from .session import Session

POSTURES = 12  # with which two joints are imitated in two motions


def rehearse(session: Session, count: int, seed: int, within_deg: float | None = None) -> BodyImage:
    """As `begin_rehearsal`, and go through all of it → what was seen."""
    begin_rehearsal(session, count, seed, within_deg)
    while session.snapshot.rehearses:
        session.step()
    body = session.snapshot.body
    assert body is not None
    return body


def begin_rehearsal(session: Session, count: int, seed: int, within_deg: float | None = None) -> None:
    """The next motions lead through `count` postures, some a joint apart, the others far from each other, within so
    many degrees of where a session stands, or all over its workspace. seed: of the postures. Raises
    ValueError for too few of them."""
    low, high = session.workspace
    if within_deg is not None:
        here, reach = session.snapshot.commanded, np.radians(within_deg)
        low, high = np.maximum(low, here - reach), np.minimum(high, here + reach)
    session.rehearse(rehearsal_postures(low, high, count, np.random.default_rng(seed)))


def motions_of_imitation(session: Session) -> int:
    """That were made up to the moment shown, without those of a rehearsal among them."""
    if session.snapshot.to_rehearse is None:
        return session.snapshot.motion
    past = reversed(session.history[: session.cursor + 1])
    last = next((moment.motion + 1 for moment in past if moment.rehearses), 0)
    return max(session.snapshot.motion - last, 0)

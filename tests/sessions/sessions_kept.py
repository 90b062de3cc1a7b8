"""Sessions as a page hands them over to be kept."""

from functools import cache

from viewimit.app.sessions.saved import SavedPage, SavedSession

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

BEGUN = Settings.paper(servo="trust-region", noise_px=0.2)


@cache
def kept_session(motions: int) -> SavedSession:
    """After so many motions."""
    session = Session(BEGUN)
    for _ in range(motions):
        session.step()
    head = SavedPage(
        begun=BEGUN, cursor=session.cursor, length=len(session.history), preset="", speed=2.0, chosen=None, show={},
        dark=None, motion=None,
    )  # fmt: skip
    return SavedSession(head, tuple(session.history))

"""A link, or what a tab has kept: its scripts are played beside the page, which then becomes what they lead to."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from viewimit.loop.session import Session

from ..jobs.camera_images import SessionEyes
from .link import Linked
from .player import DENSE
from .queue import CommandQueue, Queued
from .services import Services


@dataclass(eq=False)
class Played:
    """What a link holds, and its sessions as far as they are played.

    is_own: it is what the page's own tab has kept; eyes: all sessions look with; error: why they are not played.
    """

    page: Linked
    is_own: bool
    eyes: SessionEyes
    sessions: list[Session] = field(default_factory=list)
    error: Exception | None = None

    def passes(self) -> Iterator[None]:
        """Play it, and yield after each pass of the loop."""
        for script in self.page.scripts:
            session = Session(script.settings, open_eyes=self.eyes, dense=DENSE)
            yield from session.passes(script)
            session.scrub(min(self.page.at, len(session.history) - 1))
            self.sessions.append(session)


class Following:
    """The saved page that a page becomes, if any.

    Parameters
    ----------
    page_id
        By which the scripts' players know the page.
    services
        With the players of all pages' scripts, and the camera images.
    queue
        Of the page, into which the played sessions come.
    """

    def __init__(self, page_id: int, services: Services, queue: CommandQueue):
        self._page_id, self._services, self._queue = page_id, services, queue
        self._played: Played | None = None
        self.goes_on = False  # whether a script is still played
        self.restores = False  # whether it is what the page's own tab has kept, before which nothing else counts

    def begin(self, page: Linked, arrival: Callable[[Played], Queued], is_own: bool = False) -> None:
        """Play a saved page instead of the one that is played now. arrival: the entry that then takes it."""
        self.let_go()
        played = self._played = Played(page, is_own, SessionEyes(self._services.camera))
        self.goes_on, self.restores = True, is_own

        def done(error: Exception | None) -> None:
            played.error = error
            self._queue.put(arrival(played))

        scripts = self._services.picture_scripts if page.uses_pictures else self._services.scripts
        scripts.play(self._page_id, played.passes(), done)

    def let_go(self) -> bool:
        """Follow it no more. Return whether there was one."""
        played, self._played = self._played, None
        self.goes_on = self.restores = False
        self._services.scripts.cancel(self._page_id)
        self._services.picture_scripts.cancel(self._page_id)
        if played is not None:
            played.eyes.close()
        return played is not None

    def finish(self, played: Played) -> bool:
        """Return whether this page is the one to be played: else it was cancelled just when it was complete."""
        if played is not self._played:
            return False
        self._played = None
        self.goes_on = self.restores = False
        played.eyes.close()
        return True

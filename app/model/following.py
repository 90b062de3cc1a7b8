"""A link, or what a tab has kept: its scripts are played beside the page, which then becomes what they lead to."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from viewimit.loop.session import Session

from ..jobs.camera_images import SessionEyes
from ..sessions.link import Branch, SavedPage
from .player import DENSE
from .queue import CommandQueue, Queued
from .services import Services


@dataclass(eq=False)
class Played:
    """A saved page, and as much of it as is played.

    is_own: it is what the page's own tab has kept; eyes: all its sessions look with; branches: the present one first,
    then the newest that Undo goes back to, each with its sessions; error: why not all are.
    """

    page: SavedPage
    is_own: bool
    eyes: SessionEyes
    branches: list[tuple[Branch, list[Session]]] = field(default_factory=list)
    error: Exception | None = None

    def passes(self) -> Iterator[None]:
        """Play it, and yield after each pass of the loop."""
        for branch in (self.page.present, *reversed(self.page.past)):
            sessions: list[Session] = []
            for run in branch.runs:
                sessions.append(Session(run.script.settings, open_eyes=self.eyes, dense=DENSE))
                yield from sessions[-1].passes(run.script)
                sessions[-1].scrub(min(run.cursor, len(sessions[-1].history) - 1))
            if sessions:
                self.branches.append((branch, sessions))


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

    def begin(self, page: SavedPage, arrival: Callable[[Played], Queued], is_own: bool = False) -> None:
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

"""A link that is followed: its script is played beside the page, which then becomes what the link holds."""

from collections.abc import Callable

from viewimit.loop.session import Session

from ..jobs.scripts import ScriptPlayer
from ..sessions.link import Linked
from .player import DENSE
from .queue import CommandQueue, DemonstratorJobResult


class Following:
    """The link that a page follows, if any.

    Parameters
    ----------
    page_id
        By which the scripts' player knows the page.
    scripts
        The player of all pages' scripts.
    queue
        Of the page, into which the played session comes.
    become
        Make the page what a link holds, whose script led to a session.
    """

    def __init__(
        self, page_id: int, scripts: ScriptPlayer, queue: CommandQueue, become: Callable[[Linked, Session], None]
    ):
        self._page_id, self._scripts, self._queue, self._become = page_id, scripts, queue, become
        self._linked: Linked | None = None

    @property
    def goes_on(self) -> bool:
        """Whether a script is still played."""
        return self._linked is not None

    def begin(self, linked: Linked) -> None:
        """Follow a link, in place of the one that is followed now."""
        self._linked = linked
        done = self._queue.result_callback("link", lambda made: self._take(linked, made), DemonstratorJobResult)
        settings = linked.script.settings
        self._scripts.play(self._page_id, linked.script, lambda: Session(settings, dense=DENSE), done)

    def let_go(self) -> bool:
        """Follow it no more. Return whether there was one."""
        goes_on, self._linked = self.goes_on, None
        self._scripts.cancel(self._page_id)
        return goes_on

    def _take(self, linked: Linked, made: Session | Exception) -> None:
        if linked is not self._linked:  # let go, or another was followed, just when it was whole
            return
        self._linked = None
        if isinstance(made, Exception):
            raise ValueError(f"the link cannot be followed: {made}")
        self._become(linked, made)

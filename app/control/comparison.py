"""The landscapes of all transfers in place of the one that is used: computed only while they are shown."""

from functools import partial

from viewimit.drawing.export.panels import landscape_key
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.world import World

from ..drawing.landscapes import draw_together, waiting
from ..jobs.landscapes import ComparedTransfer, LandscapeWorker, make_compared
from .queue import CommandQueue


class Comparison:
    """Each transfer is asked for apart, so that the landscapes of other pages come in between.

    on: whether they are to be shown; html: all of them; None while the one that is used is shown.
    """

    def __init__(self, page_id: int, worker: LandscapeWorker, queue: CommandQueue):
        self._page_id, self._worker, self._queue = page_id, worker, queue
        self._asked: tuple | None = None  # None while nothing is shown
        self._compared: dict[str, ComparedTransfer] = {}
        self._fresh: set[str] = set()  # what has come since the last drawing
        self.on = False
        self.html: str | None = None

    def toggle(self) -> None:
        self.on, self._asked = not self.on, None
        if not self.on:
            self.html = None

    def ask(self, world: World, snapshot: Snapshot) -> None:
        """Ask anew if what is shown would differ."""
        if not self.on:
            return
        asked = world, *landscape_key(snapshot, ignored=("transfer",))
        if asked == self._asked:
            return
        if self._asked is None or self._asked[0] is not world:
            self._compared.clear()
            self.html = waiting("computing …")
        self._asked = asked
        for transfer in TRANSFERS:
            make = partial(make_compared, asked, world, snapshot, transfer)
            done = self._queue.taker(("compared", transfer), partial(self.take, transfer))
            self._worker.ask(self._page_id, make, done, kind=f"compared: {transfer}")

    def take(self, transfer: str, made: ComparedTransfer | Exception) -> None:
        if isinstance(made, Exception):
            raise ValueError(f"nothing to compare for the {transfer} transfer: {made}")
        if self._asked is None or made.asked[0] is not self._asked[0]:  # closed, or of another scene
            return
        self._compared[transfer] = made
        self._fresh.add(transfer)
        self._draw_if_complete()

    def _draw_if_complete(self) -> None:
        """Once all are as asked for; or all are newer than what is shown, while the demonstrator goes on moving."""
        if len(self._compared) < len(TRANSFERS):
            return
        as_asked = all(one.asked == self._asked for one in self._compared.values())
        if as_asked or len(self._fresh) == len(TRANSFERS):
            self._fresh.clear()
            self.html = draw_together([self._compared[transfer].html for transfer in TRANSFERS])

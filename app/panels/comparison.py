"""The landscapes of all transfers in place of the one that is used: computed only while they are shown."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from viewimit.analysis.observability import joint_uncertainty
from viewimit.analysis.study import study
from viewimit.drawing.transfers import draw_costs, draw_quarter, draw_together, waiting
from viewimit.simulation.world import World
from viewimit.snapshot import Snapshot
from viewimit.transfer import TRANSFERS

from ..control.inbox import Inbox
from ..jobs.landscapes import LandscapeWorker, landscape_key
from .panels import Panels


@dataclass(frozen=True, eq=False)
class Quarter:
    """One transfer's drawing, and what was asked for: a world and what E depends on."""

    asked: tuple
    html: str


class Comparison:
    """Each transfer is a wish of its own, so that the landscapes of other pages come in between.

    wishes: what may be asked, by the names in the inbox; each may raise ValueError.
    """

    def __init__(self, page_id: int, panels: Panels, inbox: Inbox, worker: LandscapeWorker):
        self._page_id, self._panels, self._inbox, self._worker = page_id, panels, inbox, worker
        self._asked: tuple | None = None  # None while nothing is shown
        self._shown = False
        self._quarters: dict[str, Quarter] = {}
        self._fresh: set[str] = set()  # what has come since the last drawing
        takes = {_wish(transfer): self._taking(transfer) for transfer in TRANSFERS}
        self.wishes: dict[str, Callable] = {"transfers": self._toggle, **takes}

    def tick(self, world: World, snapshot: Snapshot) -> None:
        """Ask anew if what is shown would differ."""
        if not self._shown:
            return
        asked = world, *landscape_key(snapshot, but=("transfer",))
        if asked == self._asked:
            return
        if self._asked is None or self._asked[0] is not world:
            self._quarters.clear()
            self._panels.show_transfers(waiting("computing …"))
        self._asked = asked
        for transfer in TRANSFERS:
            make = lambda transfer=transfer: Quarter(asked, _draw(world, snapshot, transfer))
            self._worker.ask(self._page_id, make, partial(self._inbox.put, _wish(transfer)), kind=_wish(transfer))

    def _toggle(self) -> None:
        self._shown, self._asked = not self._shown, None
        if not self._shown:
            self._panels.show_transfers(None)

    def _taking(self, transfer: str) -> Callable[[Quarter | Exception], None]:
        def take(made: Quarter | Exception) -> None:
            if isinstance(made, Exception):
                raise ValueError(f"nothing to compare for the {transfer} transfer: {made}")
            if self._asked is None or made.asked[0] is not self._asked[0]:  # closed, or of another scene
                return
            self._quarters[transfer] = made
            self._fresh.add(transfer)
            self._draw_if_complete()

        return take

    def _draw_if_complete(self) -> None:
        """Once all are as asked for; or all are newer than what is shown, while the demonstrator goes on moving."""
        if len(self._quarters) < len(TRANSFERS):
            return
        as_asked = all(quarter.asked == self._asked for quarter in self._quarters.values())
        if as_asked or len(self._fresh) == len(TRANSFERS):
            self._fresh.clear()
            self._panels.show_transfers(draw_together([self._quarters[transfer].html for transfer in TRANSFERS]))


def _wish(transfer: str) -> str:
    return f"compared: {transfer}"


def _draw(world: World, snapshot: Snapshot, transfer: str) -> str:
    """Runs in the worker's thread."""
    joints, theta_demo = world.scene.moving_joints, snapshot.theta_demo
    if len(joints) == 2:
        return draw_quarter(world.scene, study(world, snapshot, transfer), theta_demo)
    views = snapshot.views
    spread = joint_uncertainty(world, TRANSFERS[transfer], views.demo, views.visible[:, :2], theta_demo)
    return draw_costs(joints, transfer, spread)

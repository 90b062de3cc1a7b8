"""The landscapes of all transfers in place of the one that is used: computed only while they are shown."""

from dataclasses import dataclass

from viewimit.observability import joint_uncertainty
from viewimit.snapshot import Snapshot
from viewimit.transfer import TRANSFERS
from viewimit.world import World

from .inbox import Inbox
from .landscape_worker import LandscapeWorker, landscape_key
from .panels import Panels
from .small_landscape import study
from .transfers_view import draw_costs, draw_transfers, waiting


@dataclass(frozen=True, eq=False)
class Compared:
    """A drawing of the landscapes in a world."""

    world: World
    html: str


class Comparison:
    """wishes: what may be asked, by the names in the inbox; each may raise ValueError."""

    def __init__(self, page_id: int, panels: Panels, inbox: Inbox, worker: LandscapeWorker):
        self._page_id, self._panels, self._inbox, self._worker = page_id, panels, inbox, worker
        self._shown = False
        self._asked: tuple | None = None
        self.wishes = {"transfers": self._toggle, "transfers compared": self._take}

    def tick(self, world: World, snapshot: Snapshot) -> None:
        """Ask anew if what is shown would differ."""
        if not self._shown:
            return
        asked = world, *landscape_key(snapshot, but=("transfer",))
        if asked == self._asked:
            return
        if self._asked is None or self._asked[0] is not world:
            self._panels.show_transfers(waiting("computing …"))
        self._asked = asked
        done = lambda made: self._inbox.put("transfers compared", made)
        self._worker.ask(self._page_id, lambda: _compare(world, snapshot), done, kind="transfers")

    def _toggle(self) -> None:
        self._shown, self._asked = not self._shown, None
        if not self._shown:
            self._panels.show_transfers(None)

    def _take(self, made: Compared | Exception) -> None:
        if isinstance(made, Exception):
            raise ValueError(f"no landscapes to compare: {made}")
        if self._shown and self._asked is not None and made.world is self._asked[0]:
            self._panels.show_transfers(made.html)


def _compare(world: World, snapshot: Snapshot) -> Compared:
    """Runs in the worker's thread."""
    joints = world.scene.moving_joints
    if len(joints) != 2:
        views, theta = snapshot.views, snapshot.theta_demo
        seen = views.demo, views.visible[:, :2], theta
        spreads = {name: joint_uncertainty(world, fit, *seen) for name, fit in TRANSFERS.items()}
        return Compared(world, draw_costs(joints, spreads))
    studied = [study(world, snapshot, transfer) for transfer in TRANSFERS]
    return Compared(world, draw_transfers(world.scene, studied, snapshot.theta_demo))

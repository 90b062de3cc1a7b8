"""What takes long is made beside the scheduler, in one thread for all pages; of a kind, a page's newest wish wins."""

import threading
import traceback
from collections.abc import Callable

from viewimit.analysis.landscape import Landscape, grid_axes, landscape
from viewimit.simulation.world import World
from viewimit.snapshot import Snapshot
from viewimit.transfer import TRANSFERS

LEARNERS_OWN = ("start_deg", "servo", "gain_error", "quantum_deg")


def landscape_key(snapshot: Snapshot, but: tuple[str, ...] = ()) -> tuple:
    """Everything that E over the postures depends on: all settings but where the learner starts and how it moves.

    but: further settings to leave out.
    """
    settings, but = snapshot.settings, (*LEARNERS_OWN, *but)
    return tuple(getattr(settings, name) for name in settings.__struct_fields__ if name not in but)


def compute(world: World, snapshot: Snapshot) -> Landscape | None:
    """E around the demonstrator as the learner has seen it; None unless two joints move."""
    if len(world.scene.moving_joints) != 2:
        return None
    views = snapshot.views
    return landscape(world, TRANSFERS[snapshot.settings.transfer], views.demo, views.visible[:, :2], grid_axes(world))


class LandscapeWorker:
    """`ask` returns at once; `done(result or exception)` is called from the worker's thread."""

    def __init__(self):
        self._wishes: dict[tuple[int, str], tuple] = {}
        self._changed = threading.Condition()
        threading.Thread(target=self._run, name="viewimit-landscapes", daemon=True).start()

    def ask(
        self, page_id: int, make: Callable[[], object], done: Callable[[object], None], kind: str = "landscape"
    ) -> None:
        with self._changed:
            self._wishes[page_id, kind] = make, done
            self._changed.notify()

    def forget(self, page_id: int) -> None:
        with self._changed:
            for wish in [wish for wish in self._wishes if wish[0] == page_id]:
                del self._wishes[wish]

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._wishes:
                    self._changed.wait()
                make, done = self._wishes.pop(next(iter(self._wishes)))
            try:
                made = make()
            except Exception as error:  # one page's fault must not end the others' landscapes; its page says so
                traceback.print_exc()
                made = error
            done(made)

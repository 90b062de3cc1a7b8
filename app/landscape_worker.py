"""Landscapes are computed beside the scheduler, in one thread for all pages; the newest wish of a page wins."""

import threading
import traceback
from collections.abc import Callable

from viewimit.landscape import Landscape, grid_axes, landscape
from viewimit.snapshot import Snapshot
from viewimit.transfer import TRANSFERS
from viewimit.world import World


def landscape_key(snapshot: Snapshot) -> tuple:
    """Everything that E over the postures depends on."""
    s = snapshot.settings
    return s.scene, s.robot, s.points, s.transfer, s.demonstrator_deg, s.noise_px, s.missing, s.seed


def compute(world: World, snapshot: Snapshot) -> Landscape | None:
    """E around the demonstrator as the learner has seen it; None unless two joints move."""
    if len(world.scene.moving_joints) != 2:
        return None
    views = snapshot.views
    return landscape(world, TRANSFERS[snapshot.settings.transfer], views.demo, views.visible[:, :2], grid_axes(world))


class LandscapeWorker:
    """`ask` returns at once; `done(result or exception)` is called from the worker's thread."""

    def __init__(self):
        self._wishes: dict[int, tuple] = {}
        self._changed = threading.Condition()
        threading.Thread(target=self._run, name="viewimit-landscapes", daemon=True).start()

    def ask(self, page_id: int, make: Callable[[], object], done: Callable[[object], None]) -> None:
        with self._changed:
            self._wishes[page_id] = make, done
            self._changed.notify()

    def forget(self, page_id: int) -> None:
        with self._changed:
            self._wishes.pop(page_id, None)

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._wishes:
                    self._changed.wait()
                page_id = next(iter(self._wishes))
                make, done = self._wishes.pop(page_id)
            try:
                made = make()
            except Exception as error:  # one page's fault must not end the others' landscapes; its page says so
                traceback.print_exc()
                made = error
            done(made)

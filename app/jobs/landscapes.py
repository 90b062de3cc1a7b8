"""Landscapes are made beside the scheduler, in one thread for all pages; of a kind, a page's newest request wins."""

import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from viewimit.analysis.minima import study_transfer
from viewimit.analysis.observability import joint_uncertainty
from viewimit.drawing.export.panels import compute_landscape
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.world import World

from ..drawing import duel
from ..drawing.landscapes import draw_compared, draw_costs


@dataclass(frozen=True, eq=False)
class ComparedTransfer:
    """One transfer's drawing among all, and what was asked for: a world and what E depends on."""

    asked: tuple
    html: str


@dataclass(frozen=True, eq=False)
class Ground:
    """What lies under the paths of a duel, drawn. html: of both learners' landscapes."""

    world: World
    html: str


def make_compared(asked: tuple, world: World, snapshot: Snapshot, transfer: str) -> ComparedTransfer:
    """For one transfer of all."""
    joints, theta_demo = world.scene.moving_joints, snapshot.theta_demo
    if len(joints) == 2:
        return ComparedTransfer(
            asked, draw_compared(world.scene, study_transfer(world, snapshot, transfer), theta_demo)
        )
    views = snapshot.views
    fit = partial(snapshot.fit, by=transfer)
    spread = joint_uncertainty(world, fit, views.demo, views.visible[:, :2], theta_demo)
    return ComparedTransfer(asked, draw_costs(joints, transfer, spread))


def make_ground(world: World, both: tuple[Snapshot, Snapshot]) -> Ground:
    """For both learners of a duel."""
    found = [made for made in (compute_landscape(world, snapshot) for snapshot in both) if made is not None]
    if len(found) < len(both):
        return Ground(world, duel.draw_empty_ground())
    return Ground(world, duel.draw_ground(world.scene, found, both[0].theta_demo))


class LandscapeWorker:
    """`ask` returns at once; `done(result or exception)` is called from the worker's thread."""

    def __init__(self):
        self._requests: dict[tuple[int, str], tuple] = {}
        self._changed = threading.Condition()
        threading.Thread(target=self._run, name="viewimit-landscapes", daemon=True).start()

    def ask(self, page_id: int, make: Callable[[], Any], done: Callable[[Any], None], kind: str = "landscape") -> None:
        with self._changed:
            self._requests[page_id, kind] = make, done
            self._changed.notify()

    def forget(self, page_id: int) -> None:
        with self._changed:
            for key in [key for key in self._requests if key[0] == page_id]:
                del self._requests[key]

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._requests:
                    self._changed.wait()
                make, done = self._requests.pop(next(iter(self._requests)))
            try:
                made = make()
            except Exception as error:  # one page's fault must not end the others' landscapes; its page says so
                if not isinstance(error, ValueError):  # which is an answer
                    traceback.print_exc()
                made = error
            done(made)

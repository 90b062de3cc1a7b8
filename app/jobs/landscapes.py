"""Landscapes are made beside the scheduler, in one thread for all pages; of a kind, a page's newest request wins."""

import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from viewimit.analysis.landscape import Landscape, conflict_at, grid_axes, landscape
from viewimit.analysis.observability import joint_uncertainty
from viewimit.analysis.study import study
from viewimit.disturbances import ArmDisturbance
from viewimit.drawing import duel
from viewimit.drawing.landscape import LandscapePicture
from viewimit.drawing.transfers import draw_compared, draw_costs
from viewimit.settings import disturbances
from viewimit.simulation.world import World
from viewimit.snapshot import Snapshot

LEARNERS_OWN = ("start_deg", "servo", *disturbances(ArmDisturbance))
COARSE_DEG, FINE_DEG = 4.0, 1.0  # a tenth of the time or less; what is shown in the end
TOO_FEW = "fewer than five points are seen in all four images"


@dataclass(frozen=True, eq=False)
class MadeLandscape:
    """E over all postures, drawn. E_true: px², with the learner in the demonstrator's posture. about: what was seen, if
    that is to be made anew, finer."""

    world: World
    picture: LandscapePicture
    E_true: float | None
    about: Snapshot | None = None


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


def landscape_key(snapshot: Snapshot, but: tuple[str, ...] = ()) -> tuple:
    """Everything that E over the postures depends on: all settings but where the learner starts and how it moves, and
    whether images are rectified and points exchanged back.

    but: further settings to leave out.
    """
    settings, but = snapshot.settings, (*LEARNERS_OWN, *but)
    chosen = (getattr(settings, name) for name in settings.__struct_fields__ if name not in but)
    return *chosen, snapshot.rectification is not None, snapshot.exchanged


def compute(world: World, snapshot: Snapshot, step_deg: float = FINE_DEG) -> Landscape | None:
    """E around the demonstrator as the learner has seen it; None unless two joints move."""
    if len(world.scene.moving_joints) != 2:
        return None
    views = snapshot.views
    return landscape(world, snapshot.fit, views.demo, views.visible[:, :2], grid_axes(world, step_deg))


def make_landscape(world: World, snapshot: Snapshot, step_deg: float = FINE_DEG) -> MadeLandscape:
    """For the transfer that is used."""
    made = compute(world, snapshot, step_deg)
    views, theta = snapshot.views, snapshot.theta_demo
    seen = world, snapshot.fit, views.demo, views.visible[:, :2]
    E_true = float(conflict_at(*seen, theta[:, None])[0, 0])
    spread = joint_uncertainty(*seen, theta)
    picture = LandscapePicture(made, world.scene, snapshot, TOO_FEW, spread)
    coarse = made is not None and step_deg > FINE_DEG
    return MadeLandscape(world, picture, E_true if np.isfinite(E_true) else None, snapshot if coarse else None)


def make_compared(asked: tuple, world: World, snapshot: Snapshot, transfer: str) -> ComparedTransfer:
    """For one transfer of all."""
    joints, theta_demo = world.scene.moving_joints, snapshot.theta_demo
    if len(joints) == 2:
        return ComparedTransfer(asked, draw_compared(world.scene, study(world, snapshot, transfer), theta_demo))
    views = snapshot.views
    fit = partial(snapshot.fit, by=transfer)
    spread = joint_uncertainty(world, fit, views.demo, views.visible[:, :2], theta_demo)
    return ComparedTransfer(asked, draw_costs(joints, transfer, spread))


def make_ground(world: World, both: tuple[Snapshot, Snapshot]) -> Ground:
    """For both learners of a duel."""
    found = [made for made in (compute(world, snapshot) for snapshot in both) if made is not None]
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
                traceback.print_exc()
                made = error
            done(made)

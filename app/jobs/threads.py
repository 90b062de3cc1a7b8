"""Landscapes are made beside the scheduler, in one thread for all pages; of a kind, a page's newest request wins."""

import threading
import time
import traceback
from collections.abc import Callable, Iterator
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
from .camera_images import CameraLost


@dataclass(frozen=True, eq=False)
class ComparedTransfer:
    """One transfer's drawing among all, and its request: a world and the values that E depends on."""

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


# Scripts are played in the background: in one thread of a process, in turns, of which the script that has had least of
# the time gets the next. So a short one does not wait for long ones.
# Between two turns the thread rests as long as the turn took, which leaves the pages time.

TURN_S = 0.02  # of one script, before the next has its turn
MAX_CPU_S = 30.0  # of one script


@dataclass(eq=False)
class _Job:
    passes: Iterator[None]
    done: Callable[[Exception | None], None]
    spent_s: float = 0.0


class ScriptPlayer:
    """`play` returns at once; done(error or None) is called from the player's thread, once.

    Parameters
    ----------
    clock
        s of processor time that the calling thread has taken.
    """

    def __init__(self, clock: Callable[[], float] = time.thread_time):
        self._clock = clock
        self._jobs: dict[int, _Job] = {}  # by page, of which the newest counts
        self._changed = threading.Condition()
        self._stopped = False
        threading.Thread(target=self._run, name="viewimit-scripts", daemon=True).start()

    def play(self, page_id: int, passes: Iterator[None], done: Callable[[Exception | None], None]) -> None:
        """Iterate over the passes of a script, instead of the page's earlier request."""
        with self._changed:
            self._jobs[page_id] = _Job(passes, done)
            self._changed.notify()

    def cancel(self, page_id: int) -> bool:
        """End what a page has asked for, which is then not done. Return whether there was something."""
        with self._changed:
            return self._jobs.pop(page_id, None) is not None

    def stop(self) -> None:
        """End all."""
        with self._changed:
            self._stopped = True
            self._jobs.clear()
            self._changed.notify()

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._jobs and not self._stopped:
                    self._changed.wait()
                if self._stopped:
                    return
                page_id, job = min(self._jobs.items(), key=lambda one: one[1].spent_s)
            began = time.thread_time()
            made = self._turn(job)
            with self._changed:
                is_current = self._jobs.get(page_id) is job  # else cancelled, or another took its place
                if is_current and made is not False:
                    del self._jobs[page_id]
            if is_current and made is not False:
                job.done(None if made is True else made)
            time.sleep(time.thread_time() - began)  # half of the time is the pages'; no longer on a busy machine

    def _turn(self, job: _Job) -> Exception | bool:
        """Play on for a turn. Return whether it is whole, or what has failed."""
        began = self._clock()
        try:
            for __ in job.passes:
                spent = self._clock() - began
                if job.spent_s + spent > MAX_CPU_S:
                    return ValueError(f"it takes more than {MAX_CPU_S:g} s to compute")
                if spent > TURN_S:
                    job.spent_s += spent
                    return False
        except (ValueError, CameraLost) as error:
            return error
        except Exception as error:  # of one page, which says so; the others' scripts go on
            traceback.print_exc()
            return error
        return True

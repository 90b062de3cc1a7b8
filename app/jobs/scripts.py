"""Scripts are played beside the pages: in one thread of a process, in turns, of which the script that has had least of
the time gets the next. So a short one does not wait for long ones.

Between two turns the thread rests as long as the turn took, which leaves the pages time.
"""

import threading
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from .camera_images import CameraLost

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
        """Iterate over the passes of a script, in place of what the page has asked for before."""
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
            began = time.monotonic()
            made = self._turn(job)
            with self._changed:
                is_wanted = self._jobs.get(page_id) is job  # else cancelled, or another took its place
                if is_wanted and made is not False:
                    del self._jobs[page_id]
            if is_wanted and made is not False:
                job.done(None if made is True else made)
            time.sleep(time.monotonic() - began)

    def _turn(self, job: _Job) -> Exception | bool:
        """Play on for a turn. Return whether it is whole, or what has failed."""
        began = self._clock()
        try:
            for _ in job.passes:
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

"""Scripts are played beside the pages: in one thread of a process, some passes of each in turn, into new sessions.

Between two turns the thread rests as long as the turn took, which leaves the pages time.
"""

import threading
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from viewimit.loop.script import Script
from viewimit.loop.session import Session

TURN_S = 0.02  # of one script, before the next has its turn
MAX_CPU_S = 30.0  # of one script


@dataclass(eq=False)
class _Job:
    passes: Iterator[Session]
    done: Callable[[Session | Exception], None]
    session: Session | None = None  # as far as it is
    spent_s: float = 0.0


class ScriptPlayer:
    """`play` returns at once; done(session or ValueError) is called from the player's thread, once.

    Parameters
    ----------
    clock
        s of processor time that the calling thread has taken.
    """

    def __init__(self, clock: Callable[[], float] = time.thread_time):
        self._clock = clock
        self._jobs: dict[int, _Job] = {}  # by page, of which the newest counts; the next in turn first
        self._changed = threading.Condition()
        self._stopped = False
        threading.Thread(target=self._run, name="viewimit-scripts", daemon=True).start()

    def play(
        self, page_id: int, script: Script, session: Callable[[], Session], done: Callable[[Session | Exception], None]
    ) -> None:
        """Play a script into a new session, in place of what the page has asked for before."""
        with self._changed:
            self._jobs[page_id] = _Job(_played(script, session), done)
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
                page_id, job = next(iter(self._jobs.items()))
            began = time.monotonic()
            made = self._turn(job)
            with self._changed:
                is_wanted = self._jobs.get(page_id) is job  # else cancelled, or another took its place
                if is_wanted:
                    del self._jobs[page_id]
                if is_wanted and made is None:
                    self._jobs[page_id] = job  # the last in turn
            if is_wanted and made is not None:
                job.done(made)
            time.sleep(time.monotonic() - began)

    def _turn(self, job: _Job) -> Session | Exception | None:
        """Play on for a turn. Return the session once it is whole, what has failed, or None while it goes on."""
        began = self._clock()
        try:
            for session in job.passes:
                job.session = session
                spent = self._clock() - began
                if job.spent_s + spent > MAX_CPU_S:
                    return ValueError(f"it takes more than {MAX_CPU_S:g} s to compute")
                if spent > TURN_S:
                    job.spent_s += spent
                    return None
        except ValueError as error:
            return error
        except Exception as error:  # of one page, which says so; the others' scripts go on
            traceback.print_exc()
            return error
        return job.session


def _played(script: Script, make: Callable[[], Session]) -> Iterator[Session]:
    """Yield the session after each pass."""
    session = make()
    yield session
    for _ in session.passes(script):
        yield session

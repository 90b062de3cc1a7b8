"""Independent work in several processes here. A script that asks for more than one needs `if __name__ ==
"__main__":`."""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass

from .executor import Batch, Done, carry_out

AHEAD = 2  # batches a process that wait for it, so that it never waits for them


@dataclass(frozen=True)
class LocalPool:
    """processes: None as many as processors; one is this one."""

    processes: int | None = None

    def run(self, work: Callable, batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
        workers = min(self.processes or os.cpu_count() or 1, len(batches))
        if workers <= 1:
            yield from ((number, carry_out(work, batch)) for number, batch in batches)
            return
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _begin)
        try:
            left, ahead = iter(batches), dict[Future, int]()
            while True:
                for number, batch in left:
                    with _beginning():
                        ahead[pool.submit(carry_out, work, batch)] = number
                    if len(ahead) >= (1 + AHEAD) * workers:
                        break
                if not ahead:
                    break
                for future in wait(ahead, return_when=FIRST_COMPLETED).done:
                    yield ahead.pop(future), future.result()
        except BaseException:  # nothing is cancelled: the pool would stumble over that when its workers end
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
            raise
        finally:
            pool.shutdown()


@contextlib.contextmanager
def _beginning() -> Iterator[None]:
    """Workers that are begun inside hear of no Ctrl-C before they leave it to this process: each would tell of it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin() -> None:
    """In a worker: it ends with the process that it works for, however that ends, and leaves Ctrl-C to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None  # as this is a worker
    parent.join()
    os._exit(1)

"""Independent work in several processes. A script that asks for more than one needs `if __name__ == "__main__":`."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor


def each(work: Callable, tasks: Sequence[tuple], workers: int | None = None) -> Iterator:
    """work(*task) of every task, in their order. workers: None as many as processors; one works in this process.

    A task takes long enough to be sent alone.
    """
    workers = min(workers or os.cpu_count() or 1, len(tasks))
    if workers <= 1:
        yield from (work(*task) for task in tasks)
        return
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _begin)
    try:
        ahead = deque(pool.submit(work, *task) for task in tasks)
        while ahead:
            yield ahead.popleft().result()
    except BaseException:  # nothing is cancelled: the pool would stumble over that when its workers end
        for worker in set(multiprocessing.active_children()) - others:
            worker.terminate()
        raise
    finally:
        pool.shutdown()


def _begin() -> None:
    """In a worker: it ends with the process that it works for, however that ends, and leaves Ctrl-C to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None  # as this is a worker
    parent.join()
    os._exit(1)

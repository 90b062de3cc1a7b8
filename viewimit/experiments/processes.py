"""Independent work in several processes. A script that asks for more than one needs `if __name__ == "__main__":`."""

import multiprocessing
import os
import signal
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
    # Ctrl-C reaches the workers too: they leave it to this process, which ends them.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, signal.signal, (signal.SIGINT, signal.SIG_IGN))
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

"""Executors: they carry out the tasks of a study, batch by batch, in processes here or elsewhere.

A script that asks for more than one local process needs `if __name__ == "__main__":`.
"""

import contextlib
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from typing import Any, Protocol

Batch = Sequence[tuple[Any, ...]]  # of tasks, each the arguments of one call

QUEUED_BATCHES = 2  # for each process, so that it never waits for the next


class StudyError(Exception):
    """A study cannot be begun or go on; the message says why, where and what to do, in a line."""


@dataclass(frozen=True)
class Done:
    """A finished batch."""

    results: list[Any]  # one for each task, in order
    cpu_s: float  # CPU time of the whole batch on one core


class Executor(Protocol):
    """Carries out the tasks of a study."""

    def run(self, work: Callable[..., Any], batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
        """Call work(*task) for every task.

        Parameters
        ----------
        work : callable
            Carries out one task. Its exception ends the study.
        batches : sequence of (int, sequence of tuple)
            Tasks, in numbered batches.

        Yields
        ------
        (int, Done)
            Each batch with its number when it is done, in any order.

        Raises
        ------
        StudyError
            If the batches cannot be carried out.
        """
        ...


def carry_out(work: Callable[..., Any], batch: Batch) -> Done:
    """Call work(*task) for every task, in this process."""
    began = time.thread_time()
    results = [work(*task) for task in batch]
    return Done(results, time.thread_time() - began)


@dataclass(frozen=True)
class LocalPool:
    """Executor that uses processes on this machine."""

    processes: int | None = None  # None: as many as processors; 1: this process

    def run(self, work: Callable[..., Any], batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
        """See `Executor.run`."""
        workers = min(self.processes or os.cpu_count() or 1, len(batches))
        if workers <= 1:
            yield from ((number, carry_out(work, batch)) for number, batch in batches)
            return
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _start_worker)
        try:
            left, running = iter(batches), dict[Future, int]()
            while True:
                for number, batch in left:
                    with _interrupts_blocked():
                        running[pool.submit(carry_out, work, batch)] = number
                    if len(running) >= (1 + QUEUED_BATCHES) * workers:
                        break
                if not running:
                    break
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
        except BaseException:  # nothing is cancelled: the pool would fail on that when its workers end
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
            raise
        finally:
            pool.shutdown()


@contextlib.contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block Ctrl-C in workers that start inside, until they ignore it: each would print a traceback."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_worker() -> None:
    """Let this worker ignore Ctrl-C, and end with its parent process, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None  # this is a worker
    parent.join()
    os._exit(1)

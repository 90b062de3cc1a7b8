"""What carries out the tasks of a study, batch by batch: the same results, wherever that is."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

Batch = Sequence[tuple]  # of tasks


class StudyError(Exception):
    """A study cannot be begun or go on; the message says why, where and what to do, in a line."""


@dataclass(frozen=True)
class Done:
    """Of a batch: a result for each task, in order, and the CPU time that they took together, s on one core."""

    results: list
    cpu_s: float


class Executor(Protocol):
    def run(self, work: Callable, batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
        """work(*task) of every task. batches: each with its number → numbers and what came of them, as they are done.

        An exception of `work` ends it all. Raises StudyError if the batches cannot be carried out.
        """
        ...


def carry_out(work: Callable, batch: Batch) -> Done:
    """Where the work is done."""
    began = time.thread_time()
    results = [work(*task) for task in batch]
    return Done(results, time.thread_time() - began)

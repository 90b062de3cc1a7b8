"""Many independent runs: where they are made, what is kept of them meanwhile, and what they cost."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from .executor import Batch, Done, Executor
from .folder import StudyFolder
from .local import LocalPool

BATCHES, MOST_TASKS = 1000, 100  # of a study, before more than one task makes a batch; tasks of a batch


@dataclass
class Study:
    """executor: where the work is done; folder: that keeps what is done, None for none.

    runs, cpu_s: of all that was done so far, here or elsewhere, now or before it was kept: how many, a list of them
    counting as that many, and the CPU time that they took, s on one core; kept: how many of these were kept before.
    """

    executor: Executor = field(default_factory=LocalPool)
    folder: StudyFolder | None = None
    runs: int = 0
    kept: int = 0
    cpu_s: float = 0.0
    _stages: int = 0

    def each(self, work: Callable, tasks: Sequence[tuple]) -> Iterator:
        """work(*task) of every task, in their order, wherever it is done. With a folder, what `work` gives must be told
        by the types that it declares."""
        stage, self._stages = self._stages, self._stages + 1
        batches = in_batches(tasks)
        there = {number for number, _ in batches if self._read(stage, number, work) is not None}
        found = self.executor.run(work, [batch for batch in batches if batch[0] not in there])
        ready: dict[int, Done] = {}
        for number, _ in batches:
            done = self._read(stage, number, work) if number in there else None
            while done is None and number not in ready:
                new, made = next(found)
                if self.folder is not None:
                    self.folder.keep(stage, new, made)
                ready[new] = made
            done = done or ready.pop(number)
            runs = sum(len(result) if isinstance(result, list) else 1 for result in done.results)
            self.runs, self.cpu_s = self.runs + runs, self.cpu_s + done.cpu_s
            self.kept += runs if number in there else 0
            yield from done.results
        assert next(found, None) is None  # it has given all, and ends what it began

    def _read(self, stage: int, number: int, work: Callable) -> Done | None:
        return None if self.folder is None else self.folder.read(stage, number, work)


def each(work: Callable, tasks: Sequence[tuple], by: int | Study | None = None) -> Iterator:
    """work(*task) of every task, in their order, in a study or in so many processes, if None as many as processors."""
    return (by if isinstance(by, Study) else Study(LocalPool(by))).each(work, tasks)


def in_batches(tasks: Sequence[tuple]) -> list[tuple[int, Batch]]:
    """Numbered. They depend on the number of tasks alone, so that any executor goes on with what another has kept."""
    size = min(max(len(tasks) // BATCHES, 1), MOST_TASKS)
    return [(k, tasks[first : first + size]) for k, first in enumerate(range(0, len(tasks), size))]

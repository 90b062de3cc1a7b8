"""Independent work on a Dask cluster: an existing scheduler shares it among its workers, and gives what a lost worker
had to another. Each worker needs the same viewimit and numpy, and one thread: `dask worker ADDRESS --nthreads 1`."""

import asyncio
import importlib.util
import pickle
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from .executor import Batch, Done, StudyError, carry_out
from .fingerprint import OtherCode, code, require_code

AHEAD = 2  # batches a thread of the cluster that wait for it
CONNECT_S = 30.0  # until a scheduler, and then its first worker, must have been found
MOST_LOST = 3  # times that a batch is handed out anew after the scheduler has given it up, for it lost 4 workers each


@dataclass(frozen=True)
class Cluster:
    """address: of its scheduler, such as tcp://10.0.0.1:8786."""

    address: str

    def run(self, work: Callable, batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
        if not batches:
            return
        if importlib.util.find_spec("distributed") is None:
            raise StudyError(f"{self.address}: a cluster needs dask.distributed: pip install 'viewimit[cluster]'")
        import distributed

        try:
            client = distributed.Client(self.address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            raise StudyError(f"{self.address}: no Dask scheduler answers ({_line(error)})") from None
        with client:
            try:
                client.wait_for_workers(1, timeout=CONNECT_S)
            except asyncio.TimeoutError:  # which is another on Python 3.10
                told = f"start some: dask worker {self.address} --nthreads 1"
                raise StudyError(f"{self.address}: that scheduler has no workers; {told}") from None
            yield from _run(client, work, batches)


def _run(client: Any, work: Callable, batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
    import distributed

    left, ahead, lost = iter(batches), dict[Any, tuple[int, bytes]](), dict[int, int]()
    done = distributed.as_completed(loop=client.loop)

    def submit(number: int, packed: bytes) -> None:
        """Packed, so that Dask does not look for tasks of its own among the tuples."""
        future = client.submit(_carry_out, packed, code(), pure=False)
        ahead[future] = number, packed
        done.add(future)

    def fill() -> None:
        most = (1 + AHEAD) * max(sum(client.nthreads().values()), 1)
        while len(ahead) < most and (following := next(left, None)) is not None:
            submit(following[0], pickle.dumps((work, following[1])))

    fill()
    for future in done:
        number, packed = ahead.pop(future)
        try:
            found = future.result()
        except distributed.KilledWorker as error:
            lost[number] = lost.get(number, 0) + 1
            if lost[number] > MOST_LOST:
                raise StudyError(f"batch {number} loses every worker that takes it: {_line(error)}") from None
            submit(number, packed)
            continue
        except distributed.client.FutureCancelledError as error:
            raise StudyError(f"the scheduler at {client.scheduler.address} is lost: {_line(error)}") from None
        except OtherCode as error:
            raise StudyError(_line(error)) from None
        except ModuleNotFoundError as error:
            raise StudyError(f"a worker of {client.scheduler.address} lacks what the study needs: {error}") from None
        fill()
        yield number, found


def _carry_out(packed: bytes, expected: str) -> Done:
    """On a worker."""
    import distributed

    try:
        require_code(expected)
    except OtherCode as error:
        raise OtherCode(f"the worker {distributed.get_worker().address} {error}") from None
    work, batch = pickle.loads(packed)
    return carry_out(work, batch)


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__

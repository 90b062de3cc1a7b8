"""Executor on a Dask cluster: an existing scheduler distributes the batches, and repeats those of lost workers.

Each worker needs the same viewimit and numpy, and one thread: `dask worker ADDRESS --nthreads 1`.
"""

import asyncio
import hashlib
import importlib.util
import pickle
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ... import __version__
from ...assets import ROOT
from .executor import QUEUED_BATCHES, Batch, Done, StudyError, carry_out

CONNECT_S = 30.0  # time to find a scheduler, and then to find its first worker
MAX_RESUBMISSIONS = 3  # of a batch that the scheduler has given up, each after 4 lost workers
LIBRARY = Path(__file__).parents[2]
WITHOUT_EFFECT = {"app", "assets", "commands", "drawing"}  # packages that change no digit of a result


class OtherCode(Exception):
    """A worker has another version of this library."""


@cache
def code_version() -> str:
    """Return what the digits of a result depend on, besides its settings: this library's code and numpy's version.

    Such as "viewimit 0.1.0 (3f0c9a81d2b4), numpy 2.1.0", with a hash of the library's sources and scenes.
    """
    found = hashlib.sha256()
    sources = [path for path in LIBRARY.rglob("*.py") if path.relative_to(LIBRARY).parts[0] not in WITHOUT_EFFECT]
    for path in [*sorted(sources), *sorted(ROOT.rglob("*.toml")), *sorted(ROOT.rglob("*.urdf"))]:
        found.update(path.name.encode() + b"\0" + path.read_bytes().replace(b"\r\n", b"\n"))
    return f"viewimit {__version__} ({found.hexdigest()[:12]}), numpy {np.__version__}"


@dataclass(frozen=True)
class Cluster:
    """Executor that uses a Dask cluster."""

    address: str  # of its scheduler, such as tcp://10.0.0.1:8786

    def run(self, work: Callable[..., Any], batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
        """See `Executor.run`."""
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
            except asyncio.TimeoutError:  # another class on Python 3.10
                advice = f"start some: dask worker {self.address} --nthreads 1"
                raise StudyError(f"{self.address}: that scheduler has no workers; {advice}") from None
            yield from _run(client, work, batches)


def _run(client: Any, work: Callable[..., Any], batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
    import distributed

    left, running, lost = iter(batches), dict[Any, tuple[int, bytes]](), dict[int, int]()
    done, version = distributed.as_completed(loop=client.loop), code_version()

    def submit(number: int, packed: bytes) -> None:
        """Pickled, so that Dask does not look for tasks of its own among the tuples."""
        future = client.submit(_carry_out, packed, version, pure=False)
        running[future] = number, packed
        done.add(future)

    def fill() -> None:
        most = (1 + QUEUED_BATCHES) * max(sum(client.nthreads().values()), 1)
        while len(running) < most and (following := next(left, None)) is not None:
            submit(following[0], pickle.dumps((work, following[1])))

    fill()
    for future in done:
        number, packed = running.pop(future)
        try:
            found = future.result()
        except distributed.KilledWorker as error:
            lost[number] = lost.get(number, 0) + 1
            if lost[number] > MAX_RESUBMISSIONS:
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
    """Runs on a worker."""
    import distributed

    if code_version() != expected:
        raise OtherCode(
            f"the worker {distributed.get_worker().address} has {code_version()}, and the study is of {expected}: "
            "install the same there"
        )
    work, batch = pickle.loads(packed)
    return carry_out(work, batch)


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__

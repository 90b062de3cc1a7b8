"""Studies: many independent runs, on any executor, with a folder that keeps finished batches."""

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import GenericAlias
from typing import Any, get_type_hints

import msgspec
import numpy as np
import zstandard

from .executor import Batch, Done, Executor, LocalPool, StudyError

MIN_BATCHES, MAX_BATCH_TASKS = 1000, 100  # of a study, before a batch has more than one task; of a batch
STUDY_FILE = "study.json"


class StudyFolder:
    """A folder that keeps the batches of a study, so that it goes on after an interruption.

    Parameters
    ----------
    folder : Path
        Made if need be.
    study : dict
        Everything that the results depend on, as JSON.

    Raises
    ------
    StudyError
        For a folder that holds another study or other files (the message says what differs), or is not writable.
    """

    def __init__(self, folder: Path, study: dict[str, Any]):
        self.folder, self._key = folder, hashlib.sha256(_json(study)).hexdigest()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            path = folder / STUDY_FILE
            if path.exists():
                _require_same(folder, path.read_bytes(), study)
            elif any(folder.iterdir()):
                raise StudyError(f"{folder}: is not empty and holds no study: take another folder")
            else:
                _write(path, _json(study))
        except OSError as error:
            raise StudyError(f"{folder}: {error.strerror or error}") from None

    def read(self, stage: int, number: int, work: Callable[..., Any]) -> Done | None:
        """Read a batch of `work`; None if it is missing or damaged, as after an interrupted write."""
        try:
            content = zstandard.ZstdDecompressor().decompress(self._path(stage, number).read_bytes())
            key, results, cpu_s = msgspec.msgpack.decode(content, type=tuple[str, msgspec.Raw, float])
            if key != self._batch_key(stage, number):
                return None
            result = get_type_hints(work)["return"]
            return Done(msgspec.msgpack.decode(results, type=GenericAlias(list, result), dec_hook=_array), cpu_s)
        except (OSError, zstandard.ZstdError, msgspec.MsgspecError):
            return None

    def keep(self, stage: int, number: int, done: Done) -> None:
        """Write a batch, all or nothing. Raises StudyError if it cannot be written."""
        results = msgspec.Raw(msgspec.msgpack.encode(done.results, enc_hook=_plain))
        content = msgspec.msgpack.encode((self._batch_key(stage, number), results, done.cpu_s))
        path = self._path(stage, number)
        try:
            _write(path, zstandard.ZstdCompressor(write_checksum=True).compress(content))
        except OSError as error:
            raise StudyError(f"{path}: {error.strerror or error}; finished batches are kept") from None

    def _path(self, stage: int, number: int) -> Path:
        return self.folder / f"{stage:02}-{number:06}.batch"

    def _batch_key(self, stage: int, number: int) -> str:
        """Kept inside the file: it rejects a file that was renamed or comes from another study."""
        return f"{self._key}-{stage}-{number}"


def _require_same(folder: Path, kept: bytes, study: dict[str, Any]) -> None:
    try:
        other = json.loads(kept)
    except ValueError:
        other = None
    if not isinstance(other, dict):
        raise StudyError(f"{folder / STUDY_FILE}: is not readable: take another folder")
    for name in dict.fromkeys([*study, *other]):
        if other.get(name) != json.loads(_json(study)).get(name):
            there, here = other.get(name), study.get(name)
            raise StudyError(f"{folder}: holds another study, {name} {there} and not {here}: take another folder")


def _write(path: Path, content: bytes) -> None:
    """Write atomically."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    with part.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)


def _json(study: dict[str, Any]) -> bytes:
    return json.dumps(study, indent=1, ensure_ascii=False).encode() + b"\n"


def _plain(value: Any) -> Any:
    """A numpy scalar as Python's, an array as its type, shape and bytes."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    raise NotImplementedError(f"cannot keep a {type(value).__name__}")


def _array(kind: Any, kept: Any) -> Any:
    if getattr(kind, "__origin__", kind) is not np.ndarray:
        raise NotImplementedError(f"cannot read a {kind}")
    dtype, shape, content = kept
    return np.frombuffer(content, dtype).reshape(shape)


@dataclass
class Study:
    """Runs tasks on an executor, keeps results in a folder, and counts what they cost."""

    executor: Executor = field(default_factory=LocalPool)
    folder: StudyFolder | None = None
    runs: int = 0  # finished so far; a list of results counts as that many
    kept: int = 0  # of these, read from the folder
    cpu_s: float = 0.0  # CPU time of all runs on one core, wherever and whenever they were made
    _stages: int = 0

    def each(self, work: Callable[..., Any], tasks: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
        """Yield work(*task) for every task, in their order.

        With a folder, the results must be described by the return type that `work` declares.
        """
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
        assert next(found, None) is None  # all batches are done; the executor ends its workers

    def _read(self, stage: int, number: int, work: Callable[..., Any]) -> Done | None:
        return None if self.folder is None else self.folder.read(stage, number, work)


def in_batches(tasks: Sequence[tuple[Any, ...]]) -> list[tuple[int, Batch]]:
    """Divide tasks into numbered batches.

    Batches depend on the number of tasks alone, so that any executor goes on with those that another one has kept.
    """
    size = min(max(len(tasks) // MIN_BATCHES, 1), MAX_BATCH_TASKS)
    return [(k, tasks[first : first + size]) for k, first in enumerate(range(0, len(tasks), size))]

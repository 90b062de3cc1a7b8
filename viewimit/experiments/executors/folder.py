"""A folder that keeps the batches of a study as they are done, so that it goes on after whatever ended it."""

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from types import GenericAlias
from typing import Any, get_type_hints

import msgspec
import numpy as np
import zstandard

from .executor import Done, StudyError

WHAT = "study.json"


class StudyFolder:
    """folder: made if need be; what: the study by what its results depend on, as JSON has it, words first.

    Raises StudyError, with a line that says what differs, for a folder that holds another study or other files, or
    where nothing can be written.
    """

    def __init__(self, folder: Path, what: dict[str, Any]):
        self.folder, self._key = folder, hashlib.sha256(_json(what)).hexdigest()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            there = folder / WHAT
            if there.exists():
                _require_same(folder, there.read_bytes(), what)
            elif any(folder.iterdir()):
                raise StudyError(f"{folder}: is not empty and holds no study: take another folder")
            else:
                _write(there, _json(what))
        except OSError as error:
            raise StudyError(f"{folder}: {error.strerror or error}") from None

    def read(self, stage: int, number: int, work: Callable) -> Done | None:
        """What is kept of a batch of `work`; None if it is not, or cannot be read, as where writing was interrupted."""
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
        """All of a batch, or nothing. Raises StudyError where it cannot be written."""
        results = msgspec.Raw(msgspec.msgpack.encode(done.results, enc_hook=_plain))
        content = msgspec.msgpack.encode((self._batch_key(stage, number), results, done.cpu_s))
        path = self._path(stage, number)
        try:
            _write(path, zstandard.ZstdCompressor(write_checksum=True).compress(content))
        except OSError as error:
            raise StudyError(f"{path}: {error.strerror or error}; what was done before is kept") from None

    def _path(self, stage: int, number: int) -> Path:
        return self.folder / f"{stage:02}-{number:06}.batch"

    def _batch_key(self, stage: int, number: int) -> str:
        """A file that was renamed, or came from another study, is none of this one's."""
        return f"{self._key}-{stage}-{number}"


def _require_same(folder: Path, kept: bytes, what: dict[str, Any]) -> None:
    try:
        other = json.loads(kept)
    except ValueError:
        other = None
    if not isinstance(other, dict):
        raise StudyError(f"{folder / WHAT}: is not readable: take another folder")
    for name in dict.fromkeys([*what, *other]):
        if other.get(name) != json.loads(_json(what)).get(name):
            there, here = other.get(name), what.get(name)
            raise StudyError(f"{folder}: holds another study, {name} {there} and not {here}: take another folder")


def _write(path: Path, content: bytes) -> None:
    """At once: nobody sees half of it."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    with part.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)


def _json(what: dict[str, Any]) -> bytes:
    return json.dumps(what, indent=1, ensure_ascii=False).encode() + b"\n"


def _plain(value: Any) -> Any:
    """Of numpy's kinds: a scalar as Python's, an array as its type, shape and bytes."""
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

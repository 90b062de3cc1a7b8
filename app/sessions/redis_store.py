"""Sessions in a Redis, one hash each: what several servers behind one proxy share."""

from collections.abc import Callable, Iterable
from typing import Any

try:
    import redis
except ImportError:
    raise ValueError("a Redis needs the package redis: pip install 'viewimit[redis]'") from None

from .store import KEPT_S

WRITER = b"writer"  # the field beside the parts, which are named part:…
TIMEOUT_S = 3.0


class RedisStore:
    """See Store. Redis itself removes what has had no sign of life."""

    def __init__(self, url: str):
        self._redis = redis.Redis.from_url(url, socket_timeout=TIMEOUT_S, socket_connect_timeout=TIMEOUT_S)
        try:
            self._redis.ping()
        except redis.RedisError as error:
            raise OSError(f"cannot reach the Redis: {error}") from None

    def claim(self, key: str, writer: str) -> dict[str, bytes]:
        def claim(pipe) -> dict[str, bytes]:
            fields = pipe.hgetall(_name(key))
            pipe.multi()
            if fields:
                pipe.hset(_name(key), WRITER, writer)
                pipe.expire(_name(key), KEPT_S)
            return fields

        found = self._run(claim, key)
        return {name.decode().removeprefix("part:"): data for name, data in found.items() if name != WRITER}

    def save(self, key: str, writer: str, parts: dict[str, bytes], gone: Iterable[str] = ()) -> bool:
        def save(pipe) -> bool:
            owner = pipe.hget(_name(key), WRITER)
            pipe.multi()
            if owner is not None and owner.decode() != writer:
                return False
            if gone := [f"part:{name}" for name in gone_names]:
                pipe.hdel(_name(key), *gone)
            fields: dict[str | bytes, str | bytes] = {f"part:{name}": data for name, data in parts.items()}
            pipe.hset(_name(key), mapping={WRITER: writer, **fields})
            pipe.expire(_name(key), KEPT_S)
            return True

        gone_names = list(gone)
        return self._run(save, key)

    def touch(self, keys: Iterable[str]) -> None:
        try:
            with self._redis.pipeline(transaction=False) as pipe:
                for key in keys:
                    pipe.expire(_name(key), KEPT_S)
                pipe.execute()
        except redis.RedisError as error:
            raise OSError(f"the Redis did not answer: {error}") from None

    def close(self) -> None:
        self._redis.close()

    def _run(self, change: Callable[[Any], Any], key: str) -> Any:
        """Read and change as one: tried again if somebody else came between."""
        try:
            return self._redis.transaction(change, _name(key), value_from_callable=True)
        except redis.RedisError as error:
            raise OSError(f"the Redis did not answer: {error}") from None


def _name(key: str) -> str:
    return f"viewimit:{key}"

"""Sessions in a Redis, one hash each: what several servers behind one proxy share."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

try:
    import redis
except ImportError:
    raise ValueError("a Redis needs the package redis: pip install 'viewimit[redis]'") from None

from .store import KEPT_S, LEASE_S

WRITER = b"writer"  # the field beside the parts, which are named part:…
TIMEOUT_S = 3.0
LEASE_MS = round(1e3 * LEASE_S)
# KEYS: a session and its lease; ARGV: writer, then times. A script is carried out as one
RENEW = """
if redis.call('HGET', KEYS[1], 'writer') ~= ARGV[1] then return 0 end
redis.call('SET', KEYS[2], ARGV[1], 'PX', ARGV[2])
redis.call('EXPIRE', KEYS[1], ARGV[3])
return 1
"""
RELEASE = """
if redis.call('HGET', KEYS[1], 'writer') ~= ARGV[1] then return 0 end
redis.call('HSET', KEYS[1], 'writer', '')
redis.call('DEL', KEYS[2])
return 1
"""


class RedisStore:
    """See Store. Redis itself removes what has had no sign of life."""

    def __init__(self, url: str):
        self._redis = redis.Redis.from_url(url, socket_timeout=TIMEOUT_S, socket_connect_timeout=TIMEOUT_S)
        try:
            self._redis.ping()
        except redis.RedisError as error:
            raise OSError(f"cannot reach the Redis: {error}") from None

    def claim(self, key: str, writer: str) -> dict[str, bytes] | None:
        def claim(pipe) -> dict[str, bytes] | None:
            leased, fields = pipe.exists(_lease(key)), pipe.hgetall(_name(key))
            pipe.multi()
            if leased:
                return None
            pipe.set(_lease(key), writer, px=LEASE_MS)
            pipe.hset(_name(key), WRITER, writer)
            pipe.expire(_name(key), KEPT_S)
            return {name.decode().removeprefix("part:"): data for name, data in fields.items() if name != WRITER}

        return self._run(claim, key)

    def held(self, keys: Iterable[str]) -> dict[str, float]:
        keys = list(keys)
        left = self._at_once(lambda pipe: [pipe.pttl(_lease(key)) for key in keys])
        return {key: ms / 1e3 for key, ms in zip(keys, left) if ms > 0}

    def renew(self, leases: Mapping[str, str]) -> set[str]:
        def renew(pipe) -> None:
            for key, writer in leases.items():
                pipe.eval(RENEW, 2, _name(key), _lease(key), writer, LEASE_MS, KEPT_S)

        return {key for key, mine in zip(leases, self._at_once(renew)) if not mine}

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

    def release(self, key: str, writer: str) -> None:
        self._at_once(lambda pipe: pipe.eval(RELEASE, 2, _name(key), _lease(key), writer))

    def close(self) -> None:
        self._redis.close()

    def _run(self, change: Callable[[Any], Any], key: str) -> Any:
        """Read and change as one: tried again if somebody else came between."""
        try:
            return self._redis.transaction(change, _name(key), _lease(key), value_from_callable=True)
        except redis.RedisError as error:
            raise OSError(f"the Redis did not answer: {error}") from None

    def _at_once(self, put: Callable[[Any], Any]) -> list:
        """What the commands answer that `put` puts into a pipeline: one way there and back."""
        try:
            with self._redis.pipeline(transaction=False) as pipe:
                put(pipe)
                return pipe.execute()
        except redis.RedisError as error:
            raise OSError(f"the Redis did not answer: {error}") from None


def _name(key: str) -> str:
    return f"viewimit:{key}"


def _lease(key: str) -> str:
    return f"viewimit:{key}:lease"

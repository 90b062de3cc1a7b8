"""Sessions in a Redis, one hash each: what several servers behind one proxy share."""

import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

try:
    import redis
    from redis.backoff import NoBackoff
    from redis.retry import Retry
except ImportError:
    raise ValueError("a Redis needs the package redis: pip install 'viewimit[redis]'") from None

from .store import KEPT_S, LEASE_S, MOST_BYTES

WRITER = b"writer"  # the field beside the parts, which are named part:…
TIMEOUT_S = 1.5
LEASE = b":lease"  # behind the name of a session
LEASE_MS = round(1e3 * LEASE_S)
# KEYS: a session and its lease; ARGV: writer, then times. A script is carried out as one
RENEW = """
local writer = redis.call('HGET', KEYS[1], 'writer')
if writer and writer ~= ARGV[1] then return 0 end
redis.call('HSET', KEYS[1], 'writer', ARGV[1])
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
LOOKED_AT_EVERY = 16  # part of the most bytes that this process writes between two looks at how many there are
LOOKED_AT_AFTER_S = 60.0  # at the latest, for others write as well, and one that has just begun knows of none of it


class RedisStore:
    """See Store. Redis itself removes what has had no sign of life. most_bytes: of all sessions in it, about."""

    def __init__(
        self,
        url: str,
        most_bytes: int = MOST_BYTES,
        timeout_s: float = TIMEOUT_S,
        clock: Callable[[], float] = time.monotonic,
    ):
        once = Retry(NoBackoff(), 1, (redis.ConnectionError,))  # it may have been restarted; one that hangs still does
        self._most_bytes, self._unseen, self._clock = most_bytes, 0, clock
        self._looked_at = -LOOKED_AT_AFTER_S  # s, at how many bytes there are
        try:
            self._redis = redis.Redis.from_url(
                url, socket_timeout=timeout_s, socket_connect_timeout=timeout_s, retry=once
            )
            self._redis.ping()
        except redis.RedisError as error:
            raise OSError(f"cannot reach the Redis: {error}") from None

    def claim(self, key: str, writer: str) -> dict[str, bytes] | None:
        def claim(pipe) -> dict[str, bytes] | None:
            leased, parts = pipe.exists(_lease(key)), _parts(pipe.hgetall(_name(key)))
            pipe.multi()
            if leased:
                return None
            pipe.set(_lease(key), writer, px=LEASE_MS)
            pipe.hset(_name(key), WRITER, writer)
            pipe.expire(_name(key), KEPT_S)
            return parts

        return self._run(claim, key)

    def held(self, keys: Iterable[str]) -> dict[str, float]:
        keys = list(keys)
        left = self._at_once(lambda pipe: [pipe.pttl(_lease(key)) for key in keys])
        return {key: ms / 1e3 for key, ms in zip(keys, left) if isinstance(ms, int) and ms > 0}

    def renew(self, leases: Mapping[str, str]) -> set[str]:
        def renew(pipe) -> None:
            for key, writer in leases.items():
                pipe.eval(RENEW, 2, _name(key), _lease(key), writer, LEASE_MS, KEPT_S)

        return {key for key, mine in zip(leases, self._at_once(renew)) if mine == 0}

    def read(self, key: str) -> dict[str, bytes]:
        return _parts(self._ask(lambda: self._redis.hgetall(_name(key))))

    def names(self, key: str) -> set[str]:
        return set(_parts(dict.fromkeys(self._ask(lambda: self._redis.hkeys(_name(key))), b"")))

    def set_aside(self, key: str) -> None:
        if self._ask(lambda: self._redis.exists(_name(key))):
            self._ask(lambda: self._redis.rename(_name(key), _name(f"aside {key}")))

    def save(self, key: str, writer: str, parts: dict[str, bytes], gone: Iterable[str] = ()) -> bool:
        def save(pipe) -> bool:
            owner = pipe.hget(_name(key), WRITER)
            pipe.multi()
            if owner is not None and owner != writer.encode():
                return False
            if gone := [f"part:{name}" for name in gone_names]:
                pipe.hdel(_name(key), *gone)
            fields: dict[str | bytes, str | bytes] = {f"part:{name}": data for name, data in parts.items()}
            pipe.hset(_name(key), mapping={WRITER: writer, **fields})
            pipe.expire(_name(key), KEPT_S)
            return True

        gone_names = list(gone)
        saved = self._run(save, key)
        self._unseen += sum(map(len, parts.values()))
        much = self._unseen * LOOKED_AT_EVERY > self._most_bytes
        if much or self._clock() - self._looked_at >= LOOKED_AT_AFTER_S:
            self._make_room(key)
        return saved

    def release(self, key: str, writer: str) -> None:
        self._at_once(lambda pipe: pipe.eval(RELEASE, 2, _name(key), _lease(key), writer))

    def close(self) -> None:
        self._redis.close()

    def _make_room(self, key: str) -> None:
        """Remove the oldest of the other sessions until those that are left are not too large."""
        self._unseen, self._looked_at = 0, self._clock()
        found = self._ask(lambda: list(self._redis.scan_iter(_name("*"), 1_000)))
        names = [name for name in found if not name.endswith(LEASE)]
        with self._redis.pipeline(transaction=False) as pipe:
            for name in names:
                pipe.ttl(name)
                pipe.memory_usage(name)
            answers = iter(self._ask(pipe.execute))
        sized = sorted((left, size or 0, name) for name, left, size in zip(names, answers, answers))
        too_many = sum(size for _, size, _ in sized) - self._most_bytes
        oldest = []
        for _, size, name in sized:
            if too_many > 0 and name != _name(key).encode():
                oldest.append(name)
                too_many -= size
        if oldest:
            self._ask(lambda: self._redis.delete(*oldest))

    def _run(self, change: Callable[[Any], Any], key: str) -> Any:
        """Read and change as one: tried again if somebody else came between."""
        return self._ask(lambda: self._redis.transaction(change, _name(key), _lease(key), value_from_callable=True))

    def _at_once(self, put: Callable[[Any], Any]) -> list:
        """What the commands answer that `put` puts into a pipeline, one way there and back; a fault in place of what
        one was refused, which keeps no other from being carried out."""
        with self._redis.pipeline(transaction=False) as pipe:
            put(pipe)
            return self._ask(lambda: pipe.execute(raise_on_error=False))

    @staticmethod
    def _ask(question: Callable[[], Any]) -> Any:
        """Raises OSError; ValueError for a key that holds something else than a session."""
        try:
            return question()
        except redis.ResponseError as error:
            if str(error).startswith("WRONGTYPE"):
                raise ValueError("another kind of record stands in its place") from None
            raise OSError(f"the Redis refused: {error}") from None
        except redis.RedisError as error:
            raise OSError(f"the Redis did not answer: {error}") from None


def _parts(fields: dict[bytes, bytes]) -> dict[str, bytes]:
    """Raises ValueError for names that nobody has given."""
    return {name.decode().removeprefix("part:"): data for name, data in fields.items() if name != WRITER}


def _name(key: str) -> str:
    return f"viewimit:{key}"


def _lease(key: str) -> str:
    return _name(key) + LEASE.decode()

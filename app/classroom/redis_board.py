"""The board in a Redis, which several servers share and which tells them when the orders have changed."""

import contextlib
import threading
from collections.abc import Callable, Mapping
from typing import Any

try:
    import redis
except ImportError:
    raise ValueError("a Redis needs the package redis: pip install 'viewimit[redis]'") from None

from .board import GONE_S, KEPT_S, MOST_REPLIES, Posted

TIMEOUT_S = 1.5
LISTEN_S = 1.0  # between two looks whether it is still to listen
KEPT_MS = 1000 * KEPT_S
# KEYS: the class; ARGV: number, data, the channel, ms that it is kept. A script is carried out as one
ORDER = """
local number = tonumber(redis.call('HGET', KEYS[1], 'number') or '0')
if number ~= tonumber(ARGV[1]) then return 0 end
local time = redis.call('TIME')
redis.call('HSET', KEYS[1], 'number', number + 1, 'data', ARGV[2], 'seen', time[1] .. '.' .. time[2])
redis.call('PEXPIRE', KEYS[1], ARGV[4])
redis.call('PUBLISH', ARGV[3], number + 1)
return 1
"""
LIVE = """
if (redis.call('HGET', KEYS[1], 'number') or '0') ~= ARGV[1] then return 0 end
local time = redis.call('TIME')
redis.call('HSET', KEYS[1], 'seen', time[1] .. '.' .. time[2])
redis.call('PEXPIRE', KEYS[1], ARGV[2])
return 1
"""


class RedisBoard:
    """See Board. name: of the class."""

    look_every = 1.0  # in case that what the Redis tells gets lost

    def __init__(self, url: str, name: str, timeout_s: float = TIMEOUT_S):
        try:
            opened = redis.Redis.from_url(url, socket_timeout=timeout_s, socket_connect_timeout=timeout_s)
            opened.ping()
        except redis.RedisError as error:
            raise OSError(f"cannot reach the Redis: {error}") from None
        self._redis: Any = opened  # whose types know nothing of answers as bytes
        self._name = f"viewimit-class:{name}"
        self._closed = threading.Event()

    def orders(self) -> Posted:
        with self._asking(), self._redis.pipeline(transaction=True) as pipe:
            pipe.hmget(self._name, "number", "data", "seen")
            pipe.time()
            (number, data, seen), (seconds, microseconds) = pipe.execute()
        if number is None:
            return Posted(0, b"", 0.0)
        age = seconds + microseconds * 1e-6 - _seconds(seen)
        return Posted(int(number), data or b"", max(age, 0.0))

    def order(self, number: int, data: bytes) -> bool:
        return self._run(ORDER, self._name, number, data, self._channel, KEPT_MS) == 1

    def live(self, number: int) -> None:
        self._run(LIVE, self._name, number, KEPT_MS)

    def publish(self, process: str, data: bytes | None) -> None:
        key = self._key("process", process)
        with self._asking(), self._redis.pipeline(transaction=False) as pipe:
            if data is not None:
                pipe.sadd(self._processes, process)
                pipe.set(key, data, px=round(1e3 * GONE_S))
            else:
                pipe.pexpire(key, round(1e3 * GONE_S))
            pipe.expire(self._processes, KEPT_S)
            pipe.execute()

    def leave(self, process: str) -> None:
        with self._asking():
            self._redis.delete(self._key("process", process))
            self._redis.srem(self._processes, process)

    def rosters(self) -> list[bytes]:
        with self._asking():
            processes = [one.decode() for one in self._redis.smembers(self._processes)]
            found = self._redis.mget([self._key("process", one) for one in processes]) if processes else []
            gone = [one for one, data in zip(processes, found) if data is None]
            if gone:
                self._redis.srem(self._processes, *gone)
        return [data for data in found if data is not None]

    def reply(self, call: str, replies: Mapping[str, bytes]) -> None:
        key = self._key("replies", call)
        with self._asking():
            kept = {one.decode() for one in self._redis.hkeys(key)}
            taken: dict[str | bytes, Any] = {}
            for student, data in replies.items():
                if student in kept or len(kept) + len(taken) < MOST_REPLIES:
                    taken[student] = data
            if taken:
                self._redis.hset(key, mapping=taken)
                self._redis.expire(key, KEPT_S)

    def replies(self, call: str) -> dict[str, bytes]:
        with self._asking():
            return {student.decode(): data for student, data in self._redis.hgetall(self._key("replies", call)).items()}

    def watch(self, changed: Callable[[], None]) -> None:
        threading.Thread(target=self._listen, args=(changed,), name="viewimit-class-orders", daemon=True).start()

    def close(self) -> None:
        self._closed.set()
        self._redis.close()

    def _listen(self, changed: Callable[[], None]) -> None:
        """Whatever becomes of the connection; the looks at the orders go on without it."""
        while not self._closed.is_set():
            with contextlib.suppress(redis.RedisError, OSError, ValueError), self._redis.pubsub() as heard:
                heard.subscribe(self._channel)
                while not self._closed.is_set():
                    if heard.get_message(ignore_subscribe_messages=True, timeout=LISTEN_S):
                        changed()
            self._closed.wait(LISTEN_S)

    @property
    def _channel(self) -> str:
        return f"{self._name}:orders"

    @property
    def _processes(self) -> str:
        return f"{self._name}:processes"

    def _key(self, kind: str, name: str) -> str:
        return f"{self._name}:{kind}:{name}"

    def _run(self, script: str, key: str, *arguments: Any) -> Any:
        with self._asking():
            return self._redis.eval(script, 1, key, *arguments)

    @contextlib.contextmanager
    def _asking(self):
        """Raises OSError."""
        try:
            yield
        except redis.RedisError as error:
            raise OSError(f"the Redis did not answer: {error}") from None
        except (UnicodeDecodeError, TypeError, ValueError) as error:
            raise OSError(f"the store of the class holds something else: {error}") from None


def _seconds(seen: bytes | None) -> float:
    """Of Redis's own clock, seconds.microseconds."""
    seconds, _, microseconds = (seen or b"0.0").partition(b".")
    return int(seconds) + 1e-6 * int(microseconds)

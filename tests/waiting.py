"""Waiting for what a test means, never for so many seconds."""

import inspect
import time
from collections.abc import Callable

PERIOD_S = 0.01


def wait_until(condition: Callable[[], object], seconds: float = 20.0, sleep: Callable[[float], None] = time.sleep):
    """condition's first true value. Fails after this many seconds, and says what it waited for.

    sleep: what passes the time between two looks, s → None; in a browser its own, so that its events are heard.
    """
    until = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < until, f"not within {seconds:g} s: {said_by(condition)}"
        sleep(PERIOD_S)
    return found


def stays(condition: Callable[[], object], seconds: float) -> None:
    """Fails as soon as condition() is false within this time: that nothing happens, only time can show."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        assert condition(), f"no longer so: {said_by(condition)}"
        time.sleep(PERIOD_S)
    assert condition(), f"no longer so: {said_by(condition)}"


def said_by(condition: Callable) -> str:
    """The lines that state a condition, or its name."""
    try:
        return inspect.getsource(condition).strip()
    except (OSError, TypeError):
        return getattr(condition, "__name__", repr(condition))

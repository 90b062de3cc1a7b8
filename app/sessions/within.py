"""An answer that is waited for only so long."""

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYet
from typing import TypeVar

__all__ = ["NotYet", "answer_until"]
T = TypeVar("T")


def answer_until(ask: Callable[[], T], until: float) -> T:
    """What it returns or raises, or NotYet if that takes until then; it is not waited for any more, even at the end."""
    answer: Future[T] = Future()

    def run() -> None:
        try:
            answer.set_result(ask())
        except BaseException as error:
            answer.set_exception(error)

    threading.Thread(target=run, name="viewimit-store", daemon=True).start()
    return answer.result(max(until - time.monotonic(), 0.0))

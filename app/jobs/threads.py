"""What takes a moment is made beside the pages, in one thread for all of them."""

import threading
import traceback
from collections.abc import Callable
from typing import Any


class Worker:
    """`ask` returns at once; `done(result or exception)` is called from the worker's thread.

    Of a kind a page's newest request counts, and pages take turns.
    """

    def __init__(self):
        self._requests: dict[tuple[int, str], tuple] = {}
        self._changed = threading.Condition()
        threading.Thread(target=self._run, name="viewimit-worker", daemon=True).start()

    def ask(self, page_id: int, make: Callable[[], Any], done: Callable[[Any], None], kind: str = "landscape") -> None:
        with self._changed:
            self._requests[page_id, kind] = make, done
            self._changed.notify()

    def forget(self, page_id: int) -> None:
        with self._changed:
            for key in [key for key in self._requests if key[0] == page_id]:
                del self._requests[key]

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._requests:
                    self._changed.wait()
                make, done = self._requests.pop(next(iter(self._requests)))
            try:
                made = make()
            except Exception as error:  # one page's fault must not end the others' work; its page says so
                if not isinstance(error, ValueError):  # which is an answer
                    traceback.print_exc()
                made = error
            done(made)

"""What runs in each of several processes that share the visitors of one server."""

import logging
import signal
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from ..jobs.child import stand_back
from .options import ServerOptions
from .seat_counts import SeatCounts, WorkerCounts
from .termination import Termination

LOG_FORMAT = "%(asctime)s %(message)s"
SIGN_EVERY = 1.0  # s, while it begins


def work(handed: socket.socket, port: int, counts: SeatCounts, worker: int, options: ServerOptions) -> None:
    """Serve the connections that are handed over until SIGTERM, or until the process that hands them over is gone."""
    stand_back(0)
    stopped = Termination()
    signal.signal(signal.SIGTERM, lambda *_: stopped.set())
    logging.basicConfig(format=LOG_FORMAT)

    with ExitStack() as stack:
        with _beginning(counts.rows[worker]):
            from .handed_sockets import HandedConnections
            from .pages import serving  # numpy is loaded here

            handed_connections = HandedConnections(handed, port, counts.rows[worker], stopped.set)
            stack.enter_context(serving(options, counts, worker, handed_connections))
        while not stopped.wait(0.5):  # a signal that the system hands to another thread is seen at the next turn
            pass


@contextmanager
def _beginning(row: WorkerCounts) -> Iterator[None]:
    """Give signs of life inside, where no scheduler does yet."""
    ended = threading.Event()

    def give_signs() -> None:
        while not ended.is_set():
            row.begins = time.monotonic()
            ended.wait(SIGN_EVERY)

    threading.Thread(target=give_signs, name="viewimit-beginning", daemon=True).start()
    try:
        yield
    finally:
        ended.set()

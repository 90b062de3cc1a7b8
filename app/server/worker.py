"""What runs in each of several processes that share the visitors of one server."""

import logging
import signal
import socket

from ..jobs.child import stand_back
from .options import ServerOptions
from .seat_counts import SeatCounts
from .termination import Termination

LOG_FORMAT = "%(asctime)s %(message)s"


def work(handed: socket.socket, port: int, counts: SeatCounts, worker: int, options: ServerOptions) -> None:
    """Serve the connections that are handed over until SIGTERM, or until the process that hands them over is gone."""
    stand_back(0)
    stopped = Termination()
    signal.signal(signal.SIGTERM, lambda *_: stopped.set())
    logging.basicConfig(format=LOG_FORMAT)

    from .handed_sockets import HandedConnections
    from .pages import serving  # numpy is loaded here

    with serving(options, counts, worker, HandedConnections(handed, port, counts.rows[worker], stopped.set)):
        while not stopped.wait(0.5):  # a signal that the system hands to another thread is seen at the next turn
            pass

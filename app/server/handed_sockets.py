"""Connections that another process has accepted, for a server that would accept them itself."""

import asyncio
import socket
from collections.abc import Callable

from .seat_counts import WorkerCounts


class HandedConnections(socket.socket):
    """Takes the place of a listening socket in asyncio: what it accepts comes through a Unix socket.

    handed: where sockets come from, one with each byte; port: on which they were accepted; row: counts those that
    were gone already; left(): the other process has ended.
    """

    def __init__(self, handed: socket.socket, port: int, row: WorkerCounts, left: Callable[[], None]):
        super().__init__(fileno=handed.detach())
        self._port, self._row, self._left = port, row, left

    def listen(self, *_) -> None:
        """The other process does."""

    def getsockname(self) -> tuple[str, int]:
        return "", self._port

    def accept(self) -> tuple[socket.socket, tuple]:
        """In the loop's thread. Raises BlockingIOError when there is none, ConnectionAbortedError for one that is
        gone."""
        told, sockets, _, _ = socket.recv_fds(self, 1, 1)
        if not told:  # it would be readable for ever
            asyncio.get_running_loop().remove_reader(self)
            self._left()
            raise BlockingIOError
        try:
            connection = socket.socket(fileno=sockets[0])
        except IndexError:  # too many files are open here
            self._row.ended += 1
            raise ConnectionAbortedError from None
        try:
            return connection, connection.getpeername()
        except OSError:
            connection.close()
            self._row.ended += 1
            raise ConnectionAbortedError from None

"""Which kept session a new connection goes on with: the first of its browser's that no other tab has open, be that here
or at another process."""

import asyncio
import contextlib
import logging
import threading
import time
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from viser import ClientHandle, ViserServer
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from viewimit.loop.settings import Settings

from .. import viser_private
from .autosave import Autosave, SavedSession
from .stored import Held

MOST_TABS = 8  # of a browser that are kept
ANSWERS_WITHIN = 2.0  # s: an open tab answers a ping sooner
SILENT_FOR = 4.0  # s without an answer, after which a tab's lease is renewed no more until there is one
LOOK_AGAIN = 0.1  # s
log = logging.getLogger(__name__)


@runtime_checkable
class TokenConnection(Protocol):
    """A connection that knows its browser. token: None without one."""

    token: str | None


@dataclass(frozen=True)
class Place:
    """Where what a client does is kept. key: None if it is not, and `problem` why, as a page says it; memory: what its
    browser left there."""

    key: str | None = None
    memory: SavedSession | None = None
    problem: str | None = None


class SessionKeys:
    """Keys of sessions, each held by at most one client. retire(client_id): take the page of a client that is gone."""

    def __init__(self, server: ViserServer, autosave: Autosave, begun: Settings, retire):
        self._server, self._autosave, self._begun, self._retire = server, autosave, begun, retire
        self._lock = threading.Lock()
        self._held: dict[str, int] = {}

    def take(self, client: ClientHandle) -> Place:
        """A place for what this client does; none, and no problem, for a client without a token."""
        token = token_of_client(self._server, client.client_id)
        if token is None:
            return Place()
        keys = [f"{token}.{tab}" for tab in range(MOST_TABS)]
        for key in keys:
            self._free_if_silent(key)
        try:
            return self._first_free(keys, client.client_id)
        except OSError as error:
            log.warning("a session is not kept: %s", error)
            return Place(problem=str(error))

    def leave(self, key: str) -> None:
        """The client is gone, and all that is to be kept was handed over."""
        self._autosave.forget(key)
        with self._lock:
            self._held.pop(key, None)

    def _first_free(self, keys: list[str], client_id: int) -> Place:
        """Waits for a sign of life of leases before it: a process that has ended leaves some, which come free soon."""
        left, alive = self._autosave.held(keys), set()
        while True:
            for key in keys:
                if key in alive or key in self._held:
                    continue
                if key in left:
                    break
                if self._reserve(key, client_id):
                    try:
                        return Place(key, self._autosave.claim(key, self._begun, Answering(self._server, client_id)))
                    except BaseException as error:
                        self._unreserve(key)
                        if not isinstance(error, Held):
                            raise
                        alive.add(key)
            else:
                return Place(problem=f"this browser has {MOST_TABS} tabs open already")
            time.sleep(LOOK_AGAIN)
            before, left = left, self._autosave.held(keys)
            alive = {key for key, s in left.items() if key in alive or s > before.get(key, 0.0)}

    def _reserve(self, key: str, client_id: int) -> bool:
        """Whether no other client of this process has it, or claims it just now."""
        with self._lock:
            return self._held.setdefault(key, client_id) == client_id

    def _unreserve(self, key: str) -> None:
        with self._lock:
            self._held.pop(key, None)

    def _free_if_silent(self, key: str) -> None:
        """A laptop that slept, or a network that is gone, leaves connections that look open."""
        with self._lock:
            holder = self._held.get(key)
        if holder is not None and not answers(self._server, holder, ANSWERS_WITHIN):
            cut_off(self._server, holder)
            self._retire(holder)


class Answering:
    """Whether a client has answered lately, each time it is asked: a ping goes out with each question, as long as none
    is under way."""

    def __init__(self, server: ViserServer, client_id: int):
        self._server, self._client_id = server, client_id
        self._answered, self._asking = time.monotonic(), False

    def __call__(self) -> bool:
        connection = viser_private.connection_of(self._server, self._client_id)
        if connection is None:
            return False
        if not self._asking:
            self._asking = True
            asyncio.run_coroutine_threadsafe(self._ask(connection), self._server.get_event_loop())
        return time.monotonic() - self._answered < SILENT_FOR

    async def _ask(self, connection: ServerConnection) -> None:
        with contextlib.suppress(ConnectionClosed):
            await (await connection.ping())
            self._answered = time.monotonic()
        self._asking = False


def token_of_client(server: ViserServer, client_id: int) -> str | None:
    """Of its browser; None without one."""
    connection = viser_private.connection_of(server, client_id)
    return connection.token if isinstance(connection, TokenConnection) else None


def answers(server: ViserServer, client_id: int, within: float) -> bool:
    """Whether the client is still there: it answers a ping within so many seconds. Not from viser's own thread."""
    connection = viser_private.connection_of(server, client_id)
    if connection is None:
        return False

    async def ask() -> None:
        await (await connection.ping())  # whose way out may be blocked as well

    async def is_answered() -> bool:
        try:
            await asyncio.wait_for(ask(), within)
        except (asyncio.TimeoutError, ConnectionClosed):
            return False
        return True

    return asyncio.run_coroutine_threadsafe(is_answered(), server.get_event_loop()).result()


def cut_off(server: ViserServer, client_id: int) -> None:
    """Close a connection that nobody answers on."""
    connection = viser_private.connection_of(server, client_id)
    if connection is not None:
        server.get_event_loop().call_soon_threadsafe(connection.transport.abort)

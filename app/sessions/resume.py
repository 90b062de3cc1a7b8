"""Which kept session a new connection goes on with: its browser's, unless another tab of that browser has it open."""

import asyncio
import threading
from typing import Protocol, runtime_checkable

from viser import ClientHandle, ViserServer
from websockets.exceptions import ConnectionClosed

from viewimit.settings import Settings

from .. import viser_private
from .autosave import Autosave, SavedSession

MOST_TABS = 8  # of a browser that are kept
ANSWERS_WITHIN = 2.0  # s: an open tab answers a ping sooner


@runtime_checkable
class TokenConnection(Protocol):
    """A connection that knows its browser. token: None without one."""

    token: str | None


class SessionKeys:
    """Keys of sessions, each held by at most one client. retire(client_id): take the page of a client that is gone."""

    def __init__(self, server: ViserServer, autosave: Autosave, begun: Settings, retire):
        self._server, self._autosave, self._begun, self._retire = server, autosave, begun, retire
        self._lock = threading.Lock()
        self._held: dict[str, int] = {}

    def take(self, client: ClientHandle) -> tuple[str | None, SavedSession | None]:
        """A key for what this client does, and what its browser left under it; (None, None) without a token."""
        token = token_of_client(self._server, client.client_id)
        if token is None:
            return None, None
        keys = [f"{token}.{tab}" for tab in range(MOST_TABS)]
        for key in keys:
            self._free_if_silent(key)
        held = self._hold(keys, client.client_id)
        return held, None if held is None else self._autosave.claim(held, self._begun)

    def leave(self, key: str) -> None:
        with self._lock:
            self._held.pop(key, None)

    def _hold(self, keys: list[str], client_id: int) -> str | None:
        with self._lock:
            key = next((key for key in keys if key not in self._held), None)
            if key is not None:
                self._held[key] = client_id
            return key

    def _free_if_silent(self, key: str) -> None:
        """A laptop that slept, or a network that is gone, leaves connections that look open."""
        with self._lock:
            holder = self._held.get(key)
        if holder is not None and not answers(self._server, holder, ANSWERS_WITHIN):
            cut_off(self._server, holder)
            self._retire(holder)
            self.leave(key)


def token_of_client(server: ViserServer, client_id: int) -> str | None:
    """Of its browser; None without one."""
    connection = viser_private.connection_of(server, client_id)
    return connection.token if isinstance(connection, TokenConnection) else None


def answers(server: ViserServer, client_id: int, within: float) -> bool:
    """Whether the client is still there: it answers a ping within so many seconds. Not from viser's own thread."""
    connection = viser_private.connection_of(server, client_id)
    if connection is None:
        return False

    async def ask() -> bool:
        try:
            await asyncio.wait_for(await connection.ping(), within)
        except (asyncio.TimeoutError, ConnectionClosed):
            return False
        return True

    return asyncio.run_coroutine_threadsafe(ask(), server.get_event_loop()).result()


def cut_off(server: ViserServer, client_id: int) -> None:
    """Close a connection that nobody answers on."""
    connection = viser_private.connection_of(server, client_id)
    if connection is not None:
        server.get_event_loop().call_soon_threadsafe(connection.transport.abort)

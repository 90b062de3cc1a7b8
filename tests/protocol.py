"""A client that speaks viser's protocol without a browser: it takes what a page would, and sends what one likes."""

import threading
import time
from base64 import b64encode
from contextlib import suppress
from ssl import SSLContext

import msgspec
import viser
import zstandard
from drawn import label
from waiting import wait_until
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

BEGINS_WITHIN_S = 90  # a process of the server that may only just be beginning, on a busy machine
VIEW = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [-1.9, -3.8, 3.0],
    "fov": 0.63,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 720,
    "image_width": 552,
    "look_at": [0.7, -0.1, 0.6],
    "up_direction": [0.0, 0.0, 1.0],
}


class Tab:
    """What a browser's tab keeps of what it is sent."""

    def __init__(self):
        self.text, self.acted = "", 0

    def take(self, sent: str) -> None:
        if sent:
            kept = msgspec.json.decode(sent)
            self.text, self.acted = kept["text"], kept["acted"]


class Client:
    """One tab. widgets: uuid by label; values: by uuid; html: by uuid; received: (time, message type) of everything.

    tab: what a browser's tab has kept, with which it comes again; login: user:password, for a proxy.
    The handshake raises websockets.InvalidStatus.
    """

    def __init__(
        self,
        url: str,
        origin: str | None = None,
        tab: Tab | None = None,
        view: bool = True,
        login: str | None = None,
        ssl: SSLContext | None = None,
    ):
        headers = {"Authorization": f"Basic {b64encode(login.encode()).decode()}"} if login else {}
        self.tab = tab or Tab()
        self.socket = connect(
            url.replace("http", "ws", 1),
            subprotocols=[f"viser-v{viser.__version__}"],
            origin=origin,
            additional_headers=headers,
            ssl=ssl,
            compression=None,
            max_size=None,
            open_timeout=BEGINS_WITHIN_S,
            close_timeout=1,
        )
        self.widgets: dict[str, str] = {}
        self.commands: dict[str, str] = {}
        self.values: dict[str, object] = {}
        self.html: dict[str, str] = {}
        self.nodes: set[str] = set()
        self.acted = 0
        self.received: list[tuple[float, str]] = []
        self._unpacker = zstandard.ZstdDecompressor()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        if view:
            self.send(VIEW)

    def send(self, message: dict | bytes | str) -> None:
        with suppress(ConnectionClosed):  # what the server does about it is told by `closed`
            self.socket.send(message if isinstance(message, (bytes, str)) else msgspec.msgpack.encode(message))

    def put(self, label: str, value) -> None:
        """A widget's new value, as a browser sends it."""
        self.send({"type": "GuiUpdateMessage", "uuid": self.widgets[label], "updates": {"value": value}})

    def act(self, control: str, value: object = 0) -> None:
        """As the page's script sends a click in a drawing."""
        self.acted += 1
        acts = [[self.acted, control, str(value)]]
        self.put("vi-actions", msgspec.json.encode({"load": str(id(self)), "acts": acts}).decode())

    def keep(self, seconds: float = 5.0) -> Tab:
        """The tab, once it has been sent all that was done before."""
        self.act("unseen", "none")
        wait_until(lambda: self.tab.acted >= self.acted, seconds)
        return self.tab

    def press(self, command: str) -> None:
        self.send({"type": "CommandTriggerMessage", "uuid": self.commands[command]})

    def value(self, label: str):
        return self.values.get(self.widgets[label])

    @property
    def status(self) -> str:
        """The pill over the scene."""
        return next((html for html in list(self.html.values()) if 'role="status"' in html), "")

    def ready(self, seconds: float = 30.0) -> "Client":
        """Once its page is built."""
        built = {"Help", "Load"}  # of the keys and of the motions, the last that are built of each kind
        wait_until(lambda: self.status and built <= {*self.commands, *self.widgets}, seconds)
        return self

    def closed(self, seconds: float = 10.0) -> tuple[int, str] | None:
        """Code and reason with which the server has closed the connection; None if it has not."""
        self._reader.join(seconds)
        return None if self._reader.is_alive() else (self.socket.close_code, self.socket.close_reason)

    def close(self) -> None:
        self.socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _read(self) -> None:
        with suppress(ConnectionClosed):
            for frame in self.socket:
                for message in self._unpack(frame):
                    self._take(message)

    def _inner(self, frame: bytes) -> bytes:
        size, packed = (int.from_bytes(frame[at : at + 8], "little") for at in (0, 8))
        return self._unpacker.decompress(frame[16 : 16 + packed], max_output_size=size)

    def _unpack(self, frame: bytes) -> list[dict]:
        return msgspec.msgpack.decode(self._inner(frame))["messages"]

    def _take(self, message: dict) -> None:
        kind, uuid = message["type"], message.get("uuid")
        self.received.append((time.monotonic(), kind))
        props = message.get("props") or {}
        if kind == "GuiUpdateMessage":
            if "value" in message["updates"]:
                self.values[uuid] = message["updates"]["value"]
                if uuid == self.widgets.get("vi-session"):
                    self.tab.take(self.values[uuid])
            if "content" in message["updates"]:
                self.html[uuid] = message["updates"]["content"]
        elif kind == "GuiRemoveMessage":
            self.widgets = {name: other for name, other in self.widgets.items() if other != uuid}
        elif kind == "RegisterCommandMessage":
            self.commands[props["label"]] = uuid
        elif kind == "GuiHtmlMessage":
            self.html[uuid] = props["content"]
        elif kind.startswith("Gui") and "label" in props:
            self.widgets[label(props["label"])] = uuid
            self.values[uuid] = message.get("value")
            if props["label"] == "vi-actions":
                self.act("session", self.tab.text)
        elif "name" in message and message["name"].startswith("/"):
            self.nodes.add(message["name"])

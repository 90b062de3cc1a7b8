"""Hostile clients against a running server: each is refused or closed with a line in the log; nobody else notices."""

import asyncio
import contextlib
import socket
import time
import urllib.error
import urllib.request
import weakref
from concurrent.futures import ThreadPoolExecutor

import msgspec
import pytest
from browsing import PATIENCE_MS, PATIENCE_S, STATUS, sparing
from protocol import VIEW, Client
from serving import Server
from viewimit.app.server import messages
from viewimit.app.server.address import is_own_page
from viewimit.app.server.connection import FRAMES_AT_ONCE, MOST_MESSAGE
from viewimit.app.server.messages import MOST_BUT_PARTS, MOST_BYTES, PART, FileTransferPart, FileTransferStartUpload
from viewimit.app.server.page_head import page_policy
from waiting import wait_until
from websockets.exceptions import InvalidStatus

SEATS = 5


@pytest.fixture(scope="module")
def guarded():
    server = Server("--max-clients", str(SEATS), "--origin", "https://class.example.org")
    yield server
    assert server.stop() == 0


@pytest.fixture(scope="module")
def bystander(guarded):
    """A visitor in good faith, who is still served when all is over."""
    with Client(guarded.url).ready() as client:
        yield client
        client.put("θ₂", 60.0)
        before = len(client.received)
        wait_until(lambda: len(client.received) > before)
        assert "Note" not in client.status


@pytest.fixture
def client(guarded, bystander):
    with Client(guarded.url).ready() as client:
        yield client


CLICK = {
    "type": "ScenePointerMessage",
    "event_type": "click",
    "ray_origin": [-1.9, -3.8, 3.0],
    "ray_direction": [0.6, 0.8, 0.0],
    "screen_pos": [[0.5, 0.5]],
    "modifier": None,
}
OUT_OF_PLACE = [
    ("θ₂", 1e9),
    ("θ₂", float("nan")),
    ("θ₂", float("inf")),
    ("θ₂", "45"),
    ("θ₂", [45]),
    ("θ₂", None),
    ("θ₂", True),
    ("Seed", -1),
    ("Seed", 2.0**60),
    ("Transfer", "epipolar"),
    ("Transfer", 3),
    ("Preset", "Beyond"),
    ("Motion", "Explode"),
    ("Rays", "yes"),
    ("Rays", 1),
    ("Play", {"a": 1}),
    ("Download figure and data", True),  # disabled
]


@pytest.mark.parametrize("label, value", OUT_OF_PLACE)
def test_a_value_that_a_widget_cannot_have_is_dropped_and_the_widget_shown_as_it_was(guarded, client, label, value):
    uuid, before = client.widgets[label], client.value(label)
    client.values[uuid] = "what the browser shows"
    with guarded.says("refused "):
        client.put(label, value)
    wait_until(lambda: client.values[uuid] == before)
    assert client.closed(0) is None


def hostile_messages(client, bystander) -> dict[str, object]:
    def update(uuid, **fields):
        return {"type": "GuiUpdateMessage", "uuid": uuid, "updates": fields}

    slider, load = client.widgets["θ₂"], client.widgets["Load"]
    upload = {
        "type": "FileTransferStartUpload",
        "source_component_uuid": load,
        "transfer_uuid": "t",
        "filename": "a.json",
        "mime_type": "application/json",
    }
    return {
        "another client's widget": update(bystander.widgets["θ₂"], value=10.0),
        "another field": update(slider, max=1e9),
        "a field beside the value": update(slider, value=10.0, disabled=True),
        "a private field": update(slider, update_cb=[]),
        "no field": update(slider),
        "a value for an upload button": update(load, value="x"),
        "no message": b"\xc1\x00\x01",
        "an empty message": b"",
        "nested without end": b"\x91" * 100_000,
        "text": "hello",
        "a list": b"\x93\x01\x02\x03",
        "no type": {"uuid": slider},
        "a share request": {"type": "ShareUrlRequest"},
        "a share disconnect": {"type": "ShareUrlDisconnect"},
        "a form": {"type": "GuiFormDirtyMessage", "uuid": slider},
        "a held button": {"type": "GuiButtonHoldMessage", "uuid": slider, "frequency": 10.0},
        "a click at a node": {"type": "SceneNodeClickMessage", "name": "/floor", "instance_index": None},
        "a render": {"type": "GetRenderResponseMessage", "payload": b"", "render_uuid": "x"},
        "a message of servers": {"type": "RunJavascriptMessage", "source": "alert(1)"},
        "an upload to a slider": {**upload, "source_component_uuid": slider, "part_count": 1, "size_bytes": 9},
        "an upload in too many parts": {**upload, "part_count": 10**6, "size_bytes": 9},
        "a message too large": b"\x00" * (MOST_MESSAGE + 1),
        "a value of many lists": update(slider, value=[[]] * MOST_BUT_PARTS),
        "a long text": update(slider, value="a" * MOST_BUT_PARTS),
    }


HOSTILE = list(hostile_messages(*[type("", (), {"widgets": {"θ₂": "a", "Load": "b"}})] * 2))


@pytest.mark.parametrize("what", HOSTILE)
def test_what_no_browser_sends_closes_the_connection_with_one_line(guarded, client, bystander, what):
    with guarded.says("refused "):
        client.send(hostile_messages(client, bystander)[what])
        assert client.closed()[0] in (1008, 1009)


def test_a_message_before_the_first_view_closes_the_connection(guarded, bystander):
    with Client(guarded.url, view=False) as client, guarded.says("before the first view"):
        client.send({"type": "CommandTriggerMessage", "uuid": "x"})
        assert client.closed()[0] == 1008


@pytest.mark.parametrize(
    "field, value", [("fov", float("nan")), ("image_width", -1), ("position", [0, 0]), ("near", "x")]
)
def test_a_view_that_cannot_be_is_dropped(guarded, client, field, value):
    with guarded.says("refused ViewerCameraMessage"):
        client.send({**VIEW, field: value})
    assert client.closed(0) is None


@pytest.mark.parametrize(
    "field, value",
    [
        ("ray_direction", [0.0, 0.0, 0.0]),
        ("ray_direction", [3.0, 4.0, 0.0]),
        ("ray_direction", [1.0, float("nan"), 0.0]),
        ("ray_origin", [1e300, 0.0, 0.0]),
        ("ray_origin", None),
        ("screen_pos", []),
        ("screen_pos", [[0.5, 0.5], [0.6, 0.6]]),
        ("modifier", "shift"),
        ("event_type", "rect-select"),
    ],
)
def test_a_click_in_the_scene_that_cannot_be_is_dropped(guarded, client, field, value):
    with guarded.says("refused "):
        client.send({**CLICK, field: value})
    assert client.closed(0) is None


def test_values_that_make_no_sense_over_and_over_close_the_connection(guarded, client):
    for _ in range(60):
        client.put("θ₂", "x")
    assert client.closed()[0] == 1008


def test_a_flood_closes_the_connection_and_the_log_stays_short(guarded, client):
    lines, port = len(guarded.lines), client.socket.local_address[1]
    for _ in range(20):
        for _ in range(FRAMES_AT_ONCE):
            client.send(VIEW)
    assert client.closed()[0] == 1008
    assert len(guarded.lines_about({port}, lines)) <= 2


def test_pings_count_as_a_flood_too(client):
    with contextlib.suppress(Exception):
        for _ in range(20 * FRAMES_AT_ONCE):
            client.socket.ping()
    assert client.closed() is not None


def begun(transfer: str, size: int, widget: str = "a") -> FileTransferStartUpload:
    parts = -(-size // PART)
    return FileTransferStartUpload("FileTransferStartUpload", widget, transfer, "motion.json", "", parts, size)


def part_of(transfer: str, index: int, size: int = PART) -> FileTransferPart:
    return FileTransferPart("FileTransferPart", "a", transfer, index, bytes(size))


def begin_upload(client, transfer: str, size: int) -> None:
    client.send(msgspec.structs.asdict(begun(transfer, size, client.widgets["Load"])))


def send_part(client, transfer: str, index: int, content: bytes) -> None:
    part = FileTransferPart("FileTransferPart", client.widgets["Load"], transfer, index, content)
    client.send(msgspec.structs.asdict(part))


def in_a_loop(coroutine):
    with ThreadPoolExecutor(1) as aside:  # a browser's tests leave a loop that runs in this thread
        return aside.submit(asyncio.run, coroutine).result()


def test_unfinished_uploads_stay_within_their_bound():
    """Of eight that nobody finishes viser gets the parts of one, and forgets them after a minute."""

    async def taken():
        dropped: list[str] = []
        uploads, admitted = messages.Uploads(dropped.append), 0
        for k in range(8):
            parts = [(uploads.add, part_of(f"t{k}", i), PART) for i in range(MOST_BYTES // PART - 1)]
            for admit, message, size in [(uploads.begin, begun(f"t{k}", MOST_BYTES), 0), *parts]:
                with contextlib.suppress(messages.Refused):
                    admit(message)
                    admitted += size
        uploads.end("t0")
        return admitted, dropped

    assert in_a_loop(taken()) == (MOST_BYTES - PART, ["t0"])


def test_an_upload_keeps_nothing_of_a_client_that_has_gone():
    """Whether it was whole or not: the clock that would end it waits for a minute."""

    async def gone():
        uploads = messages.Uploads(lambda transfer: None)
        for name, size in (("whole", 9), ("half", PART + 1)):
            uploads.begin(begun(name, size))
            uploads.add(part_of(name, 0, min(size, PART)))
        there = weakref.ref(uploads)
        del uploads
        return there() is None

    assert in_a_loop(gone())


def test_an_upload_too_large_is_refused_and_the_page_goes_on(guarded, client):
    with guarded.says("at most"):
        begin_upload(client, "big", MOST_BYTES + 1)
    assert client.closed(0) is None


@pytest.mark.parametrize("index, size", [(2, PART), (0, 9), (1, PART)])
def test_a_part_that_was_not_announced_closes_the_connection(client, index, size):
    begin_upload(client, "t", PART + 1)
    send_part(client, "t", index, b"\x00" * size)
    assert client.closed()[0] == 1008


def test_uploads_that_are_allowed_arrive(client):
    begin_upload(client, "t", 9)
    send_part(client, "t", 0, b"no motion")
    wait_until(lambda: "Note" in client.status)  # the page read it, and says what is wrong with it


@pytest.mark.parametrize(
    "origin, host, own",
    [
        ("http://127.0.0.1:8080", "127.0.0.1:8080", True),
        ("http://localhost:8080", "localhost:8080", True),
        ("http://192.168.1.7:8080", "192.168.1.7:8080", True),
        ("http://[::1]:8080", "[::1]:8080", True),
        ("http://localhost", "localhost:80", True),
        ("https://class.example.org", "anything", True),
        ("http://127.0.0.1:8081", "127.0.0.1:8080", False),
        ("http://evil.example", "127.0.0.1:8080", False),
        ("http://evil.example:8080", "evil.example:8080", False),  # its name made to point here
        ("http://class.example.org", "class.example.org:8080", False),
        ("null", "127.0.0.1:8080", False),
        ("", "", False),
        ("http://[::", "[::", False),
    ],
)
def test_only_pages_of_this_server_may_connect(origin, host, own):
    assert is_own_page(origin, host, ["https://class.example.org"]) is own


def test_a_page_of_another_site_is_refused_at_the_handshake(guarded, bystander):
    wait_until(lambda: '"clients": 1}' in fetch(guarded.url + "/health")[1])  # others may still be leaving
    with guarded.says("refused a page of http://evil.example"), pytest.raises(InvalidStatus) as refused:
        Client(guarded.url, origin="http://evil.example")
    assert refused.value.response.status_code == 403
    for origin in (guarded.url, "https://class.example.org"):
        Client(guarded.url, origin=origin).close()


def test_more_clients_than_seats_are_refused_and_told_why(guarded, bystander):
    with contextlib.ExitStack() as stack:
        wait_until(lambda: '"clients": 1}' in fetch(guarded.url + "/health")[1])
        for _ in range(SEATS - 1):
            stack.enter_context(Client(guarded.url))
        with guarded.says("a seat"), pytest.raises(InvalidStatus) as refused:
            Client(guarded.url)
        assert refused.value.response.status_code == 503
        status, text, _ = fetch(guarded.url)
        assert status == 503 and "All seats are taken" in text
    wait_until(lambda: fetch(guarded.url)[0] == 200)
    Client(guarded.url).close()


def fetch(url: str, **headers) -> tuple[int, str, dict]:
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=10) as answer:
            return answer.status, answer.read().decode(), dict(answer.headers)
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode(), dict(error.headers)


def test_the_page_says_where_it_may_connect_to(guarded):
    _, _, headers = fetch(guarded.url)
    policy = headers["Content-Security-Policy"]
    host = guarded.url.removeprefix("http://")
    assert f"connect-src 'self' data: blob: ws://{host} wss://{host};" in policy
    assert "default-src 'none'" in policy and "script-src 'sha256-" in policy
    assert headers["X-Content-Type-Options"] == "nosniff" and "Set-Cookie" not in headers


def test_a_host_cannot_write_into_the_policy():
    assert "evil" not in page_policy("a; script-src evil")


def is_heard(browser, url: str, parameter: str, bypass_csp: bool) -> bool:
    """Whether a page opened with this parameter, {} in it being an address elsewhere, turns to there."""
    with socket.socket() as elsewhere:
        elsewhere.bind(("127.0.0.1", 0))
        elsewhere.listen()
        elsewhere.settimeout(0.05)
        context = sparing(browser.new_context(bypass_csp=bypass_csp))
        page, tried = context.new_page(), []
        address = f"127.0.0.1:{elsewhere.getsockname()[1]}"
        page.on("console", lambda message: tried.append(message.text) if address in message.text else None)
        page.goto(f"{url}/?{parameter.format(address)}")
        until, heard = time.monotonic() + PATIENCE_S, False
        while not heard and time.monotonic() < until:
            page.wait_for_timeout(100)
            if tried:
                until = min(until, time.monotonic() + 2)
            with contextlib.suppress(TimeoutError):
                elsewhere.accept()[0].close()
                heard = True
        context.close()
        assert heard or tried
        return heard


@pytest.mark.browser
def test_a_link_cannot_make_the_page_load_from_elsewhere(browser, guarded):
    parameter = "playbackPath=http://{}/a.viser"
    assert is_heard(browser, guarded.url, parameter, bypass_csp=True)  # as it would without the policy
    assert not is_heard(browser, guarded.url, parameter, bypass_csp=False)


@pytest.mark.browser
def test_a_link_cannot_make_the_page_connect_to_another_server(browser, guarded):
    """Even without the policy: the page's script has it connect to where it came from, and cleans the address."""
    context = sparing(browser.new_context(bypass_csp=True))
    page, asked = context.new_page(), []
    page.on("websocket", lambda opened: asked.append(opened.url))
    page.goto(f"{guarded.url}/?websocket=ws://127.0.0.1:9")
    page.wait_for_selector(STATUS, timeout=PATIENCE_MS)
    assert asked and set(asked) == {f"ws://{guarded.url.removeprefix('http://')}/"}
    assert "websocket" not in page.url
    context.close()


@pytest.mark.browser
def test_no_request_leaves_the_machine(browser, guarded, bystander):
    page = sparing(browser.new_page())
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda opened: asked.append(opened.url))
    page.goto(guarded.url)
    page.wait_for_selector(STATUS, timeout=PATIENCE_MS)
    page.close()
    itself = guarded.url.removeprefix("http://")
    assert f"ws://{itself}/" in asked
    assert all(url.startswith((f"http://{itself}/", f"ws://{itself}/", "data:", "blob:")) for url in asked), asked

"""The dearest texts that a tab may send, and the CPU time that reading each takes: `python tests/dearest_texts.py`.

Each is as long as a link may be, and made of what costs most: restarts, changes, postures, scenes, packed actions.
"""

import base64
import json
import time
import zlib
from collections.abc import Callable
from contextlib import suppress
from urllib.parse import quote

from viewimit.app.model.link import read_link

from viewimit.loop.link import MAX_LINK, MAX_UNPACKED
from viewimit.loop.settings import Settings

MOST_S = 0.05  # CPU of one text
SCENE = 'title = "x"\nextends = "panda"\n[head]\nbaseline = 0.'


def packed(script: dict) -> str:
    content = json.dumps({"script": script}, separators=(",", ":")).encode()
    return "x=" + base64.urlsafe_b64encode(zlib.compress(content, 9)).decode().rstrip("=")


def repeated(action: list, count: int, **settings) -> str:
    room = MAX_UNPACKED // (len(json.dumps(action)) + 1)
    return packed({"settings": settings, "deeds": [action] * min(count, room)})


def mixed(postures: int, changes: int) -> str:
    """Postures, and changes to as many points as there may be."""
    points = ["c", {"body_points": [[7, 0, 0, 0]] * 64}]
    return packed({"settings": {}, "deeds": [["p", [0.1, 0.2]]] * postures + [points] * changes})


TEXTS: dict[str, Callable[[], str]] = {
    "restarts": lambda: "begin=&" * 100,
    "changes": lambda: "steps=1&" + "noise=1&" * 99,
    "restarts with a setting": lambda: "begin=&noise=1&" * 50,
    "steps": lambda: "steps=1&" * (MAX_LINK // 8),
    "moves": lambda: "steps=1&" + "demo=1,1&" * 1500,
    "a long posture": lambda: "steps=1&demo=" + "1," * (MAX_LINK // 2 - 20) + "1",
    "a long rehearsal": lambda: "rehearse=" + "1,1;" * (MAX_LINK // 4 - 20) + "1,1",
    "scenes described": lambda: "&begin=".join(f"scene={SCENE}{k}".replace("\n", "%0A") for k in range(1, 17)),
    "packed restarts": lambda: repeated(["b", {}], 200),
    "packed restarts, too many": lambda: repeated(["b", {}], 30_000),
    "packed changes": lambda: repeated(["c", {"noise_px": 1.0}], 200),
    "packed empty changes": lambda: repeated(["c", {}], 30_000),
    "packed steps": lambda: repeated(["s", 1], 10_000),
    "packed postures": lambda: repeated(["p", [0.1, 0.2]], 10_000),
    "packed points": lambda: repeated(["b", {"body_points": [[7, 0, 0, 0]] * 64}], 100),
    "packed postures and points": lambda: mixed(9900, 99),
    "two packed scripts": lambda: f"{mixed(4950, 49)}&versus={quote(mixed(4950, 49))}",
    "packed rehearsals": lambda: repeated(["r", [[0.1, 0.2]] * 50], 100),
    "a bomb": lambda: "x=" + base64.urlsafe_b64encode(zlib.compress(b" " * 10**7, 9)).decode().rstrip("="),
    "deep": lambda: "x=" + base64.urlsafe_b64encode(zlib.compress(b"[" * 200_000, 9)).decode().rstrip("="),
    "unknown words": lambda: "a=1&" * (MAX_LINK // 4),
    "escapes": lambda: "%41" * (MAX_LINK // 3),
}


def cpu_of(text: str) -> float:
    """Return the s of CPU that reading a text takes, at best of three."""
    best = float("inf")
    for _ in range(3):
        began = time.thread_time()
        with suppress(ValueError):
            read_link(text, Settings.paper())
        best = min(best, time.thread_time() - began)
    return best


def main() -> None:
    read_link("preset=paper", Settings.paper())  # what is computed once
    found = {name: (1e3 * cpu_of(text()), len(text())) for name, text in TEXTS.items()}
    for name, (ms, length) in sorted(found.items(), key=lambda one: -one[1][0]):
        print(f"{name:28}{length:7} characters{ms:9.1f} ms")
    print(f"largest: {max(ms for ms, _ in found.values()):.1f} ms of {1e3 * MOST_S:.0f}")


if __name__ == "__main__":
    main()

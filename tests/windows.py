"""Windows of an installed Firefox, and of Chromium by the same methods.

Playwright brings a Firefox of its own. People have the installed one, which is driven here by WebDriver BiDi. Without a
display it runs under Xvfb, because Firefox without a screen has no WebGL on Linux.
"""

import base64
import itertools
import json
import os
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

from browsing import sparing
from websockets.sync.client import connect

PATIENCE_S = 90.0
LOOKS = 4  # in a row that find an element in one place, before it is clicked
LISTENS = re.compile(r"WebDriver BiDi listening on (ws://\S+)")
PREFERENCES = {
    "app.normandy.enabled": False,
    "browser.shell.checkDefaultBrowser": False,
    "datareporting.policy.dataSubmissionEnabled": False,
    "webgl.force-enabled": True,
}


def find_firefox() -> str | None:
    """Path of an installed Firefox that can be driven here; None without one, or without a screen or Xvfb."""
    found = shutil.which("firefox-esr") or shutil.which("firefox")
    return found if os.environ.get("DISPLAY") or shutil.which("Xvfb") else None


class Firefox:
    """One window of a Firefox with a profile of its own. `problems`: uncaught errors and console errors."""

    def __init__(self, width: int = 1440, height: int = 900, preferences: dict[str, Any] | None = None):
        self.problems: list[str] = []
        self._numbers = itertools.count(1)
        self._folder = tempfile.TemporaryDirectory(prefix="viewimit-firefox-", ignore_cleanup_errors=True)
        lines = (
            f"user_pref({json.dumps(k)}, {json.dumps(v)});" for k, v in (PREFERENCES | (preferences or {})).items()
        )
        (Path(self._folder.name) / "user.js").write_text("\n".join(lines))
        screen, self._screen = dict(os.environ, MOZ_ENABLE_WAYLAND="0"), None
        if "DISPLAY" not in screen:
            self._screen, screen["DISPLAY"] = _virtual_screen(width, height + 200)
        command = [
            find_firefox(),
            "--remote-debugging-port=0",
            "--profile",
            self._folder.name,
            "--no-remote",
            "about:blank",
        ]
        self._process = subprocess.Popen(
            command, env=screen, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
        )
        address = next((found[1] for line in self._process.stderr if (found := LISTENS.search(line))), None)
        if address is None:
            raise RuntimeError(f"Firefox ended with status {self._process.wait()} before it listened")
        self._socket = connect(f"{address}/session", max_size=None)
        self._ask("session.new", capabilities={})
        self._ask("session.subscribe", events=["log.entryAdded"])
        self._context = self._ask("browsingContext.getTree")["contexts"][0]["context"]
        self._ask("browsingContext.setViewport", context=self._context, viewport={"width": width, "height": height})

    def _ask(self, method: str, **params: Any) -> dict[str, Any]:
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            answer = json.loads(self._socket.recv(2 * PATIENCE_S))
            if answer.get("id") == number:
                if answer["type"] == "error":
                    raise RuntimeError(f"{method}: {answer['message']}")
                return answer["result"]
            entry = answer.get("params", {})
            if answer.get("method") == "log.entryAdded" and entry["level"] == "error":
                self.problems.append(entry["text"])

    def goto(self, url: str) -> None:
        """Open an address, until its document is loaded."""
        self._ask("browsingContext.navigate", context=self._context, url=url, wait="complete")

    def evaluate(self, expression: str) -> Any:
        """Evaluate JavaScript → its value by way of JSON. Raises RuntimeError with the script's error."""
        wrapped = f"(async () => JSON.stringify(await ({expression})) ?? null)()"
        target = {"context": self._context}
        found = self._ask("script.evaluate", expression=wrapped, target=target, awaitPromise=True)
        if found["type"] == "exception":
            raise RuntimeError(found["exceptionDetails"]["text"])
        return json.loads(found["result"]["value"]) if found["result"]["type"] == "string" else None

    def wait_for(self, condition: str, seconds: float = PATIENCE_S) -> Any:
        """Wait until an expression is true → its value. Raises RuntimeError after the time."""
        look = f"(() => {{ try {{ return {condition}; }} catch {{}} }})()"
        end = time.monotonic() + seconds
        while not (found := self.evaluate(look)):  # from here, as a page that is loaded again ends its own waiting
            if time.monotonic() > end:
                raise RuntimeError(f"{condition}\n{self.problems}\n{self.evaluate('document.body.innerText')[:2000]}")
            time.sleep(0.1)
        return found

    def click(self, selector: str, text: str = "") -> None:
        """Click with the mouse on the first element of a selector that contains a text, once it stands still."""
        look = f"""(() => {{
          const found = [...document.querySelectorAll({json.dumps(selector)})].find(
            one => one.textContent.includes({json.dumps(text)}) && one.getClientRects().length);
          found?.scrollIntoView({{block: "center"}});
          const box = found?.getBoundingClientRect();
          return box && [Math.round(box.x + box.width / 2), Math.round(box.y + box.height / 2)];
        }})()"""
        places = []
        while len(places) < LOOKS or places[-LOOKS:] != LOOKS * places[-1:]:
            places.append(self.wait_for(look))
            time.sleep(0.1)
        place = places[-1]
        move = {"type": "pointerMove", "x": place[0], "y": place[1]}
        steps = [move, {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}]
        mouse = {"type": "pointer", "id": "mouse", "actions": steps}
        self._ask("input.performActions", context=self._context, actions=[mouse])

    def press(self, key: str) -> None:
        """Press a key, given as a character."""
        keys = [{"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]
        self._ask(
            "input.performActions", context=self._context, actions=[{"type": "key", "id": "keys", "actions": keys}]
        )

    def screenshot(self, path: str | Path) -> None:
        data = self._ask("browsingContext.captureScreenshot", context=self._context)["data"]
        Path(path).write_bytes(base64.b64decode(data))

    def close(self) -> None:
        self._socket.close()
        for process in filter(None, (self._process, self._screen)):
            process.terminate()
            process.wait(30)
        self._process.stderr.close()
        self._folder.cleanup()


class Chromium:
    """A Chromium with the methods of `Firefox`."""

    def __init__(self, browser):
        self.page = sparing(browser.new_page(viewport={"width": 1440, "height": 900}))
        self.problems = []
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("console", lambda m: self.problems.append(m.text) if m.type == "error" else None)
        self.goto, self.evaluate = self.page.goto, self.page.evaluate
        self.press, self.close = self.page.keyboard.press, self.page.close

    def wait_for(self, condition):
        return self.page.wait_for_function(f"() => {condition}", timeout=1000 * PATIENCE_S).json_value()

    def click(self, selector, text=""):
        self.page.locator(selector).filter(has_text=text).locator("visible=true").first.click()


def _virtual_screen(width: int, height: int) -> tuple[subprocess.Popen, str]:
    """Start Xvfb with a number that it chooses → its process and the display's name."""
    read, write = os.pipe()
    size = f"{width}x{height}x24"
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", size, "-nolisten", "tcp"]
    process = subprocess.Popen(command, pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as said:
        number = said.readline().strip()
    if not number:
        raise RuntimeError("Xvfb did not start")
    return process, f":{number}"

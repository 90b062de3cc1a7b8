"""How many files of app/ three flows enter, from a browser's message to what the page has drawn.

PYTHONPATH=tests python tests/measure_flows.py    # --files names them
"""

import sys
import threading
from pathlib import Path

import msgspec
from quiet_page import QuietPage
from waiting import wait_until

from viewimit.loop.settings import Settings

APP = str(Path(__file__).parents[1] / "app")


class Files:
    """The files of app/ that threads enter inside; `until`, file:name, is the function whose return ends it."""

    def __init__(self, until: str = ""):
        self.found: set[str] = set()
        self._until, self._ended = until, False

    def __enter__(self):
        threading.setprofile(self._enter)
        sys.setprofile(self._enter)
        return self

    def __exit__(self, *_):
        sys.setprofile(None)
        threading.setprofile(None)

    def _enter(self, frame, event, _):
        if self._ended or event not in ("call", "return") or not frame.f_code.co_filename.startswith(APP):
            return
        file = frame.f_code.co_filename[len(APP) + 1 :]
        if event == "call" and file != "quiet_client.py":  # which stands for the browser here
            self.found.add(file)
        self._ended |= event == "return" and f"{file}:{frame.f_code.co_name}" == self._until


def page_at_rest() -> QuietPage:
    page = QuietPage(Settings.paper())
    page.restore()
    page.page.queue.call("unseen", "Curves,Equations,Duel,Experiments,Follow")
    page.page.queue.call("step")
    for _ in range(20):
        page.tick(0.5)
    return page


def slider_to_pose() -> set[str]:
    """A slider's value, until the arms are posed."""
    page = page_at_rest()
    with Files(until="scene/arms.py:draw") as files:
        page.change("θ₂", 50.0)
        page.page.tick(page.now + 0.05)
    return files.found


def play_to_panels() -> set[str]:
    """Play, one motion, and all panels drawn."""
    page = page_at_rest()
    made = page.page.model.session.cursor
    with Files() as files:
        page.click("Play")
        wait_until(lambda: page.tick(0.05) or page.page.model.session.cursor > made)
        page.tick(1.0)
    return files.found


def reload() -> set[str]:
    """What a tab hands back, until its session is there and the arms are posed."""
    page = page_at_rest()
    page.page.queue.call("step")
    kept, again = page.kept, QuietPage(Settings.paper())
    for _ in range(20):  # until its own landscape is there
        again.tick(0.5)
    pieces = [[1, "session", kept]]
    with Files() as files:
        following = again.page.model.following
        again.page.layout.named["actions"].take(msgspec.json.encode({"load": "", "acts": pieces}).decode())
        again.page.tick(again.now + 0.05)
        wait_until(lambda: again.page.tick(again.now + 0.1) or not following.goes_on)
    assert again.page.model.session.cursor == page.page.model.session.cursor
    return files.found


FLOWS = {"slider -> pose": (slider_to_pose, 8), "Play -> panels": (play_to_panels, 20), "reload": (reload, 12)}


if __name__ == "__main__":
    for flow, (run, most) in FLOWS.items():
        found = run()
        print(f"{flow}: {len(found)} files of app/; {most} are the aim")
        if "--files" in sys.argv:
            print(*(f"    {file}" for file in sorted(found)), sep="\n")

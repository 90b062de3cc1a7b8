"""How many files of app/ a visitor's doing enters: `python tests/measure_flows.py`.

Each flow runs on a page without a browser, and the files are counted whose functions are called meanwhile: "slider",
from a slider's new value to the arm's new pose; "play", from Play over one motion until all panels are drawn.
"""

import sys
from collections.abc import Callable
from pathlib import Path

from page_fakes import QuietLandscapes
from quiet_page import QuietPage

from viewimit.loop.settings import Settings

APP = str(Path(__file__).parent.parent / "app")
LIMITS = {"slider": 10, "play": 35}  # files


STUB = "quiet_client.py"  # stands for viser


def files_entered(flow: Callable[[], None], until: str = "") -> list[str]:
    """Files of app/ whose functions are called by a flow, in the order in which they are first. until: the function in
    which the flow ends."""
    entered: dict[str, None] = {}

    def on_event(frame, event, _argument):
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(APP) and not code.co_filename.endswith(STUB):
            entered.setdefault(code.co_filename[len(APP) + 1 :])
            if code.co_name == until:
                sys.setprofile(None)

    sys.setprofile(on_event)
    try:
        flow()
    finally:
        sys.setprofile(None)
    return list(entered)


def slider() -> list[str]:
    page = QuietPage(Settings.paper(), landscapes=QuietLandscapes())
    for _ in range(40):
        page.tick()
    joint = next(widget for widget in page.gui.widgets if vars(widget).get("step") == 0.5)

    def turn() -> None:
        joint.value = 60.0
        page.tell(joint)
        page.page.tick(page.now + 0.05)

    entered = files_entered(turn, until="push_orientation")
    assert page.page.model.settings.demonstrator_deg[0] == 60
    return entered


def play() -> list[str]:
    page = QuietPage(Settings.paper(), landscapes=QuietLandscapes())
    for _ in range(40):
        page.tick()

    def play_on() -> None:
        page.tell(page.widget("Play"))
        for _ in range(40):
            page.tick()

    entered = files_entered(play_on)
    assert page.page.model.snapshot.motion > 1
    return entered


FLOWS = {"slider": slider, "play": play}


def main() -> None:
    for name, flow in FLOWS.items():
        entered = flow()
        print(f"{name}: {len(entered)} files (at most {LIMITS[name]})")
        for file in entered:
            print(f"  {file}")


if __name__ == "__main__":
    main()

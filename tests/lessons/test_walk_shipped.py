"""Every shipped lesson is walked from its first step to its end: with keys alone, with the mouse, and with a finger."""

import pytest
from browsing import sparing
from viewimit.app.lab.lessons.page import lesson_page
from viewimit.app.lab.lessons.source import ORDER, shipped
from waiting import wait_until

pytestmark = [pytest.mark.browser, pytest.mark.slow]

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
DESK = {"viewport": {"width": 1280, "height": 720}}
HANDS = {"keys": DESK, "mouse": DESK, "finger": PHONE}
STEP = """() => {
    const stage = lesson.stage(), state = lesson.state();
    return stage && {id: stage.step.id, kind: stage.step.ask.kind, run: state.run, revealed: state.revealed,
        figure: stage.step.ask.figure};
}"""
COVERED = """() => [...document.querySelectorAll('#foot button')].filter(button => {
    const {left, top, width, height} = button.getBoundingClientRect();
    return !button.contains(document.elementFromPoint(left + width / 2, top + height / 2));
}).map(button => button.textContent)"""
MISSING = "document.getElementById('body').innerText.match(/There is no figure|undefined|NaN|\\\\{[^}]*\\\\}/g)"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shipped")
    for name in ORDER:
        folder.joinpath(f"{name}.html").write_text(lesson_page({name: shipped()[name]}), "utf-8")
    return folder


@pytest.fixture
def opened(browser, folder):
    contexts, faults = [], []

    def open_(name, **options):
        contexts.append(sparing(browser.new_context(reduced_motion="reduce", **options)))
        page = contexts[-1].new_page()
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda said: faults.append(said.text) if said.type in ("error", "warning") else None)
        page.goto(folder.joinpath(f"{name}.html").as_uri() + f"#lesson={name}&step={shipped()[name].step[0].id}&seed=2")
        wait_until(lambda: page.evaluate("typeof lesson === 'object'"))
        return page

    yield open_
    for context in contexts:
        context.close()
    assert faults == []


def settled(page):
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


class Keys:
    """Answers with keys alone."""

    def __init__(self, page):
        self.page = page

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)
        settled(self.page)

    def choose(self, k):
        self.press(str(k + 1))

    def mark(self):
        self.press("ArrowUp", "Shift+ArrowRight")

    def slide(self, k):
        self.page.locator("input[type=range]:visible").nth(k).focus()
        self.press("ArrowRight", "ArrowRight")
        self.page.evaluate("document.activeElement.blur()")

    def go_on(self):
        primary = self.page.inner_text(".primary")
        self.press("Enter" if "↵" in primary else "ArrowRight" if "→" in primary else "Tab")


class Mouse:
    """Answers with a pointer; a finger taps."""

    def __init__(self, page, tap=False):
        self.page, self.tap = page, tap

    def press(self, selector, nth=0):
        target = self.page.locator(selector).nth(nth)
        target.tap() if self.tap else target.click()
        settled(self.page)

    def choose(self, k):
        self.press(".option:visible", k)

    def mark(self):
        box = self.page.locator(".asked .drawing").bounding_box()
        at = box["x"] + 0.45 * box["width"], box["y"] + 0.5 * box["height"]
        self.page.touchscreen.tap(*at) if self.tap else self.page.mouse.click(*at)
        settled(self.page)

    def slide(self, k):
        box = self.page.locator("input[type=range]:visible").nth(k).bounding_box()
        at = box["x"] + 0.7 * box["width"], box["y"] + box["height"] / 2
        self.page.touchscreen.tap(*at) if self.tap else self.page.mouse.click(*at)
        settled(self.page)

    def go_on(self):
        self.press(".primary")


def answer(hands, step):
    """One answer to a step of any kind."""
    kind = step["kind"]
    if kind == "choice":
        hands.choose(0)
    elif kind == "place":
        hands.mark()
    elif kind in ("number", "bet", "pose"):
        hands.slide(0)
    elif kind == "predict":
        hands.slide(0)
        hands.mark()


@pytest.mark.parametrize("kind", HANDS)
@pytest.mark.parametrize("name", ORDER)
def test_a_lesson_is_walked_to_its_end(opened, name, kind):
    page = opened(name, **HANDS[kind])
    hands = Keys(page) if kind == "keys" else Mouse(page, kind == "finger")
    seen = []
    for _ in range(40):
        settled(page)
        step = page.evaluate(STEP)
        if step is None:
            break
        assert page.evaluate(COVERED) == [], step
        if step["kind"] == "do":
            page.click(".primary")  # a solution is found and shown
        else:
            answer(hands, step)
            hands.go_on()
            if step["kind"] == "predict":
                page.evaluate("lesson.reveal()")
        settled(page)
        now = page.evaluate(STEP)
        assert now["revealed"] and now["id"] == step["id"], step
        assert page.evaluate(COVERED) == [] and page.evaluate(MISSING) is None, step
        assert "Now you can say" in page.inner_text("#body")
        seen.append(step["id"])
        hands.go_on()
    assert page.evaluate("lesson.state().step") in ("end", "after-1")
    assert list(dict.fromkeys(seen)) == [step.id for step in shipped()[name].step]

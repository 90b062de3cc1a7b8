"""Figures of the lessons on limits, motion, design and claims in a browser: nothing covers words or cuts them."""

import pytest
from viewimit.app.lab.lessons.page import lesson_page
from viewimit.app.lab.lessons.source import shipped
from waiting import wait_until

pytestmark = pytest.mark.browser
SIZES = (390, 844), (1280, 720), (1920, 1080)
LESSONS = "limits", "motion", "design", "sign"
MIN_PX = 2.5  # of an overlap, in both directions
FAULTS = """minPx => {
  const faults = [], seen = element => element.checkVisibility({visibilityProperty: true, opacityProperty: true});
  for (const svg of document.querySelectorAll("figure svg.lesson-drawing")) {
    if (!seen(svg)) continue;
    const frame = svg.getBoundingClientRect();
    if (!svg.getAttribute("aria-label")) faults.push("no description");
    const words = [...svg.querySelectorAll("text")].filter(seen).map(text => ({said: text.textContent,
      box: text.getBoundingClientRect()})).filter(({said}) => said);
    words.forEach(({said, box}, k) => {
      if (box.left < frame.left - minPx || box.right > frame.right + minPx || box.top < frame.top - minPx
        || box.bottom > frame.bottom + minPx) faults.push(`"${said}" leaves the drawing`);
      for (const other of words.slice(k + 1))
        if (Math.min(box.right, other.box.right) - Math.max(box.left, other.box.left) > minPx
          && Math.min(box.bottom, other.box.bottom) - Math.max(box.top, other.box.top) > 2 * minPx)
          faults.push(`"${said}" and "${other.said}"`);
    });
  }
  return faults;
}"""


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lessons")
    for name in LESSONS:
        folder.joinpath(f"{name}.html").write_text(lesson_page({name: shipped()[name]}), "utf-8")
    return folder


@pytest.fixture
def opened(browser, pages):
    contexts, faults = [], []

    def open_(name, width, height):
        context = browser.new_context(viewport={"width": width, "height": height}, reduced_motion="reduce")
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
        page.goto(pages.joinpath(f"{name}.html").as_uri())
        wait_until(lambda: page.evaluate("typeof lesson === 'object'"))
        return page

    yield open_
    for context in contexts:
        context.close()
    assert faults == []


def settle(page):
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("name", LESSONS)
def test_no_words_cover_others_or_leave_their_drawing(opened, name, size):
    page, faults = opened(name, *size), {}
    for step in shipped()[name].step:
        page.evaluate("([name, step]) => lesson.goTo(name, step)", [name, step.id])
        settle(page)
        faults[step.id, "before"] = page.evaluate(FAULTS, MIN_PX)
        page.evaluate("lesson.reveal()")  # without an answer
        wait_until(lambda: page.evaluate("lesson.state().revealed"))
        page.wait_for_timeout(300)
        settle(page)
        faults[step.id, "after"] = page.evaluate(FAULTS, MIN_PX)
    assert {where: found for where, found in faults.items() if found} == {}

"""Figures of the lessons: those that lessons name exist, names in them do not cover each other, and hands move them."""

import json
import subprocess
from pathlib import Path

import pytest
import tomllib
import typescript
from viewimit.app.lab.lessons.page import lesson_page
from viewimit.app.lab.lessons.source import shipped
from waiting import wait_until

LESSONS = Path(__file__).parents[2] / "app" / "lab" / "lessons"
SIZES = {"phone": (390, 844), "laptop": (1280, 720)}
FAULTS = Path(__file__).with_name("faults.js").read_text("utf-8")


@pytest.fixture(scope="module")
def page_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("figures") / "lessons.html"
    path.write_text(lesson_page(shipped()), "utf-8")
    return path


@pytest.fixture
def opened(browser, page_file):
    """A step of a lesson, in a tab of a size."""
    tabs = []

    def open_step(lesson, step, size="laptop"):
        width, height = SIZES[size]
        page = browser.new_page(viewport={"width": width, "height": height}, reduced_motion="reduce")
        tabs.append(page)
        page.faults = []
        page.on("pageerror", lambda error: page.faults.append(str(error)))
        page.on("console", lambda message: page.faults.append(message.text) if message.type == "error" else None)
        page.goto(f"{page_file.as_uri()}#lesson={lesson}&step={step}&seed=5")
        page.wait_for_selector(".drawing [aria-label]")
        return page

    yield open_step
    for page in tabs:
        page.close()


def test_every_figure_layer_and_measure_that_lessons_name_is_there():
    command = [typescript.node(), str(Path(__file__).parent / "registered.mjs"), str(LESSONS)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    named = tomllib.loads((LESSONS / "figures" / "layers.toml").read_text("utf-8"))
    assert set(found["figures"]) == set(named)
    missing = {name: sorted(set(use["layers"]) - set(found["figures"][name])) for name, use in named.items()}
    assert not {name: layers for name, layers in missing.items() if layers}
    browser = tomllib.loads((LESSONS / "measures.toml").read_text("utf-8"))["browser"]
    assert found["measures"] == sorted(browser)
    assert len(set(found["ofGroups"])) == len(found["ofGroups"]) > 40  # none covers another


@pytest.mark.browser
@pytest.mark.parametrize("size", ["phone", pytest.param("laptop", marks=pytest.mark.slow)])
def test_no_name_covers_another_before_or_after_the_answer(opened, size):
    page, faults = opened("ray", "shadow", size), []
    for name, lesson in shipped().items():
        for step in lesson.step:
            page.evaluate("([name, id]) => lesson.goTo(name, id, 5)", [name, step.id])
            faults += [f"{step.id}, before: {fault}" for fault in _left(page)]
            page.evaluate("lesson.reveal()")
            faults += [f"{step.id}, after: {fault}" for fault in _left(page)]
    assert not faults
    assert not page.faults


def _left(page) -> list[str]:
    """The faults of a screen that are left once it stands still: drawn two frames later, but for what is computed."""
    found = []
    for _ in range(10):
        page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        if not (found := page.evaluate(FAULTS)):
            break
        page.wait_for_timeout(200)
    return found


def _middle(page, selector):
    """The middle of an element, once it stands still for two frames."""
    boxes = [None]

    def stands():
        boxes.append(page.locator(selector).first.bounding_box())
        return boxes[-1] if boxes[-1] == boxes[-2] else None

    box = wait_until(stands, sleep=lambda _: page.wait_for_timeout(250))
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


@pytest.mark.browser
def test_a_click_from_outside_is_where_it_is_drawn(opened):
    page = opened("ray", "shadow", "phone")
    page.mouse.click(*_middle(page, ".figure-outside .draw-mark-dot"))
    page.keyboard.press("Enter")
    page.wait_for_selector(".say:not(:empty)")
    assert "That is where the mark is already" in page.text_content("body")
    assert not page.faults


@pytest.mark.browser
@pytest.mark.parametrize(
    "step, figure, described",
    [
        ("minimum", "landscape", "Map of E"),
        ("minimum", "biases", "times the distance 0.066°"),
        ("crossing-angle", "crossing", "the lines from l and from r cross at 17.8°"),
        ("four-points", "matches", "10 matches: one minimum"),
    ],
)
def test_a_slider_moves_what_is_drawn(opened, step, figure, described):
    page = opened("limits", step)
    labels = f".figure-{figure} [aria-label]"
    page.evaluate("lesson.reveal()")
    page.wait_for_selector(".slider input")
    page.wait_for_timeout(300)
    heard = lambda: [one.get_attribute("aria-label") for one in page.locator(labels).all()]
    before = heard()
    slider = page.locator(".slider input").first
    slider.focus()
    page.keyboard.press("End")
    wait_until(lambda: heard() != before and any(described in one for one in heard()))
    assert not page.faults

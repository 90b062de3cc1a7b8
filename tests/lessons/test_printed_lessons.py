"""Every lesson prints: its questions, boxes and pictures, and its solutions on pages of their own."""

import re

import pytest
from viewimit.app.lab.lessons.format import Choice
from viewimit.app.lab.lessons.page import lesson_page
from viewimit.app.lab.lessons.source import shipped

pytestmark = pytest.mark.browser
PAPER = """() => { dispatchEvent(new Event("beforeprint"));
const all = [...document.querySelectorAll(".paper-lesson")].map(one => ({
  steps: [...one.querySelectorAll("section")].map(step => ({words: step.innerText.replaceAll("’", "'"),
    boxes: step.querySelectorAll(".paper-box > i").length, drawn: step.innerHTML,
    figures: [...step.querySelectorAll(".drawing")].map(box => [box.clientHeight, box.innerHTML.length])})),
  width: one.clientWidth, wide: one.scrollWidth}));
dispatchEvent(new Event("afterprint"));
return [all, document.querySelectorAll(".paper").length]; }"""


def test_every_lesson_is_on_paper_with_its_solutions(browser):
    lessons = shipped()
    page = browser.new_context(color_scheme="dark").new_page()
    page.route("**/*", lambda route: route.fulfill(content_type="text/html", body=lesson_page(lessons)))
    page.goto("http://lessons.test/")
    page.wait_for_function("() => globalThis.lesson")
    papers, left = page.evaluate(PAPER)  # the cover prints all of them
    assert left == 0 and len(papers) == 2 * len(lessons)
    for lesson, sheet, key in zip(lessons.values(), papers[::2], papers[1::2]):
        assert len(sheet["steps"]) == len(key["steps"]) == len(lesson.step)
        for step, asked, solved in zip(lesson.step, sheet["steps"], key["steps"]):
            question = re.split(r"[{]|Click", step.ask.question)[0]
            assert step.title in asked["words"] and question in asked["words"], step.id
            assert asked["boxes"] == (len(step.ask.answers) if isinstance(step.ask, Choice) else 0), step.id
            assert step.say.split("**")[0].split("{")[0] in solved["words"], step.id
            for one in (asked, solved):
                assert all(height > 60 and size > 90 for height, size in one["figures"]), (step.id, one["figures"])
                assert "NaN" not in one["drawn"] and "undefined" not in one["drawn"] and "{" not in one["words"], (
                    step.id
                )
        assert sheet["wide"] <= sheet["width"] + 1
    page.context.close()

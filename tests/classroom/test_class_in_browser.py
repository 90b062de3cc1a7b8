"""A lecturer and a student, each in a browser."""

import re

import pytest
from browsing import PATIENCE_MS, open_page, press, stands, wait, wait_for_count, wait_for_text, wait_until_complete
from browsing import posture as posture_of
from serving import Server
from waiting import wait_until

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

pytestmark = pytest.mark.browser
CLASS, TILE, BANNER, QUESTION = ".vi-class-head", ".vi-tile", ".vi-banner", ".vi-class-question"
JOIN = ".vi-join"


def touch(page, what):
    page.locator(f"a[href$='class/{what}']").first.click()


@pytest.fixture(scope="module")
def server():
    """Of a class in a network, if there is one."""
    served = Server("--lecturer", "--host", "0.0.0.0")
    yield served
    assert served.stop() == 0


@pytest.fixture(scope="module")
def lecturer(browser, server):
    page = open_page(browser, wait_until(lambda: re.search(r"the lecturer opens (\S+)\n", server.log))[1], "small")
    assert "lecturer" not in page.url
    yield page
    page.close()
    assert page.problems == []


def test_a_lecturer_shows_how_to_join_until_the_next_click(server, lecturer):
    others = wait_until(lambda: re.search(r"others open (\S+),|no network", server.log))[1]
    lecturer.get_by_role("tab", name="Class").click()
    wait_for_text(lecturer, f"Students open {others}" if others else "Nobody else reaches this page")
    if others:
        for hide in (lambda: lecturer.mouse.click(300, 200), lambda: lecturer.keyboard.press("Escape")):
            touch(lecturer, "invite")
            lecturer.wait_for_selector(JOIN, timeout=PATIENCE_MS)
            assert lecturer.locator(JOIN).bounding_box() == {"x": 0, "y": 0, "width": 1280, "height": 720}
            assert lecturer.locator(f"{JOIN} .vi-qr").bounding_box()["height"] > 720 / 2
            assert lecturer.evaluate("document.elementFromPoint(1200, 700).closest('a')?.className") == JOIN[1:]
            hide()
            wait_for_count(lecturer, JOIN, 0, exactly=True)


def test_the_class_is_large_by_a_link_and_by_a_key(lecturer):
    lecturer.get_by_role("tab", name="Class").click()
    width = lambda: (lecturer.locator(CLASS).bounding_box() or {"width": 0.0})["width"]
    wait(lecturer, lambda: width() > 0)
    usual = width()
    lecturer.get_by_role("link", name="Images, large or not").click()
    wait(lecturer, lambda: width() > 1.3 * usual)
    press(lecturer, "Escape")
    wait(lecturer, lambda: width() == usual)
    press(lecturer, "m")
    wait(lecturer, lambda: width() > 1.3 * usual)
    press(lecturer, "m")
    wait(lecturer, lambda: not lecturer.locator(CLASS).is_visible())
    press(lecturer, "m")
    wait(lecturer, lambda: width() == usual)
    lecturer.get_by_role("tab", name="Images").click()
    press(lecturer, "m")
    lecturer.get_by_role("tab", name="Class").click()
    wait(lecturer, lambda: width() > 1.3 * usual)
    press(lecturer, "Escape")
    wait(lecturer, lambda: width() == usual)


def test_a_lecturer_sees_leads_and_asks_a_student(browser, server, lecturer):
    student, alone = open_page(browser, server.url, "small"), Session(Settings.paper())
    assert not student.get_by_role("tab", name="Class").count()
    name = student.locator("div.mantine-Flex-root").filter(has=student.get_by_text("Your name", exact=True)).last
    name.locator("input").fill("<i>Mira</i>")
    name.locator("input").blur()
    lecturer.get_by_role("tab", name="Class").click()
    wait_for_text(lecturer, "<i>Mira</i>")
    wait_for_count(lecturer, TILE, 1, exactly=True)
    tells = lecturer.locator(f"{TILE} .vi-tells")
    lecturer.wait_for_function("document.querySelectorAll('.vi-tile .vi-tells').length === 3", timeout=PATIENCE_MS)
    for shown in (3, 0, 3):  # valley, diamond, degrees: before a class until T
        assert sum(tells.nth(k).is_visible() for k in range(3)) == shown
        press(lecturer, "p")
    press(lecturer, "p")
    touch(lecturer, "lead")
    wait_for_count(student, BANNER, 1)
    press(lecturer, "ArrowRight")
    alone.step()
    for page in (lecturer, student):
        wait(page, lambda page=page: posture_of(page) == stands(alone))
    press(student, "ArrowRight")
    wait_for_text(student, "The lecturer leads: this page follows")
    assert posture_of(student) == stands(alone)
    touch(lecturer, "lead")
    wait_for_count(student, BANNER, 0, exactly=True)
    student.reload()  # which keeps what was done, and the name
    wait_until_complete(student)
    lecturer.locator(".vi-lessons a").first.click()
    while not lecturer.locator(f"{QUESTION} a").count():
        before = lecturer.get_attribute(".vi-guide", "data-screen") if lecturer.locator(".vi-guide").count() else ""
        if before:
            lecturer.locator(".vi-options a").first.click()
            lecturer.locator(".vi-guide a:has(.vi-filled.vi-guide-main)").click()
        lecturer.wait_for_function(
            "before => (document.querySelector('.vi-guide')?.dataset.screen ?? '') !== before", arg=before,
            timeout=PATIENCE_MS,
        )  # fmt: skip
    touch(lecturer, "ask")
    student.wait_for_selector(QUESTION, timeout=PATIENCE_MS)
    assert not student.locator(".vi-guide-leave a,.vi-guide-foot a").count()
    student.locator(".vi-options a").first.click()
    wait_for_text(lecturer, "1 of 1 answered")
    touch(lecturer, "reveal")
    wait_for_text(student, "1 of 1 are right")
    touch(lecturer, "close")
    wait_for_count(student, ".vi-guide", 0, exactly=True)
    student.close()
    assert student.problems == []

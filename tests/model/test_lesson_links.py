"""Lessons are in the lab: the page leads there, and what it shows is in the link that leads back."""

import re
from urllib.parse import unquote

import msgspec
from drawn import OFFER
from quiet_page import QuietPage
from viewimit.app.lab.lessons.source import shipped
from viewimit.app.model.link import read_link
from viewimit.app.panels.guide import draw_head, draw_offer

from viewimit.loop.settings import Settings


def shown(page, lessons=None) -> str:
    lessons = shipped() if lessons is None else lessons
    return draw_head(page.page.model, lessons) + draw_offer(page.page.model, lessons)


def test_lab_and_lessons_are_linked_in_this_state_and_the_tour_offered_until_it_is_let_go():
    page = QuietPage(Settings.paper())
    html = shown(page)
    assert re.search(r'href="lab#preset=paper&amp;demo=', html) and 'href="lab/ray#page=' in html
    assert re.search(rf'{OFFER}.*href="lab/tour#page=', html)
    page.page.queue.call("dismiss")
    page.tick()
    assert OFFER not in shown(page) and 'href="lab/ray#page=' in shown(page)


def test_the_way_back_holds_what_the_page_shows():
    page = QuietPage(Settings.paper(transfer="linear"))
    page.page.queue.call("step")
    page.tick(0.3)
    (back,) = {unquote(text) for text in re.findall(r"#page=([^\"]+)", shown(page))}
    model = page.page.model
    linked = read_link(back, Settings.paper())
    assert linked.script == model.session.script and "demo=" not in back


def test_a_lecturers_own_lesson_is_offered_in_place_of_the_tour():
    own = msgspec.structs.replace(shipped()["ray"], title="Mine")
    html = shown(QuietPage(Settings.paper()), {"mine-01234567": own, **shipped()})
    assert re.search(rf'{OFFER}" role="dialog" aria-label="Mine".*href="lab/mine-01234567#page=', html)

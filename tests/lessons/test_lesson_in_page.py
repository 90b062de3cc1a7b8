"""A lesson stands in place of the page, which is as it was, to the bit, once it is left."""

import msgspec
import numpy as np
import pytest
from drawn import GUIDE, LESSONS, OFFER, REFUSED
from page_fakes import BUTTONS, CONTROLS
from quiet_page import QuietPage
from sameness import assert_same
from viewimit.app.control.command_loop import MESSAGE_STAYS
from viewimit.app.control.commands.display import LetGo
from viewimit.app.control.commands.lessons import VERBS
from viewimit.app.lessons.source import shipped
from viewimit.app.panels.guide.lesson import LessonPanel
from viewimit.app.sessions.autosave import SavedPage, SavedSession
from walking import answer

from viewimit.loop.settings import Settings

ADDRESS = "/touch/0.x"
FIRST = next(iter(shipped()))


@pytest.fixture
def page():
    """One that has been used: its learner has moved, a point is chosen, and it is not offered anything any more."""
    page = QuietPage(Settings(), address=ADDRESS)
    touch(page, "leave")
    for _ in range(3):
        page.page.put(BUTTONS["step"])
        page.tick(1.0)
    page.page.touch("point", "3")
    page.page.put(CONTROLS["rays"](True))
    landscape = page.page.model.landscape
    fine = lambda made: (
        made is not None and made.to_refine is None and made.shades
    )  # an empty one has nothing to refine, too
    page.tick_until(lambda: fine(landscape.made))
    page.tick(10.0)
    return page


def touch(page, *verbs):
    for verb in verbs:
        assert page.page.touch("lesson", verb)
        page.tick(1.0)


def course(page):
    return page.page.model.guided.course


def kept(page):
    """All that is kept of the page but what was answered in lessons."""
    memory = page.page.memory()
    return msgspec.structs.replace(memory.head, lessons=(), lesson=None), memory.history


@pytest.mark.parametrize("name", shipped())
def test_who_leaves_finds_the_page_as_it_was(page, name):
    before, shown, view = kept(page), page.shown, page.page.model.view
    state = page.page.model.state(page.now)
    touch(page, f"begin,{name}")
    assert course(page) is not None and page.page.model.shown_session is course(page).session
    for _ in course(page).screens:
        answer(course(page)) if course(page).screen.kind != "end" else None
        page.tick(1.0)
        course(page).go(1)
    touch(page, "leave")
    assert course(page) is None
    page.tick(1.0)
    assert kept(page)[0] == before[0] and page.page.model.view == view
    assert_same(kept(page)[1], before[1])
    assert page.shown == shown
    after = page.page.model.state(page.now)
    for field in ("generation", "settings", "present", "shown", "playing", "speed", "cursor", "last", "preset"):
        assert_same(getattr(after, field), getattr(state, field))


def test_what_was_answered_is_kept_and_gone_on_with(page):
    touch(page, f"begin,{FIRST}", "choose,1", "next", "choose,0")
    memory = page.page.memory()
    head = msgspec.msgpack.decode(msgspec.msgpack.encode(memory.head), type=SavedPage)
    later = QuietPage(Settings(), resumed=SavedSession(head, memory.history), address=ADDRESS)
    later.tick(1.0)
    assert course(later).progress == course(page).progress and course(later).progress.at == 1
    assert later.page.panel(LessonPanel).html == page.page.panel(LessonPanel).html
    touch(later, "leave", f"begin,{FIRST}")
    assert course(later).progress == course(page).progress
    touch(page, "leave")
    assert_same(kept(page)[1], kept(later)[1])


def test_a_lesson_that_is_over_begins_anew(page):
    touch(page, f"begin,{FIRST}")
    course(page).go(len(course(page).screens) - 1)
    touch(page, "leave", f"begin,{FIRST}")
    assert course(page).progress.at == 0 and course(page).progress.given == {}


def test_another_tab_knows_nothing_of_it(page):
    other = QuietPage(Settings(), address=ADDRESS)
    touch(other, "leave")
    before, lesson = kept(other), other.page.panel(LessonPanel)
    touch(page, f"begin,{FIRST}", "choose,1", "next")
    other.tick(1.0)
    assert course(other) is None and lesson.html == "" and kept(other)[0] == before[0]
    assert other.page.memory().head.lessons == ()
    touch(other, f"begin,{FIRST}")
    assert course(other).progress.given == {}


def test_a_lesson_is_offered_once_and_any_answer_ends_that():
    for reply in (lambda page: touch(page, "leave"), lambda page: page.page.put(LetGo())):
        page = QuietPage(Settings(), address=ADDRESS)
        page.tick(1.0)
        assert OFFER in page.shown and "New here?" in page.shown
        reply(page)
        page.tick(1.0)
        assert OFFER not in page.shown
        memory = page.page.memory()
        again = QuietPage(Settings(), resumed=memory, address=ADDRESS)
        again.tick(1.0)
        assert OFFER not in again.shown and LESSONS in again.shown


@pytest.mark.parametrize("name", ["play", "step", "undo", "reset", "duel", "run", "rehearse"])
def test_the_pages_own_controls_rest_and_say_so(page, name):
    before = kept(page)
    touch(page, f"begin,{FIRST}")
    page.page.put(BUTTONS[name])
    page.page.queue.put_value(CONTROLS["noise_px"], 2.0)
    page.tick(1.0)
    assert "In a lesson the page's own controls rest: Esc leaves it." in page.page.model.message.text
    assert REFUSED in page.shown and "own controls rest: Esc leaves it." in page.page.panel(LessonPanel).html
    touch(page, "leave")
    assert kept(page)[0] == before[0]
    assert_same(kept(page)[1], before[1])


def test_what_cannot_be_answered_is_told_on_the_card_for_a_while(page):
    touch(page, f"begin,{FIRST}")
    for verb, why in (("choose,7", "no answer 8 here"), ("seed,0", "no start is dealt"), ("next,1", "nothing in a")):
        touch(page, verb)
        assert why in page.page.panel(LessonPanel).html.partition(REFUSED)[2]
    page.tick(MESSAGE_STAYS + 1)
    assert REFUSED not in page.shown


def test_escape_leaves_at_once(page):
    touch(page, f"begin,{FIRST}")
    page.page.put(LetGo())
    page.tick()
    assert course(page) is None and GUIDE not in page.shown


HOSTILE = ["1e300", "-1e300", "nan", "inf", "-inf", "-1", "9" * 30, "1e-320", "0x10", "x", "", "1_0"]


@pytest.mark.parametrize("at", range(len(shipped()[FIRST].step) + 2))
def test_whatever_a_browser_tells_a_lesson_does_no_harm(at):
    """On every step, and on a question: the page goes on, and what is kept is finite and can be read again."""
    page = QuietPage(address=ADDRESS)
    touch(page, f"begin,{FIRST}")
    first = len(shipped()[FIRST].question) - 1
    for verb in (*VERBS, "begin", "leave", "explode", ""):
        if course(page) is None:
            touch(page, f"begin,{FIRST}")
        course(page).go(first + at - course(page).progress.at)
        for count in range(4):
            for word in HOSTILE:
                page.page.touch("lesson", ",".join([verb, *[word] * count]))
        page.tick(1.0)
        memory = page.page.memory()
        read = msgspec.msgpack.decode(msgspec.msgpack.encode(memory.head), type=SavedPage)
        assert read == memory.head
        for progress in read.lessons:
            for given in progress.given.values():
                numbers = [*(given.place or ()), given.number or 0.0, *given.sliders, given.seed, *given.E]
                assert np.abs(numbers).max() < 1e5
    assert page.page.model.message is None or "error" not in page.page.model.message.text


def test_with_less_motion_what_would_be_played_is_shown_at_once(page):
    step = next((k for k, step in enumerate(shipped()["tour"].step) if step.play), None)
    touch(page, "begin,tour")
    course(page).go(len(shipped()["tour"].question) + step)
    page.tick_until(lambda: "races" in course(page).made)
    assert course(page).stage.played is not None
    page.page.touch("still", "1")
    page.tick()
    assert course(page).stage.played is None

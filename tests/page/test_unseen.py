"""Tabs that are not open, and windows that another hides, are not drawn; once they are seen they show what is. What is
drawn leaves the style of all else as it is."""

import pytest
from browsing import open_page, press, wait, wait_for_status, wait_for_text
from page_fakes import QuietLandscapes
from quiet_page import QuietPage

# In how many frames something on the page was another than before


@pytest.fixture
def page():
    made = QuietPage(landscapes=QuietLandscapes())
    ticks(made, 40)
    return made


def ticks(made, count):
    for _ in range(count):
        made.tick()


def leave_undrawn(made, what):
    made.act("unseen", what)
    ticks(made, 1)


def move(made):
    made.page.model.player.step(made.now)
    ticks(made, 60)


def written(made):
    return [widget.content for widget in made.gui.widgets]


def differ(before, after):
    return {k for k, (old, new) in enumerate(zip(before, after)) if old != new}


@pytest.mark.parametrize("tab", ["Images", "Landscape", "Curves", "Equations"])
def test_a_tab_that_is_not_open_is_not_drawn_until_it_is(page, tab):
    drawn = QuietPage(landscapes=QuietLandscapes())
    ticks(drawn, 40)
    leave_undrawn(page, tab)
    before, left = written(drawn), written(page)
    assert left == before
    move(drawn), move(page)
    others = differ(left, written(page))
    assert others < differ(before, written(drawn)), "all that is seen is drawn, and no less"
    leave_undrawn(page, "none")
    ticks(page, 20)
    assert written(page) == written(drawn)


def test_of_a_window_that_nobody_sees_nothing_is_drawn_until_somebody_does(page):
    drawn = QuietPage(landscapes=QuietLandscapes())
    ticks(drawn, 40)
    leave_undrawn(page, "window")
    before = written(page)
    move(drawn), move(page)
    assert written(page) == before and page.page.model.session.snapshot.motion == 1
    leave_undrawn(page, "none")
    ticks(page, 20)
    assert written(page) == written(drawn) != before


@pytest.fixture(scope="module")
def visited(browser, server):
    page = open_page(browser, server, "small")
    yield page
    page.close()
    assert page.problems == []


@pytest.fixture
def at_the_start(visited):
    """A page on which others have been, with its learner where it begins."""
    press(visited, "r")
    wait_for_status(visited, "Ready")
    return visited


LOSE_ONE = """() => {
const send = wire.postMessage.bind(wire);
window.sent = 0;
wire.postMessage = (data, ...rest) => data.type === "send" && window.sent++ === 0 ? undefined : send(data, ...rest);
}"""


@pytest.mark.browser
def test_what_did_not_reach_the_server_is_told_again_and_taken_once_in_its_order(at_the_start):
    page = at_the_start
    page.evaluate(LOSE_ONE)
    page.evaluate("() => [3, 4, 5].forEach(point => act('point', point))")
    wait(page, lambda: page.evaluate("window.sent >= 2 && unsaid.length === 0"))
    wait_for_text(page, "Point 5: its")

"""A tab keeps its session, in a browser: over reloads, lost connections, killed servers, and without storage."""

import contextlib

import pytest
from browsing import SIZES, posture, press, sparing, stands, status, wait, wait_for_status, wait_until_complete
from serving import Relay, Server

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

pytestmark = pytest.mark.browser
FORBIDDEN = "Object.defineProperty(window, 'sessionStorage', {get() { throw new DOMException('', 'SecurityError'); }})"
FULL = "Storage.prototype.setItem = () => { throw new DOMException('', 'QuotaExceededError'); }"
MANY = 1500  # characters that an address has at most


def stepped(motions: int) -> list[float]:
    """Where a learner stands after so many motions."""
    session = Session(Settings.paper())
    for _ in range(motions):
        session.step()
    return stands(session)


def step(page, motions: int, before: int = 0) -> None:
    for _ in range(motions):
        press(page, "ArrowRight")
    wait(page, lambda: posture(page) == stepped(before + motions))


def tab_of(context, url: str):
    """A tab with the page, complete."""
    page = context.new_page()
    page.goto(url)
    wait_until_complete(page)
    return page


@contextlib.contextmanager
def opened(browser, url: str, script: str = ""):
    """A tab in a context of its own, with a script that runs before the page's."""
    width, height = SIZES["least"]
    context, problems = sparing(browser.new_context(viewport={"width": width, "height": height})), []
    context.add_init_script(script)
    context.on("weberror", lambda error: problems.append(str(error.error)))
    yield tab_of(context, url)
    context.close()
    assert problems == []


def kept(page) -> str:
    return page.evaluate("kept.text")


def test_another_tab_has_a_session_of_its_own_and_a_duplicated_one_goes_on_from_the_same(browser, server):
    with opened(browser, server) as page:
        step(page, 3)
        wait(page, lambda: "steps=3" in page.url)
        other = tab_of(page.context, server)
        assert posture(other) == stepped(0) and kept(other) == ""
        other.close()
        with page.expect_popup() as popup:  # its storage is copied, as of a tab that is duplicated or opened again
            page.evaluate("window.open(location.href)")
        twin = popup.value
        wait_until_complete(twin)
        wait(twin, lambda: posture(twin) == stepped(3))
        step(twin, 1, before=3)
        assert posture(page) == stepped(3)
        press(twin, "ArrowLeft")  # its steps have come along
        wait(twin, lambda: posture(twin) == stepped(3))
        twin.close()


def test_an_address_that_a_person_wrote_opens_its_state_and_does_not_come_back_after_a_reload(browser, server):
    with opened(browser, f"{server}/?preset=best&demo=50,-80&steps=2") as page:
        session = Session(Settings(demonstrator_deg=(50, -80)))
        session.step(), session.step()
        wait(page, lambda: posture(page) == stands(session))
        wait(page, lambda: "steps=2" in page.url)
        press(page, "ArrowRight")
        session.step()
        wait(page, lambda: posture(page) == stands(session))
        page.reload()
        wait_until_complete(page)
        wait(page, lambda: posture(page) == stands(session))


def test_a_session_goes_on_after_its_server_was_killed_and_at_another_one(browser):
    first = Server()
    relay = Relay(first.url)
    with opened(browser, relay.url) as page:
        step(page, 4)
        press(page, "ArrowLeft")
        wait(page, lambda: posture(page) == stepped(3))
        wait(page, lambda: "at=3" in kept(page))
        first.process.kill()
        first.process.wait()
        second = Server()
        relay.lead_to(second.url)
        page.bring_to_front()
        wait(page, lambda: page.evaluate("box !== ''") and posture(page) == stepped(3))
        page.reload()
        wait_until_complete(page)
        wait(page, lambda: posture(page) == stepped(3))
        press(page, "ArrowRight")  # the motion that was undone
        wait(page, lambda: posture(page) == stepped(4))
    relay.close()
    assert second.stop() == 0


@pytest.mark.parametrize(
    "script", [pytest.param(FORBIDDEN, id="forbidden"), pytest.param(FULL, id="full", marks=pytest.mark.slow)]
)
def test_without_storage_a_short_session_is_in_the_address_and_a_long_one_is_said_to_be_lost(browser, server, script):
    with opened(browser, server, script) as page:
        step(page, 2)
        wait(page, lambda: "steps=2" in page.url)
        page.reload()
        wait_until_complete(page)
        wait(page, lambda: posture(page) == stepped(2))
        assert "would lose" not in status(page)
        page.evaluate("Object.defineProperty(TabSession.prototype, 'address', {get: () => ''})")  # as of a long one
        step(page, 1, before=2)
        wait_for_status(page, "a reload would lose this session")

"""Page, lab and lessons work in an installed Firefox and in Chromium, below a path of a real nginx."""

import nginx
import pytest
from serving import Server

pytestmark = [pytest.mark.browser, pytest.mark.skipif(nginx.PROGRAM is None, reason="no nginx")]
STATUS = "document.querySelector('[role=status]')?.textContent"


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    server = Server()
    with nginx.below_a_path(server.url, tmp_path_factory.mktemp("nginx")) as address:
        yield address
    server.process.terminate()
    server.process.wait(30)


def test_the_page_plays_to_its_end_below_its_own_address(window, address):
    window.goto(address)
    window.wait_for(f"/^Ready/.test({STATUS})")
    window.press(" ")
    ended = window.wait_for(
        f"!/^(Ready|Moving|Probing|Test move)/.test({STATUS}) && /[Aa]fter 9/.test({STATUS}) && {STATUS}"
    )
    assert "agree to 1.3 px" in ended
    assert window.evaluate("location.href").startswith(address) and "websocket=" not in window.evaluate("location.href")


def test_lab_and_lessons_open_below_a_path(window, address):
    window.goto(f"{address}lab")
    window.click("button", "Step")
    window.wait_for("document.body.innerText.includes('1 step')")
    window.goto(f"{address}lab/tour")
    window.click("button", "Start")
    window.wait_for("location.hash.includes('step=')")

"""What a browser may lack: WebGL, and a connection to the server. The page says so, and all else works."""

import re

import browser as chromium
import pytest
from browsing import PATIENCE_MS, POSTURE, posture, press, wait_for_status

pytestmark = pytest.mark.browser


@pytest.fixture
def without_webgl(browser):
    """A browser of its own; Playwright has no other way to take WebGL away."""
    flags = [flag for flag in chromium.FLAGS if "gl" not in flag and "swiftshader" not in flag]
    own = browser.browser_type.launch(executable_path=chromium.find(), args=[*flags, "--disable-3d-apis"])
    yield own
    own.close()


def test_without_webgl_a_still_picture_takes_the_scenes_place_and_all_else_works(without_webgl, server):
    page = without_webgl.new_page(viewport={"width": 1280, "height": 720})
    failed = []
    page.on("pageerror", lambda error: failed.append(str(error)))
    page.goto(server)
    page.wait_for_selector(".vi-flat svg", timeout=PATIENCE_MS)
    assert "draws no WebGL" in page.text_content(".vi-notice")
    before, still = posture(page), page.inner_html(".vi-flat")
    press(page, "Escape")
    press(page, "ArrowRight")
    page.wait_for_function(
        "([where, before]) => document.querySelector(where).textContent !== before",
        arg=[POSTURE, f"{before[0]:.1f}°"],
        timeout=PATIENCE_MS,
    )
    wait_for_status(page, "after 1 motion|E ")
    page.wait_for_function("still => document.querySelector('.vi-flat').innerHTML !== still", arg=still)
    assert failed == []


def test_a_websocket_that_does_not_open_is_told_with_what_to_check(browser, server):
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    page.clock.install()
    page.add_init_script(
        """window.Worker = class extends Worker {
          postMessage(data, ...rest) { if (data?.type !== "set_server") super.postMessage(data, ...rest); }
        };"""
    )
    page.goto(server)
    page.wait_for_load_state("load")
    page.clock.fast_forward(2_000)
    assert page.locator(".vi-notice").count() == 0
    page.clock.fast_forward(9_000)
    said = page.text_content(".vi-notice")
    assert re.search("no connection", said) and "--origin" in said and "Upgrade" in said
    page.close()

"""What a browser may lack: WebGL, which the lab needs not, and a connection to the server, of which the page tells."""

import re

import browser as chromium
import pytest
from browsing import PATIENCE_MS

pytestmark = pytest.mark.browser


@pytest.fixture
def without_webgl(browser):
    """A browser of its own; Playwright has no other way to take WebGL away."""
    flags = [flag for flag in chromium.FLAGS if "gl" not in flag and "swiftshader" not in flag]
    own = browser.browser_type.launch(executable_path=chromium.find(), args=[*flags, "--disable-3d-apis"])
    yield own
    own.close()


def test_without_webgl_the_visitor_comes_to_the_lab_in_the_same_state(without_webgl, server):
    page = without_webgl.new_page(viewport={"width": 1280, "height": 720})
    failed = []
    page.goto(f"{server}/?preset=paper&demo=50,-80")
    page.wait_for_url("**/lab#**", timeout=PATIENCE_MS)
    page.on("pageerror", lambda error: failed.append(str(error)))
    page.wait_for_function("document.body.innerText.includes('Step')", timeout=PATIENCE_MS)
    page.wait_for_function("decodeURIComponent(location.hash).includes('demo=50,-80')", timeout=PATIENCE_MS)
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

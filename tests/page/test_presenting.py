"""Before a class: what gives the answer away is hidden until T, whatever the window; what the learner has stays."""

import re

import pytest
from browsing import PATIENCE_MS, open_page, pause, press, wait_for_count, wait_until_complete

pytestmark = pytest.mark.browser
# Of the opening preset: the demonstrator stands at 45° and -90°, and the learner 65° off at a joint
ANSWER = r"\b45(\.0)?°|[-−]90(\.0)?°|° off|smallest E"
TOLD = """[...document.querySelectorAll("svg text,p,span,td,label,pre,i,b,input:not([type=radio])")]
  .filter(one => one.checkVisibility({visibilityProperty: true, opacityProperty: true}) && one.getClientRects().length)
  .map(one => one.value ?? one.textContent)"""
SHADOWS = """[...document.querySelector("[data-dock-root]").children].filter(one =>
  getComputedStyle(one).boxShadow != "none" && getComputedStyle(one).visibility == "visible")
  .map(one => one.getBoundingClientRect().left)"""
SHOWN = "name => window.__viserMutable.nodeRefFromName[name].visible"


def told(page):
    """What of the answer stands on the page."""
    pause(page)
    return [text for text in page.evaluate(TOLD) if re.search(ANSWER, text) or text in ("45", "-90", "45.0", "-90.0")]


def wait_for_node(page, name, shown):
    page.wait_for_function(f"name => ({SHOWN})(name) === {str(shown).lower()}", arg=name, timeout=PATIENCE_MS)


@pytest.fixture(scope="module")
def page(browser, server):
    """One for all windows: whoever has presented, presents no longer."""
    page = open_page(browser, server, "small")
    yield page
    page.close()
    assert page.problems == []


@pytest.mark.parametrize("size", [(1280, 720), (900, 600), (390, 844)])
def test_nothing_tells_the_answer_until_it_is_to_be_seen(page, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    pause(page)
    assert told(page)
    small = size[0] < 1000
    views = page.locator(".vi-views label:visible")
    assert views.count() == (4 if small else 0)
    if small:
        page.locator("label[for=vi-view-landscape]").click()
    press(page, "p")
    wait_for_node(page, "/now/recovered", False)
    wait_for_node(page, "/now/residuals", False)
    assert told(page) == []
    assert page.locator("[role=status]").is_visible() and page.locator('[aria-label="The four images"]').is_visible()
    for k in range(views.count()):
        views.nth(k).click()
        assert told(page) == [], views.nth(k).text_content()
    press(page, "l")
    page.wait_for_selector(".vi-share pre", timeout=PATIENCE_MS)
    assert page.locator(".vi-share pre:visible").count() == 1 and told(page) == []
    press(page, "Escape")
    wait_for_count(page, ".vi-share", 0, exactly=True)
    press(page, "t")
    wait_for_node(page, "/now/recovered", True)
    assert views.count() == (3 if small else 0)
    assert page.locator(".vi-truth").is_visible()
    if small:
        page.locator("label[for=vi-view-landscape]").click()
    assert any("smallest E" in text for text in told(page))
    press(page, "t")
    wait_for_node(page, "/now/residuals", False)
    assert told(page) == [] and page.locator('[aria-label="The four images"]').is_visible()
    press(page, "p")
    wait_for_node(page, "/now/residuals", True)
    assert views.count() == (4 if small else 0)
    assert page.problems == []


def test_a_page_that_is_loaded_anew_hides_it_again(browser, server):
    page = open_page(browser, f"{server}?present", "small")
    wait_for_node(page, "/now/residuals", False)
    page.reload()
    wait_until_complete(page)
    wait_for_node(page, "/now/residuals", False)
    assert told(page) == []
    assert page.evaluate(SHADOWS) == [640]  # of the images' panel; none is left of the controls'
    page.goto(server)
    wait_until_complete(page)
    wait_for_node(page, "/now/residuals", True)
    page.close()
    assert page.problems == []

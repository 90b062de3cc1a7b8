"""The camera of the 3-D scene in a real browser (viser leaves it in the window, for tests)."""

import numpy as np
import pytest
from browsing import chosen_point, open_page, press, wait

pytestmark = pytest.mark.browser

CAMERA = """() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() =>
  done(window.__viserMutable.camera.position.toArray()))))"""  # after another frame


@pytest.fixture(scope="module")
def page(browser, server):
    page = open_page(browser, server, "small")
    yield page
    page.close()
    assert page.problems == []


def camera_at_rest(page):
    """Where it is, once two looks in a row find it there."""
    places = [page.evaluate(CAMERA)]

    def rests():
        places.append(page.evaluate(CAMERA))
        return np.allclose(*places[-2:], atol=1e-3)

    wait(page, rests)
    return places[-1]


def test_the_view_is_fitted_to_another_canvas_unless_the_visitor_has_turned_it(page):
    first = camera_at_rest(page)
    page.set_viewport_size({"width": 1480, "height": 720})
    wait(page, lambda: not np.allclose(page.evaluate(CAMERA), first, atol=0.05))
    fitted = camera_at_rest(page)
    box = page.locator("canvas[data-engine]").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + 60  # where nothing stands over the scene
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 80, y, steps=4)
    page.mouse.up()
    wait(page, lambda: not np.allclose(page.evaluate(CAMERA), fitted, atol=0.3))
    turned = camera_at_rest(page)
    page.keyboard.down("ArrowRight")  # the page's: viser would turn its camera as long as it is held
    camera_at_rest(page)
    page.keyboard.up("ArrowRight")
    assert np.allclose(page.evaluate(CAMERA), turned, atol=0.05)
    page.set_viewport_size({"width": 1280, "height": 720})
    before = chosen_point(page)
    press(page, "n")
    wait(page, lambda: chosen_point(page) != before)
    assert np.allclose(page.evaluate(CAMERA), turned, atol=0.05)

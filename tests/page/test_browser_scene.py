"""The 3-D scene in a real browser: what three.js has of it (viser leaves its store in the window, for tests)."""

import numpy as np
import pytest
from browsing import LESSON, choose, chosen_point, fold, open_page, press, switch, wait
from viewimit.app.model.choices import PRESETS

from viewimit.drawing.theme import ROLES

pytestmark = pytest.mark.browser

POSES = """() => Object.fromEntries(Object.entries(window.__viserMutable.nodeRefFromName)
  .filter(([name, node]) => node && name && window.__viserSceneTree.getState()[name]?.effectiveVisibility)
  .map(([name, node]) => [name, [...node.quaternion.toArray(), ...node.position.toArray()]]))"""
CAMERA = """() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() =>
  done(window.__viserMutable.camera.position.toArray()))))"""  # after another frame
COLOURS = """name => { const found = []; window.__viserMutable.nodeRefFromName[name].traverse(part => {
  if (part.material?.color) found.push('#' + part.material.color.getHexString()) }); return found }"""
PLACE = """name => {
  const {camera, canvas, nodeRefFromName} = window.__viserMutable, box = canvas.getBoundingClientRect()
  const place = nodeRefFromName[name].getWorldPosition(camera.position.clone()).project(camera)
  return [box.left + box.width * (1 + place.x) / 2, box.top + box.height * (1 - place.y) / 2] }"""
LIT = """name => { const {canvas, nodeRefFromName} = window.__viserMutable, lights = []
  let top = nodeRefFromName[name]
  while (top.parent) top = top.parent
  top.traverse(part => { if (part.isDirectionalLight) lights.push([part.intensity, part.castShadow]) })
  return lights }"""
HAND = "/panda/learner/j1/j2/j3/j4/j5/j6/j7"


@pytest.fixture(scope="module")
def page(browser, server):
    page = open_page(browser, server, "small")
    yield page
    page.close()
    assert page.problems == []


def a_point(page):
    """Name of a node."""
    return next(name for name in page.evaluate(POSES) if name.startswith(f"{HAND}/p"))


def same(poses, others):
    return poses.keys() == others.keys() and all(np.allclose(poses[name], others[name], atol=1e-5) for name in poses)


def begin(page, preset):
    choose(page, "Preset", preset.name)
    wait(page, lambda: page.text_content(LESSON) == preset.says)


def test_after_other_worlds_all_stands_where_it_stood_at_first(page):
    first = PRESETS[0]
    before = page.evaluate(POSES)
    for name in ("Face to face", "Seven joints"):
        begin(page, next(preset for preset in PRESETS if preset.name == name))
        wait(page, lambda: not same(page.evaluate(POSES), before))
    begin(page, first)
    wait(page, lambda: same(page.evaluate(POSES), before), 20)


def test_a_click_beside_a_point_chooses_it(page):
    press(page, "n")
    x, y = page.evaluate(PLACE, a_point(page))
    page.mouse.click(x + 6, y - 6)
    wait(page, lambda: chosen_point(page) == a_point(page).rpartition("p")[2])


def test_the_page_has_the_browsers_scheme_until_the_visitor_chooses_one(page):
    name = a_point(page)
    fold(page, "Display")

    def prefer(scheme):
        page.emulate_media(color_scheme=scheme)

    def becomes(dark):
        page.wait_for_selector(f":root[data-mantine-color-scheme={'dark' if dark else 'light'}]")
        wait(page, lambda: ROLES["learner"][dark] in page.evaluate(COLOURS, name), 20)

    for scheme in ("dark", "light", "dark"):
        prefer(scheme)
        becomes(scheme == "dark")
    switch(page, "Dark")
    becomes(False)
    told = page.evaluate("acted")
    prefer("light")
    wait(page, lambda: page.evaluate("acted") > told and page.evaluate("unsaid.length === 0"))
    switch(page, "Dark")
    becomes(True)
    switch(page, "Dark")
    becomes(False)
    fold(page, "Display")


def test_shadows_are_cast_when_they_are_asked_for_and_add_no_light(page):
    fold(page, "Display")
    lit = lambda: page.evaluate(LIT, "/floor")
    ((sun, casts),) = lit()
    assert not casts and "/floor/shadows" not in page.evaluate(POSES)
    switch(page, "Shadows")
    wait(page, lambda: lit() and all(casts for _, casts in lit()) and "/floor/shadows" in page.evaluate(POSES))
    assert sum(intensity for intensity, _ in lit()) == pytest.approx(sun)
    switch(page, "Shadows")
    wait(page, lambda: lit() == [[sun, False]] and "/floor/shadows" not in page.evaluate(POSES))
    fold(page, "Display")


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


def test_nothing_of_visers_covers_the_scene_or_competes_with_the_page(page):
    assert page.locator(".mantine-Notification-root:visible").count() == 0
    settings = page.locator(".tabler-icon-adjustments")
    for width, height in ((1280, 720), (1024, 640), (900, 600), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        assert settings.is_hidden()  # viser's own, with a dark mode that would know nothing of the page's
        assert page.get_by_text("Dev Settings").is_hidden() and page.get_by_text("Dark Mode").is_hidden()

"""Points by hand in a real browser: placed and chosen by clicks on the arms, proposed, removed, undone, saved, kept."""

import re

import numpy as np
import pytest
from browsing import (
    CHOSEN_POINT,
    choose,
    chosen_point,
    fold,
    open_page,
    points_drawn,
    press,
    wait,
    wait_for_status,
)

from viewimit.simulation.robot import link_meshes
from viewimit.simulation.scene import load_scene

pytestmark = pytest.mark.browser

PLACE = """name => {
  const {camera, canvas, nodeRefFromName} = window.__viserMutable, box = canvas.getBoundingClientRect()
  const place = nodeRefFromName[name].getWorldPosition(camera.position.clone()).project(camera)
  return [box.left + box.width * (1 + place.x) / 2, box.top + box.height * (1 - place.y) / 2] }"""
VISIBLE = """() => Object.entries(window.__viserMutable.nodeRefFromName)
  .filter(([name, node]) => node && window.__viserSceneTree.getState()[name]?.effectiveVisibility)
  .map(([name]) => name)"""
ELBOW = "/panda/{}/j1/j2/j3/j4"
PROPOSED = "circle.vi-proposed"
DARK = "document.documentElement.dataset.mantineColorScheme == 'dark'"
# The arms' shapes as they are drawn, and where they must be: left, top, right, bottom px
FITS = """() => {
  const {camera, canvas, nodeRefFromName} = window.__viserMutable, box = canvas.getBoundingClientRect(), arms = []
  for (const [name, node] of Object.entries(nodeRefFromName)) if (node && /[/](learner|demonstrator)$/.test(name))
    node.traverse(mesh => {
      const places = mesh.isMesh && mesh.geometry.attributes.position, at = camera.position.clone()
      for (let i = 0; i < (places ? places.count : 0); i += 5) {
        at.fromBufferAttribute(places, i).applyMatrix4(mesh.matrixWorld).project(camera)
        arms.push([box.left + box.width * (1 + at.x) / 2, box.top + box.height * (1 - at.y) / 2])
      }
    })
  const x = arms.map(place => place[0]), y = arms.map(place => place[1])
  const least = values => values.reduce((a, b) => Math.min(a, b))
  const most = values => values.reduce((a, b) => Math.max(a, b))
  const strip = document.querySelector("[role=status]").closest(".vi-strip").getBoundingClientRect()
  return [[least(x), least(y), most(x), most(y)], [box.left, box.top, box.right, strip.top]] }"""


def click_at(page, node):
    page.mouse.click(*page.evaluate(PLACE, node))


def proposed_nodes(page):
    return [name for name in page.evaluate(VISIBLE) if name.endswith("/proposed")]


def place_choose_and_take(page, count):
    """From so many points to two more, one of them placed by a click; what is said before and after."""
    said = wait_for_status(page, rf"Editing points · {count} points; noise of 1 px: θ₂ [\d.]+°, θ₄ [\d.]+°; σ₁/σ₃ \d+")
    click_at(page, ELBOW.format("demonstrator"))
    wait_for_status(page, f"{count + 1} points")
    wait(page, lambda: chosen_point(page) == str(count) and page.locator(CHOSEN_POINT).count() == 4)
    other = next(name for name in page.evaluate(VISIBLE) if name.startswith(ELBOW.format("learner")) and "/p7" in name)
    click_at(page, other)  # a point, not another one there
    wait(page, lambda: chosen_point(page) == "7")

    press(page, "b")
    wait_for_status(page, "The hollow point would help most: noise of 1 px: ")
    wait(page, lambda: len(proposed_nodes(page)) == 2 and page.locator(PROPOSED).count() == 4)
    hollow = min(proposed_nodes(page))
    place = page.evaluate(PLACE, hollow)
    press(page, "b")
    after = wait_for_status(page, f"{count + 2} points")
    wait(page, lambda: not proposed_nodes(page) and page.locator(PROPOSED).count() == 0)
    taken = hollow.replace("/proposed", f"/p{count + 1}")
    wait(page, lambda: taken in page.evaluate(VISIBLE))
    np.testing.assert_allclose(page.evaluate(PLACE, taken), place, atol=0.5)
    return said, after


def test_points_are_placed_removed_proposed_and_saved_in_light_and_dark(browser, server, tmp_path, ask_json):
    page = open_page(browser, server, "small", color_scheme="light")
    assert page.get_by_text(re.compile("^Points(: .*)?$")).count() == 1
    fold(page, "Points")
    page.get_by_text("Edit points", exact=True).click()
    said, after = place_choose_and_take(page, 10)
    assert "σ₁/σ₃ 12" in said and worst(after) < worst(said)

    press(page, "Delete")
    wait_for_status(page, "11 points")
    press(page, "ArrowLeft")
    wait_for_status(page, "Back is what was here before.* 12 points")
    with page.expect_download() as download:
        page.get_by_role("button", name="Save scene").click()
    path = tmp_path / download.value.suggested_filename
    download.value.save_as(path)
    scene = load_scene(path)
    assert list(scene.points) == ["12"] and {link for link, *_ in scene.points["12"][10:]} <= set(link_meshes("panda"))
    status, told = ask_json("imitate", "--scene", path, "--demonstrator", "45,-90", "--start", "25,-45")
    assert status == 0 and told["settings"]["points"] == 12 and told["error_deg"] < 0.1

    page.emulate_media(color_scheme="dark")
    page.wait_for_function(DARK)
    click_at(page, ELBOW.format("demonstrator"))  # where a point is now
    wait(page, lambda: chosen_point(page) == "10")
    press(page, "Delete")
    said, after = place_choose_and_take(page, 11)
    assert worst(after) <= worst(said)
    press(page, "Delete")
    wait_for_status(page, "12 points")
    press(page, "Escape")
    page.reload()
    wait(page, lambda: points_drawn(page) == [12, 12])

    choose(page, "Preset", "KUKA iiwa")  # whose arms are the largest
    press(page, "e")
    press(page, "v")
    wait_for_status(page, "Editing points")
    wait(page, lambda: arms_are_in_sight(page))
    page.close()
    assert page.problems == []


def arms_are_in_sight(page):
    """All that is drawn of both, above the words under them."""
    (left, top, right, bottom), free = page.evaluate(FITS)
    return left >= free[0] and top >= free[1] and right <= free[2] and bottom <= free[3]


def worst(said):
    """Degrees, of the joints named."""
    return max(float(cost) for cost in re.findall(r"θ. ([\d.]+)°", said.split("hollow")[0]))

"""Points by hand in a real browser: placed and chosen by clicks on the arms, proposed, removed, undone, saved, kept."""

import re

import numpy as np
import pytest
from browsing import CHOSEN_POINT, FOUR_IMAGES, chosen_point, open_page, press, wait, wait_for_status
from serving import Server

from viewimit.simulation.link_meshes import link_meshes
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


@pytest.fixture
def served():
    server = Server()
    yield server
    assert server.stop() == 0


def click_at(page, node):
    page.mouse.click(*page.evaluate(PLACE, node))


def proposed_nodes(page):
    return [name for name in page.evaluate(VISIBLE) if name.endswith("/proposed")]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_points_are_placed_removed_proposed_and_saved(browser, served, scheme, tmp_path, ask_json):
    page = open_page(browser, served.url, "small", color_scheme=scheme)
    assert page.get_by_text("Points", exact=True).count() == 1
    page.get_by_text("Points", exact=True).click()
    page.get_by_text("Edit points", exact=True).click()
    said = wait_for_status(page, r"Editing points · 10 points; 1 px costs θ₂ [\d.]+°, θ₄ [\d.]+°; σ₁/σ₃ 12")
    click_at(page, ELBOW.format("demonstrator"))
    wait_for_status(page, "11 points")
    wait(page, lambda: chosen_point(page) == "10" and page.locator(CHOSEN_POINT).count() == 5)
    other = next(name for name in page.evaluate(VISIBLE) if name.startswith(ELBOW.format("learner")) and "/p7" in name)
    click_at(page, other)  # a point, not another one there
    wait(page, lambda: chosen_point(page) == "7")

    press(page, "b")
    wait_for_status(page, "The hollow one tells most")
    wait(page, lambda: len(proposed_nodes(page)) == 2)
    assert page.locator(PROPOSED).count() == 4
    hollow = min(proposed_nodes(page))
    place = page.evaluate(PLACE, hollow)
    press(page, "b")
    now = wait_for_status(page, "12 points")
    assert worst(now) < worst(said)
    wait(page, lambda: not proposed_nodes(page) and page.locator(PROPOSED).count() == 0)
    taken = hollow.replace("/proposed", "/p11")
    wait(page, lambda: taken in page.evaluate(VISIBLE))
    np.testing.assert_allclose(page.evaluate(PLACE, taken), place, atol=0.5)

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

    press(page, "Escape")
    page.reload()
    wait(page, lambda: "12 of 12" in page.locator(FOUR_IMAGES).text_content().replace("\xa0", " "))
    page.close()
    assert page.problems == []


def worst(said):
    """Degrees, of the joints named."""
    return max(float(cost) for cost in re.findall(r"θ. ([\d.]+)°", said.split("hollow")[0]))

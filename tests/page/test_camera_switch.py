"""The switch Camera pictures, from a browser's message to pictures in its page, with a real process that renders."""

import multiprocessing
import re

import pytest
from browsing import (
    DETECTED,
    PHOTOGRAPH,
    POSTURE,
    fold,
    open_page,
    points_drawn,
    press,
    status,
    switch,
    wait_for_count,
    wait_for_status,
)
from protocol import Client
from serving import Here
from viewimit.app.jobs.camera_images import CameraProcess
from viewimit.app.model.services import Services
from viewimit.app.server import pages
from waiting import wait_until

BEGINS_WITHIN_S = 60  # a process of the camera images, on a busy machine


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A server in this process; `camera` is its process of the camera images."""
    camera = CameraProcess()
    monkeypatch.setattr(pages, "Services", lambda share: Services(share, camera))
    server = Here()
    server.camera = camera
    yield server
    server.stop()
    assert not server.camera.running


def photographs(client: Client) -> set[str]:
    """The pictures that the page shows, as data."""
    panel = next((html for html in list(client.html.values()) if 'aria-label="The four images"' in html), "")
    return set(re.findall(r'href="(data:image/jpeg;base64,[^"]+)"', panel))


def switch_on(client: Client) -> None:
    client.put("Camera pictures", True)
    wait_until(lambda: len(photographs(client)) == 4, BEGINS_WITHIN_S)


def test_a_process_that_is_killed_is_replaced_by_another(here):
    with Client(here.url).ready() as client:
        switch_on(client)
        before = photographs(client)
        (process,) = (child for child in multiprocessing.active_children() if child.name == "viewimit-camera")
        process.kill()
        client.press("Make one step")
        wait_until(lambda: len(photographs(client) - before) == 2, BEGINS_WITHIN_S)
        assert "projected points" not in client.status


LOADED = """async where => {
  const pictures = [...document.querySelectorAll(where)].map(image => {
    const loaded = new Image(); loaded.src = image.getAttribute('href'); return loaded })
  await Promise.all(pictures.map(picture => picture.decode()))
  return pictures.map(picture => [picture.naturalWidth, picture.naturalHeight])
}"""
STROKE = """where => { const {strokeLinecap, stroke} = getComputedStyle(document.querySelector(where))
  return [strokeLinecap, stroke] }"""


@pytest.mark.browser
def test_a_visitor_sees_four_pictures_with_what_was_detected_in_them(browser, server):
    page = open_page(browser, server, "small")
    fold(page, "Display")
    switch(page, "Camera pictures")
    wait_for_count(page, PHOTOGRAPH, 4)
    assert page.evaluate(LOADED, PHOTOGRAPH) == [[640, 240]] * 4
    press(page, "ArrowRight")
    page.wait_for_selector(f"{POSTURE} >> text=/^40[.]?/", timeout=60_000)
    in_L, in_R = points_drawn(page)
    assert in_L == in_R >= 5
    assert page.evaluate(STROKE, DETECTED) == ["round", "rgb(0, 114, 178)"]  # the learner's, and points are dots
    wait_for_status(page, "^(?!.*starting)")
    assert re.search(r"E is [\d.]+ px²", status(page))
    switch(page, "Camera pictures")
    wait_for_count(page, PHOTOGRAPH, 0, exactly=True)
    assert page.problems == []
    page.close()

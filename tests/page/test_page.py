"""A page that looks with pictures takes its turns beside the scheduler's thread: nothing waits for it but itself."""

import time

import numpy as np
import pytest
from page_fakes import Camera, Visit, call
from viewimit.app.model.keeping import tab_link
from viewimit.app.panels import PANELS
from waiting import wait_until

from viewimit.loop.settings import Settings

VIEWS = ["L", "R", "l", "r"]


@pytest.fixture
def camera():
    return Camera()


@pytest.fixture
def visit(camera):
    """A page with camera images on, at rest."""
    visit = Visit(camera)
    visit.put("camera", True)
    visit.arrive()
    assert visit.session.settings.sensor == "rendered" and visit.photographs == VIEWS
    yield visit
    camera.gate.set()
    assert visit.page.close()


def test_on_its_way_an_arm_is_shown_in_3d_and_no_picture_changes(camera, visit):
    before = visit.images
    visit.act("step")
    visit.rest()
    looks = len(camera.asked)
    theta, moving = visit.player.runners[0].theta(visit.now)
    visit.tick(3)
    assert moving and not np.array_equal(theta, visit.player.runners[0].theta(visit.now)[0])
    assert visit.images == before
    visit.tick(20)
    assert visit.images != before and visit.photographs == VIEWS
    assert len(camera.asked) == looks


def test_a_lost_process_costs_the_pictures_and_nothing_else(camera, visit):
    visit.put("joint0", 60.0)
    visit.arrive()
    camera.loss = "the process has ended"
    visit.act("play")
    visit.rest()
    visit.arrive()
    assert "the process has ended: back to projected points" in visit.said
    assert visit.session.settings.sensor == "projected" and visit.session.settings.demonstrator_deg[0] == 60
    assert visit.photographs == [] and not visit.player.playing
    visit.act("step")
    visit.tick()
    assert visit.session.snapshot.motion == 1


def kept(visit):
    """What its tab hands back."""
    return call("session", tab_link(visit.page.model)[0])


def test_a_kept_session_comes_back_with_its_history_and_its_pictures(camera, visit):
    for _ in range(2):
        visit.act("step")
        visit.arrive()
    again = Camera()
    again.gate.clear()
    back = Visit(again)
    back.page.queue.put(kept(visit))
    back.tick()
    wait_until(lambda: again.asked)
    back.tick(20)
    assert not back.page.busy and back.session.settings.sensor == "projected"  # others' pages go on, and this one
    again.gate.set()
    wait_until(lambda: not back.page.model.following.goes_on, 30, lambda pause: (time.sleep(pause), back.tick()))
    back.arrive()
    assert back.photographs == VIEWS and len(back.session.history) == 3
    np.testing.assert_array_equal(back.session.snapshot.views.own, visit.session.snapshot.views.own)


def test_a_panel_is_one_function_and_is_drawn_only_when_what_it_depends_on_changes(monkeypatch):
    drawn = []

    def counter(layout, model):
        layout.drawing(lambda model: (model.player.cursor,), lambda model: drawn.append(model.player.cursor))

    monkeypatch.setattr("viewimit.app.page.page.PANELS", [*PANELS, counter])
    visit = Visit(Camera(), settings=Settings.paper())
    visit.tick(40)
    visit.act("step")
    visit.tick(40)
    assert drawn == [0, 1]

"""The process of the camera images answers as eyes in this process would, session by session; its loss is told."""

import io
import os
import threading
import time

import numpy as np
import pytest
from PIL import Image
from viewimit.app.jobs.camera_images import CameraLost, CameraProcess, eyes_beside
from viewimit.app.jobs.child import MOST_SCENES, answer_looks
from waiting import wait_until

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import extended, load_scene


class OddEyes:
    """own_images tells what was looked at before; demo_images does as it is told."""

    made = 0

    def __init__(self, scene):
        OddEyes.made += 1
        self.scene, self.number, self.theta = scene, OddEyes.made, {}
        self.pictures = {view: np.zeros((4, 8, 3), np.uint8) for view in "lrLR"}

    def own_images(self, theta):
        before, self.theta = self.theta["LR"], self.theta | {"LR": theta}
        return self.scene, self.number, before

    def demo_images(self, wish):
        if wish == "refuse":
            raise ValueError("it cannot be")
        if wish == "fail":
            raise ZeroDivisionError("a fault")
        if wish == "die":
            os._exit(1)
        time.sleep(wish)


def odd_work(connection):
    answer_looks(connection, OddEyes, 0.3)


@pytest.fixture
def camera():
    process = CameraProcess(odd_work)
    yield process
    process.stop()
    assert not process.running


def test_a_look_depends_on_nothing_but_what_it_says_and_few_scenes_are_kept(camera):
    for scene in [*range(MOST_SCENES), MOST_SCENES, MOST_SCENES, 0]:
        images, pictures, theta = camera.look(scene, {"LR": "before", "lr": "there"}, "LR", "now")
        assert images[0] == scene and images[2] == "before" and theta == {"LR": "now", "lr": "there"}
        assert [Image.open(io.BytesIO(picture)).size for picture in pictures] == [(8, 4)] * 2
    assert images[1] == MOST_SCENES + 2  # the first scene was made again, the last one was kept


def test_what_cannot_be_is_refused_and_a_fault_is_told_and_both_are_survived(camera, capfd):
    with pytest.raises(ValueError, match="it cannot be"):
        camera.look("scene", {}, "lr", "refuse")
    with pytest.raises(RuntimeError, match="ZeroDivisionError: a fault"):
        camera.look("scene", {}, "lr", "fail")
    assert camera.look("scene", {}, "lr", 0)[0] is None


def test_it_ends_when_nobody_looks_and_another_begins_with_the_next_look_or_tells_that_it_was_lost(camera):
    camera.look("scene", {}, "lr", 0)
    wait_until(lambda: not camera.running)
    with pytest.raises(CameraLost):
        camera.look("scene", {}, "lr", "die")
    assert camera.look("scene", {}, "lr", 0)[0] is None


def test_stopping_ends_whoever_waits_for_an_answer(camera):
    told = []

    def ask():
        try:
            camera.look("scene", {}, "lr", 600)
        except CameraLost as lost:
            told.append(lost)

    waiting = threading.Thread(target=ask)
    waiting.start()
    wait_until(lambda: camera.running)
    camera.stop()
    waiting.join(5)
    assert len(told) == 1 and not camera.running
    with pytest.raises(CameraLost):
        camera.look("scene", {}, "lr", 0)


def test_no_page_has_pictures_rendered_that_all_others_would_wait_for():
    sized = lambda width: extended(load_scene("panda"), {"head": {"image": [width, 720]}})
    opened = eyes_beside(CameraProcess())
    assert opened("rendered", sized(1280), 10).world.scene == sized(1280)
    with pytest.raises(ValueError, match="1281 × 720 px are too large"):
        opened("rendered", sized(1281), 10)
    assert opened("projected", sized(10_000), 10)


def test_a_session_beside_others_repeats_one_in_this_process_to_the_last_bit():
    pictured = {name: getattr(Settings(), name) for name in ("transfer", "servo")} | {"sensor": "rendered"}
    alone = Session(Settings.paper(**pictured))
    camera = CameraProcess()
    beside = [
        Session(Settings.paper(**pictured, start_deg=start), open_eyes=eyes_beside(camera))
        for start in ((25, -25), (60, -120))
    ]
    for _ in range(3):
        alone.step()
        for session in beside:
            session.step()
    for ours, theirs in zip(alone.history, beside[0].history, strict=True):
        np.testing.assert_array_equal(ours.views.own, theirs.views.own)
        np.testing.assert_array_equal(ours.views.demo, theirs.views.demo)
        np.testing.assert_array_equal(ours.theta, theirs.theta)
    now = beside[0].snapshot
    for view, packed in beside[0].eyes.pictures(now).items():
        assert len(packed) < 20_000
        shown = np.asarray(Image.open(io.BytesIO(packed)), int)
        assert np.abs(shown - alone.eyes.pictures[view].astype(int)).mean() < 3
    camera.stop()

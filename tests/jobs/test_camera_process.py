"""The process of the camera images answers as eyes in this process would, session by session; its loss is told."""

import io
import os
import threading
import time

import numpy as np
import pytest
from PIL import Image
from viewimit.app.jobs.camera_child import answering
from viewimit.app.jobs.camera_images import CameraLost, CameraProcess, SessionEyes
from waiting import stays, wait_until


class OddEyes:
    """own_images tells what was looked at before; settle does as it is told."""

    noise_px = 0.25

    def __init__(self, scene):
        self.scene, self.rest = scene, {"LR": "rest"}
        self.theta = dict(self.rest)
        self.pictures = {view: np.zeros((4, 8, 3), np.uint8) for view in "lrLR"}

    def own_images(self, theta):
        before, self.theta["LR"] = self.theta["LR"], theta
        return self.scene, before

    def settle(self, wish):
        if wish == "refuse":
            raise ValueError("it cannot be")
        if wish == "fail":
            raise ZeroDivisionError("a fault")
        if wish == "die":
            os._exit(1)
        time.sleep(wish)


def odd_work(connection):
    answer = answering(OddEyes)
    while True:
        told = answer(*connection.recv())
        if told is not None:
            connection.send(told)


@pytest.fixture
def camera():
    process = CameraProcess(unused_s=0.1, work=odd_work)
    yield process
    process.stop()
    assert not process.running


def test_sessions_of_one_scene_share_eyes_but_not_what_they_looked_at(camera):
    (one, noise), (other, _) = camera.open("scene"), camera.open("scene")
    assert noise == OddEyes.noise_px
    asked = [(one, "a"), (other, "b"), (one, "c"), (other, "d")]
    answers = [camera.ask(key, "own_images", theta)[0] for key, theta in asked]
    assert answers == [("scene", "rest"), ("scene", "rest"), ("scene", "a"), ("scene", "b")]
    camera.open("another", one)  # in place of what it had
    assert camera.ask(one, "own_images", "e")[0] == ("another", "rest")
    assert camera.ask(other, "own_images", "f")[0] == ("scene", "d")
    pictures = camera.ask(other, "own_images", "g")[1]
    assert [Image.open(io.BytesIO(picture)).size for picture in pictures] == [(8, 4)] * 2
    assert camera.ask(other, "settle", 0)[1] == ()


def test_what_cannot_be_is_refused_and_a_fault_is_told_and_both_are_survived(camera, capfd):
    key, _ = camera.open("scene")
    with pytest.raises(ValueError, match="it cannot be"):
        camera.ask(key, "settle", "refuse")
    with pytest.raises(RuntimeError, match="ZeroDivisionError: a fault"):
        camera.ask(key, "settle", "fail")
    assert camera.ask(key, "own_images", "a")[0] == ("scene", "rest")


def test_who_loses_the_process_is_told_and_the_next_begins_another(camera):
    (one, _), (other, _) = camera.open("scene"), camera.open("scene")
    with pytest.raises(CameraLost):
        camera.ask(one, "settle", "die")
    with pytest.raises(CameraLost):
        camera.ask(other, "own_images", "a")
    key, _ = camera.open("scene", one)
    assert camera.ask(key, "own_images", "b")[0] == ("scene", "rest")


def test_it_ends_when_nobody_looks_any_more_and_only_then(camera):
    (one, _), (other, _) = camera.open("scene"), camera.open("scene")
    camera.close(one)
    stays(lambda: camera.running, 0.3)  # three times as long as without anybody
    camera.close(other)
    wait_until(lambda: not camera.running)
    with pytest.raises(CameraLost):
        camera.ask(other, "own_images", "a")
    camera.open("scene")
    assert camera.running


def test_stopping_ends_whoever_waits_for_an_answer(camera):
    key, _ = camera.open("scene")
    told = []

    def ask():
        try:
            camera.ask(key, "settle", 600)
        except CameraLost as lost:
            told.append(lost)

    waiting = threading.Thread(target=ask)
    waiting.start()
    time.sleep(0.1)
    camera.stop()
    waiting.join(5)
    assert len(told) == 1 and not camera.running
    with pytest.raises(CameraLost):
        camera.open("scene")


def test_a_session_beside_others_repeats_one_in_this_process_to_the_last_bit():
    from viewimit.loop.session import Session
    from viewimit.loop.settings import Settings

    pictured = {name: getattr(Settings(), name) for name in ("transfer", "servo")} | {"sensor": "rendered"}
    alone = Session(Settings.paper(**pictured))
    camera = CameraProcess()
    beside = [
        Session(Settings.paper(**pictured, start_deg=start), open_eyes=SessionEyes(camera))
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

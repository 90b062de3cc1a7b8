"""From world to world the browser's 3-D scene becomes what a fresh page's is."""

import contextlib
import io
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import viser
from page_fakes import quiet_model
from protocol import Client
from quiet_client import quiet_client
from viewed_scene import ViewedScene
from viewimit.app.commands import COMMANDS
from viewimit.app.model.choices import PRESETS
from viewimit.app.model.queue import CommandQueue
from viewimit.app.scene.arms import share_meshes
from viewimit.app.scene.moment import Moment
from viewimit.app.scene.scene3d import Scene3D, share_light
from viewimit.app.viser_private import send_at_once
from waiting import wait_until

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene_geometry import cameras_of, on_plate


class Viewer(Client):
    """A tab that keeps what its 3-D scene is."""

    def __init__(self, url):
        self.scene = ViewedScene()
        super().__init__(url)

    def _take(self, message):
        super()._take(message)
        self.scene.take(message)


class Stage:
    """A scene on a viser of its own, with a viewer of it."""

    def __init__(self, server):
        before = set(server.get_clients())
        self.viewer = Viewer(f"http://127.0.0.1:{server.get_port()}")
        (client_id,) = wait_until(lambda: set(server.get_clients()) - before)
        self._client = server.get_clients()[client_id]
        send_at_once(self._client)
        self._scene = Scene3D(self._client, CommandQueue(COMMANDS), partial(share_meshes, server))
        self._shown = 0

    def show(self, model, theta_opponent=None) -> dict:
        """What is seen of this model's world, once all has arrived."""
        with self._client.atomic():
            self._scene.build(model.session.world)
            self._scene.arms.draw(*model.display.poses(0.0), theta_opponent)
            model.refresh(0.0)
            self._scene.show(model)
        self._shown += 1
        self._client.gui.add_html(f"{self._shown}")
        wait_until(lambda: f"{self._shown}" in self.viewer.html.values())
        return self.viewer.scene.nodes


@contextlib.contextmanager
def serving():
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        send_at_once(server)
        share_light(server)
        yield server
        server.stop()


@pytest.fixture(scope="module")
def server(models):
    """Where every robot has been shown."""
    with serving() as server:
        for model in models:
            Stage(server).show(model)
        yield server


@pytest.fixture(scope="module")
def models():
    """A page's model of each world that presets lead to."""
    of = {}
    for preset in PRESETS:
        settings = preset.settings
        if settings.sensor == "projected":
            of.setdefault((settings.scene, settings.points, settings.joints), settings)
    return [quiet_model(settings)[0] for settings in of.values()]


def assert_same(seen, fresh):
    assert seen.keys() == fresh.keys()
    for name, node in seen.items():
        np.testing.assert_allclose(node.position, fresh[name].position, atol=1e-9, err_msg=name)
        np.testing.assert_allclose(node.wxyz, fresh[name].wxyz, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("apart", [1, *(pytest.param(k, marks=pytest.mark.slow) for k in range(2, 10))])
def test_every_world_after_another_is_seen_as_in_a_fresh_page(server, models, apart):
    """After the one that stands so many places before it in the list of presets."""
    fresh = [Stage(server).show(model) for model in models]
    stage = Stage(server)
    for k in range(len(models)):
        stage.show(models[k - apart])
        assert_same(stage.show(models[k]), fresh[k])


def test_points_on_the_plates_follow_a_demonstrator_that_moves():
    session = Session(Settings.paper(servo="gradient-retuned"))
    moment = Moment(quiet_client(1), SimpleNamespace(keep=lambda handle: handle), session.world, dark=False)
    for _ in range(2):
        for _ in range(2):  # it rests in between
            session.step()
            views = session.snapshot.views
            seen = np.concatenate([views.demo, views.own], 1).reshape(-1, 4, 2).swapaxes(0, 1)
            expected = [
                on_plate(camera, image, session.scene.size) for camera, image in zip(cameras_of(session.world), seen)
            ]
            np.testing.assert_array_equal(moment.on_plates(session.snapshot)[0], expected)
        session.pose(session.snapshot.theta_demo + 0.1)

"""The default camera: where it stands, and when it is put there anew."""

from types import SimpleNamespace

import numpy as np
import pytest
from viewimit.app.scene.scene3d import BEFORE, DefaultView

from viewimit.simulation.scene_geometry import BELOW, FOV, default_view, fit_view

LANDMARKS = np.random.default_rng(0).uniform((-0.5, -1.0, 0.0), (1.5, 1.0, 1.5), (50, 3))


@pytest.fixture
def camera():
    return SimpleNamespace(image_width=552, image_height=720, position=np.ones(3), look_at=np.zeros(3), fov=1.0)


@pytest.fixture
def view(camera):
    view = DefaultView(SimpleNamespace(camera=camera))
    view.follow(lambda: LANDMARKS)
    return view


@pytest.mark.parametrize("aspect", [0.5, 0.77, 1.0, 2.0])
def test_all_landmarks_are_in_sight_above_what_is_covered(aspect):
    position, target = fit_view(LANDMARKS, aspect, BELOW)
    right, down, depth = ((LANDMARKS - position) @ default_view()).T
    assert np.allclose(np.cross(target - position, default_view()[:, 2]), 0, atol=1e-9)
    x, y = (value / (depth * np.tan(FOV / 2)) for value in (right, down))
    assert (np.abs(x) <= aspect).all() and (y >= -1).all() and (y <= 1 - 2 * BELOW).all()


def test_a_camera_that_the_visitor_has_moved_stays(view, camera):
    camera.position = camera.position + 0.1
    moved = camera.position
    camera.image_width = 300
    view.follow(lambda: LANDMARKS)
    assert camera.position is moved
    view.fit(LANDMARKS)
    assert camera.position is not moved


@pytest.mark.parametrize("before", BEFORE)
def test_a_camera_that_nobody_has_put_anywhere_is_fitted_whenever_the_browser_tells_of_it(camera, before):
    camera.position = np.array([-5.0, 0.0, 0.0])  # three.js's own, as the page was built
    view = DefaultView(SimpleNamespace(camera=camera))
    camera.position = np.array(before)
    view.follow(lambda: LANDMARKS)
    put = camera.position
    np.testing.assert_allclose(put, fit_view(LANDMARKS, 552 / 720, BELOW)[0])
    assert not view.camera_is_default
    camera.position = np.array(before)  # the browser had no camera yet that could be put there
    assert view.camera_is_default
    view.follow(lambda: LANDMARKS)
    np.testing.assert_allclose(camera.position, put)
    camera.position = put + 0.1
    assert not view.camera_is_default
    view.follow(lambda: LANDMARKS)
    np.testing.assert_allclose(camera.position, put + 0.1)

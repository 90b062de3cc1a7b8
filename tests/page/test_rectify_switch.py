"""The page says when images are rectified, draws the head as it is, and shows what is lost without rectification."""

import numpy as np
from quiet_page import QuietPage

from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene
from viewimit.simulation.scene_geometry import PLATE, corners, on_plate
from viewimit.simulation.world import World


def test_toed_in_cameras_are_rectified_until_the_visitor_says_not_to():
    page = QuietPage(Settings())
    assert "then rectified" not in page.shown and page.widget("Rectify").value is True
    page.choose("Preset", "Eyes turned inwards, rectified")
    page.page.queue.call("step")
    page.tick(1.0)
    session = page.page.model.session
    E = session.snapshot.E
    assert "then rectified" in page.shown and "rectification: matched points get equal rows" in page.shown
    page.choose("Rectify", False)
    page.tick(1.0)
    assert "then rectified" not in page.shown and session.settings.rectify == "off"
    assert session.snapshot.rectification is None and session.snapshot.E != E
    page.choose("Preset", "Eyes turned inwards")
    assert page.widget("Rectify").value is False
    page.choose("Rectify", True)
    assert session.snapshot.rectification is not None


def test_what_is_drawn_on_a_plate_is_where_the_ray_of_its_image_meets_it():
    world = World(load_scene("panda-toed"))
    points = world.points_world(np.radians([45.0, -90.0]), world.T_world_own)
    for camera in world.own_cameras:
        image, _ = camera.project(points.T)
        eye, ahead = camera.T_world_camera[:3, 3], camera.T_world_camera[:3, 2]
        away = points - eye
        np.testing.assert_allclose(on_plate(camera, image.T), eye + PLATE * away / (away @ ahead)[:, None], atol=1e-12)
    left, right = (on_plate(camera, corners(camera)).mean(0) for camera in world.own_cameras)
    eyes = [camera.T_world_camera[:3, 3] for camera in world.own_cameras]
    assert np.linalg.norm(right - left) < np.linalg.norm(eyes[1] - eyes[0])  # plates turn towards each other

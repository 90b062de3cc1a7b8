"""What a click in the 3-D scene means."""

import numpy as np
import pytest
from viewimit.app.scene.scene3d import REACH, picked

FOV = np.radians(36.0)
AHEAD = np.array([0.0, 1.0, 0.0])
SIZE = 0.02


def clicked(points, sideways=0.0, surface=np.inf):
    """A click this far from the middle, of the canvas's height, by an eye at the origin that looks along y."""
    ray = AHEAD + [2 * np.tan(FOV / 2) * sideways, 0, 0]
    return picked(np.array(points, float), np.full(len(points), SIZE), np.zeros(3), ray, FOV, surface)


def test_the_nearest_to_the_click_is_meant():
    points = [(0.1, 5, 0), (-0.05, 5, 0), (0.0, 5, 0.08)]
    assert clicked(points) == 1


def test_of_points_that_overlap_under_the_click_the_one_nearer_to_the_eye_is_meant():
    points = [(0.0, 5, 0), (0.01, 3, 0)]
    assert clicked(points) == 1 and clicked(points[::-1]) == 0


@pytest.mark.parametrize("depth", [1.0, 5.0, 20.0])
def test_a_fingertip_is_as_wide_near_and_far(depth):
    edge = REACH + SIZE / (2 * depth * np.tan(FOV / 2))
    assert clicked([(0, depth, 0)], 0.97 * edge) == 0
    assert clicked([(0, depth, 0)], 1.03 * edge) is None


def test_what_a_surface_hides_is_not_meant_but_what_is_on_it_is():
    points = [(0.0, 5, 0), (0.0, 3, 0)]
    assert clicked(points[:1], surface=3.0) is None
    assert clicked(points, surface=3.0) == 1 == clicked(points, surface=3.0 - 0.9 * SIZE)
    assert clicked(points, surface=3.0 - 1.1 * SIZE) is None

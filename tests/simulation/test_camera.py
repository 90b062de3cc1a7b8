"""Cameras against OpenCV, and triangulation as the inverse of projection."""

import numpy as np
import pytest

from viewimit.geometry.rigid import look_rotation, rigid_transform, rotation_from_rpy
from viewimit.simulation.camera import Camera, Cameras, StereoHead, triangulate

HEAD = StereoHead((0.1, -0.2, 1.7), 0.6, 640, 240, 256, (320, 120))


def scattered(rng, count=200):
    return rng.normal(size=(3, count)) * 0.5 + np.array([[2.0], [-0.7], [1.0]])


def test_projection_is_opencvs():
    cv2 = pytest.importorskip("cv2")
    rng = np.random.default_rng(0)
    T = rigid_transform(look_rotation([2, -0.7, -0.7]) @ rotation_from_rpy([0.1, -0.2, 0.3]), [0.1, 0.2, 1.7])
    camera = Camera(640, 240, 241.5, (310, 125), T)
    points = scattered(rng)
    image, _ = camera.project(points)
    T_camera_world = np.linalg.inv(T)
    matrix = np.array([[241.5, 0, 310], [0, 241.5, 125], [0, 0, 1.0]])
    rotation, _ = cv2.Rodrigues(T_camera_world[:3, :3])
    expected, _ = cv2.projectPoints(points.T.copy(), rotation, T_camera_world[:3, 3], matrix, None)
    np.testing.assert_allclose(image.T, expected[:, 0], atol=1e-8)


def test_points_in_a_moved_frame_project_as_their_world_points():
    camera, _ = HEAD.gaze([2, -0.7, 1])
    T = rigid_transform(rotation_from_rpy([0.3, 0.2, 1]), [1, 2, 3])
    points = scattered(np.random.default_rng(1)).reshape(3, 4, 50)
    local = np.einsum("ij,jab->iab", T[:3, :3].T, points - T[:3, 3].reshape(3, 1, 1))
    for found, expected in zip(camera.project(local, T), camera.project(points)):
        np.testing.assert_allclose(found, expected, atol=1e-9)


def test_visible_means_in_front_and_inside_the_image():
    camera = Camera(640, 240, 256, (320, 120), np.eye(4))
    at = {
        (0, 0, 1): True,
        (0, 0, -1): False,  # behind, though its image is inside
        (1.24, 0, 1): True,
        (1.26, 0, 1): False,
        (-1.26, 0, 1): False,
        (0, 0.46, 1): True,
        (0, 0.48, 1): False,
        (0, -0.48, 1): False,
        (0, 0, 0): False,
    }
    _, visible = camera.project(np.array(list(at), float).T)
    assert visible.tolist() == list(at.values())


def test_several_cameras_at_once_see_what_each_sees():
    cameras = HEAD.gaze([2, -0.7, 1])
    points = scattered(np.random.default_rng(3), 400)
    points[:, ::7] *= 3  # some beyond the images, some behind the cameras
    images, visible = Cameras(cameras).project(points.T)
    assert 0.2 < visible.mean() < 0.9
    for camera, image, seen in zip(cameras, images, visible):
        expected, expected_seen = camera.project(points)
        np.testing.assert_allclose(image, expected.T, rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(seen, expected_seen)


def test_what_is_too_near_or_behind_is_set_back_on_its_way_to_the_image():
    camera = Camera(640, 240, 256, (320, 120), np.eye(4))
    points = np.array([[0.1, 0, 0.2], [0.1, 0, 0.01], [0.1, 0, -1.0]])
    images, depth = Cameras([camera]).images(points, nearest=0.05)
    np.testing.assert_allclose(depth, [[0.2, 0.05, 0.05]])
    np.testing.assert_allclose(images[0, :, 0], 320 + 256 * 0.1 / depth[0])


@pytest.mark.parametrize("verged", [False, True])
def test_triangulation_inverts_projection(verged):
    head = StereoHead((0.1, -0.2, 1.7), 0.6, 640, 240, 256, (320, 120), verged)
    left, right = head.gaze([2, -0.7, 1])
    points = scattered(np.random.default_rng(2))
    images = np.concatenate([left.project(points)[0], right.project(points)[0]]).T
    np.testing.assert_allclose(triangulate(left, right, images), points.T, atol=1e-9)


def test_the_head_turns_about_its_midpoint_with_level_eyes():
    target = np.array([1.0, 0.9, 0.8])
    left, right = HEAD.gaze(target)
    eyes = left.T_world_camera[:3, 3], right.T_world_camera[:3, 3]
    np.testing.assert_allclose(np.mean(eyes, 0), HEAD.position, atol=1e-14)
    assert np.linalg.norm(eyes[1] - eyes[0]) == pytest.approx(0.6)
    assert eyes[0][2] == pytest.approx(eyes[1][2])
    x_of_left_eye = left.T_world_camera[:3, 0]
    np.testing.assert_allclose((eyes[1] - eyes[0]) / 0.6, x_of_left_eye, atol=1e-12)  # the right eye is at the right


def test_parallel_axes_have_no_vertical_disparity_and_verged_ones_meet_at_the_target():
    target = np.array([1.0, 0.9, 0.8])
    points = scattered(np.random.default_rng(3))
    left, right = HEAD.gaze(target)
    np.testing.assert_allclose(left.project(points)[0][1], right.project(points)[0][1], atol=1e-9)
    verged = StereoHead((0.1, -0.2, 1.7), 0.6, 640, 240, 256, (320, 120), True)
    for camera in verged.gaze(target):
        np.testing.assert_allclose(camera.project(target[:, None])[0][:, 0], (320, 120), atol=1e-9)

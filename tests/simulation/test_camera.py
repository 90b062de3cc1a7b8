"""Cameras against OpenCV, and triangulation as the inverse of projection."""

import numpy as np
import pytest

from viewimit.geometry.distortion import RadialDistortion
from viewimit.geometry.rigid import look_rotation, rigid_transform, rotation_from_rpy
from viewimit.simulation.camera import Camera, Cameras, Lens, StereoHead, triangulate

LENS = Lens((256, 256), (320, 120))
OBLONG = Lens((241.5, 263.0), (310, 125))
BARREL, PINCUSHION = (Lens((256, 250), (310, 125), RadialDistortion(*k)) for k in ((-0.12, 0.02), (0.1, 0.03)))
HEAD = StereoHead((0.1, -0.2, 1.7), 0.6, 640, 240, LENS, LENS)


def scattered(rng, count=200):
    return rng.normal(size=(3, count)) * 0.5 + np.array([[2.0], [-0.7], [1.0]])


@pytest.mark.parametrize("lens", [LENS, OBLONG, BARREL, PINCUSHION])
def test_projection_is_opencvs(lens):
    cv2 = pytest.importorskip("cv2")
    rng = np.random.default_rng(0)
    T = rigid_transform(look_rotation([2, -0.7, -0.7]) @ rotation_from_rpy([0.1, -0.2, 0.3]), [0.1, 0.2, 1.7])
    camera, points = Camera(640, 240, lens, T), scattered(rng)
    image, visible = camera.project(points)
    assert visible.mean() > 0.3
    T_camera_world = np.linalg.inv(T)
    (fx, fy), (cx, cy) = lens.focal, lens.centre
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    rotation, _ = cv2.Rodrigues(T_camera_world[:3, :3])
    distortion = np.array([lens.distortion.k1, lens.distortion.k2, 0, 0])
    expected, _ = cv2.projectPoints(points.T.copy(), rotation, T_camera_world[:3, 3], matrix, distortion)
    np.testing.assert_allclose(image.T[visible], expected[visible, 0], atol=1e-8)


@pytest.mark.parametrize("lens", [LENS, OBLONG, BARREL, PINCUSHION])
def test_a_ray_through_an_image_point_meets_its_point(lens):
    camera = Camera(640, 240, lens, rigid_transform(look_rotation([2, -0.7, -0.7]), [0.1, 0.2, 1.7]))
    points = scattered(np.random.default_rng(4))
    image, visible = camera.project(points)
    away = points.T - camera.T_world_camera[:3, 3]
    depth = away @ camera.T_world_camera[:3, 2]
    np.testing.assert_allclose(camera.ray(image.T[visible]), (away / depth[:, None])[visible], atol=1e-9)


def test_an_image_rid_of_its_distortion_is_that_of_the_ideal_lens():
    points, T = scattered(np.random.default_rng(5)), HEAD.gaze([2, -0.7, 1])[0].T_world_camera
    for lens in (BARREL, PINCUSHION):
        ideal, visible = Camera(640, 240, Lens(lens.focal, lens.centre), T).project(points)
        rid = Lens(lens.focal, lens.centre, lens.distortion, lens.distortion)
        np.testing.assert_array_equal(Camera(640, 240, rid, T).project(points)[0], ideal)
        image, seen = Camera(640, 240, lens, T).project(points)
        seen &= visible
        found = Lens(lens.focal, lens.centre, lens.distortion).direction(image.T[seen]) * lens.focal + lens.centre
        np.testing.assert_allclose(found, ideal.T[seen], atol=1e-7)


def test_visible_means_in_front_and_inside_the_image():
    camera = Camera(640, 240, LENS, np.eye(4))
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


@pytest.mark.parametrize("lenses", [(LENS, LENS), (LENS, OBLONG), (BARREL, OBLONG), (BARREL, PINCUSHION)])
def test_a_batch_of_cameras_equals_each_camera(lenses):
    cameras = StereoHead((0.1, -0.2, 1.7), 0.6, 640, 240, *lenses, toe_in=0.1).gaze([2, -0.7, 1])
    points = scattered(np.random.default_rng(3), 400)
    points[:, ::7] *= 3  # some beyond the images, some behind the cameras
    images, visible = Cameras(cameras).project(points.T)
    assert 0.2 < visible.mean() < 0.9
    for camera, image, seen in zip(cameras, images, visible):
        expected, expected_seen = camera.project(points)
        np.testing.assert_allclose(image, expected.T, rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(seen, expected_seen)


@pytest.mark.parametrize("verged", [False, True])
def test_triangulation_inverts_projection(verged):
    head = StereoHead((0.1, -0.2, 1.7), 0.6, 640, 240, OBLONG, BARREL, verged)
    left, right = head.gaze([2, -0.7, 1])
    points = scattered(np.random.default_rng(2))
    (left_image, seen_left), (right_image, seen_right) = left.project(points), right.project(points)
    images, seen = np.concatenate([left_image, right_image]).T, seen_left & seen_right
    assert seen.mean() > 0.4
    np.testing.assert_allclose(triangulate(left, right, images[seen]), points.T[seen], atol=1e-8)


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
    verged = StereoHead((0.1, -0.2, 1.7), 0.6, 640, 240, LENS, LENS, True)
    for camera in verged.gaze(target):
        np.testing.assert_allclose(camera.project(target[:, None])[0][:, 0], (320, 120), atol=1e-9)

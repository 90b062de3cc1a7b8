"""Heads that are not two equal, parallel cameras, what they see of scattered points, and their F from the cameras."""

import numpy as np

from viewimit.simulation.camera import Lens, StereoHead

EQUAL = Lens((256, 256), (320, 120))
UNLIKE = Lens((240, 262), (312, 126)), Lens((280, 271), (331, 109))


def head(toe_in_deg, left=EQUAL, right=EQUAL):
    return StereoHead((0, 0, 1.7), 0.6, 640, 240, left, right, toe_in=np.radians(toe_in_deg))


def matches(stereo, rng, count=60, noise_px=0.0):
    """(M, 2) px each, of points about what the head looks at that both cameras see; and the two cameras."""
    target = np.array([1.6, 0.3, 1.0])
    cameras = stereo.gaze(target)
    points = target[:, None] + rng.uniform(-0.5, 0.5, (3, count))
    (left, seen_left), (right, seen_right) = (camera.project(points) for camera in cameras)
    seen = seen_left & seen_right
    left, right = (image.T[seen] + noise_px * rng.standard_normal((seen.sum(), 2)) for image in (left, right))
    return left, right, cameras


def fundamental_of(cameras):
    """F = K'⁻ᵀ [t]× R K⁻¹ of two known cameras (Hartley and Zisserman, Eq. 9.2)."""
    left, right = cameras
    T = np.linalg.inv(right.T_world_camera) @ left.T_world_camera
    x, y, z = T[:3, 3]
    K_left, K_right = (
        np.array([[lens.focal[0], 0, lens.centre[0]], [0, lens.focal[1], lens.centre[1]], [0, 0, 1]])
        for lens in (left.lens, right.lens)
    )
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.linalg.inv(K_right).T @ cross @ T[:3, :3] @ np.linalg.inv(K_left)


def up_to_scale(F):
    F = F / np.linalg.norm(F)
    return F * np.sign(F.ravel()[np.argmax(np.abs(F))])

"""The perspective counterpart of E, as one would write it with OpenCV, posture by posture.

F of ([l], [r]) by the eight-point algorithm gives two cameras up to a projective change of space; the demonstrator's
points are triangulated with them, the views [L] and [R] are resected from the learner's own points, and what they
show of the triangulated points is the recovered image. Pinhole views of equal bodies in equal postures agree
exactly. Elsewhere this E is not the affine one, so that only its time can be compared with ours.
"""

import importlib.util

import numpy as np
from numpy.typing import NDArray

from ...simulation.world import World
from .baselines import own_image

MIN_POINTS = 8  # of the eight-point algorithm; the resection of a view needs six


def why_not(points: int) -> str | None:
    """Why this baseline cannot be run here with so many points, in one line. None if it can."""
    if importlib.util.find_spec("cv2") is None:
        return "OpenCV is not installed: pip install 'viewimit[opencv]'"
    if points < MIN_POINTS:
        return f"OpenCV is left out: its eight-point algorithm needs at least {MIN_POINTS} points, got {points}"
    return None


def loop(world: World, demo: NDArray, postures: NDArray) -> NDArray:
    """E of Eq. (6), posture by posture. demo: (N, 4) px; postures: (G, m) rad → (G,) px²."""
    import cv2

    cv2.setNumThreads(1)  # as all that it is compared with
    return np.array([conflict(demo, own_image(world, posture)) for posture in postures])


def conflict(demo: NDArray, own: NDArray) -> float:
    """E of one posture. demo, own: (N, 4) px → px²; NaN where OpenCV finds no F."""
    import cv2

    l, r = demo[:, :2], demo[:, 2:]
    F, _ = cv2.findFundamentalMat(l, r, cv2.FM_8POINT)
    if F is None:
        return np.nan
    x, y, z = epipole = np.linalg.svd(F.T)[2][-1]  # e' in [r]: Fᵀ e' = 0
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    P_r = np.column_stack([cross @ F, epipole])  # beside [I | 0]: Hartley and Zisserman, Result 9.14
    X = cv2.triangulatePoints(np.eye(3, 4), P_r, l.T, r.T).T
    # Projective points have any scale and any basis. With orthonormal columns they suit the least squares that follow,
    # as Hartley's normalisation makes image points do.
    X = np.linalg.qr(X / np.linalg.norm(X, axis=1, keepdims=True))[0]
    recovered = np.hstack([_project(_resect(X, image), X) for image in (own[:, :2], own[:, 2:])])
    return float(((own - recovered) ** 2).sum() / (2 * len(demo)))


def _resect(X: NDArray, image: NDArray) -> NDArray:
    """The camera that sees X as `image`, by the direct linear transformation. X: (N, 4); image: (N, 2) px → (3, 4)."""
    centre = image.mean(0)
    scale = np.sqrt(2) / np.linalg.norm(image - centre, axis=1).mean()
    x, y = (scale * (image - centre)).T[..., None]
    nothing = np.zeros_like(X)
    rows = np.vstack([np.hstack([X, nothing, -x * X]), np.hstack([nothing, X, -y * X])])
    P = np.linalg.svd(rows)[2][-1].reshape(3, 4)
    return np.vstack([P[:2] / scale + np.outer(centre, P[2]), P[2]])


def _project(P: NDArray, X: NDArray) -> NDArray:
    """P: (3, 4); X: (N, 4) → (N, 2) px."""
    x = X @ P.T
    return x[:, :2] / x[:, 2:]

"""Independent implementations of E, with which the fast path is timed and compared: `python studies/baselines.py`.

The paper's E in plain numpy uses only the scene's joints, points and cameras, nothing of `geometry` or `estimation`.
`loop` goes from posture to posture, `batch` takes all at once; `conflict` and `conflicts` do so with given images.

`opencv_conflict` is the perspective counterpart of E, as one would write it with OpenCV. F of ([l], [r]) by the
eight-point algorithm gives two cameras up to a projective map of space. The demonstrator's points are triangulated with
them, the views [L] and [R] are resected from the learner's own points, and the triangulated points are projected into
them. Pinhole views of equal bodies in equal postures agree exactly. Elsewhere this E differs from the affine one, so
only its time can be compared.
"""

from viewimit.geometry import limit_blas_threads

limit_blas_threads()  # before numpy is loaded: CPU times count all threads

import argparse
import importlib.util

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.landscape import grid_axes
from viewimit.experiments.bench.speed import (
    E_of_images,
    call_s,
    median_s,
    over_range,
    row,
    scene_demonstrator,
)
from viewimit.simulation.camera import Camera
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

LOOP_SHARE = 10  # loops are timed on every tenth posture in a seeded order, or on all with --full-loop
MIN_OPENCV_POINTS = 8  # of the eight-point algorithm; the resection of a view needs six


def loop(world: World, demo: NDArray[np.float64], postures: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute E of Eq. (6) posture by posture. demo: (N, 4) px; postures: (G, m) rad → (G,) px²."""
    return np.array([conflict(demo, own_image(world, posture)) for posture in postures])


def batch(
    world: World, demo: NDArray[np.float64], postures: NDArray[np.float64], with_condition: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Compute E and, if asked, cond(A) of all postures at once. demo: (N, 4) px; postures: (G, m) rad → (G,), (G,)."""
    return conflicts(demo, _own_images(world, postures), with_condition)


def conflicts(
    demo: NDArray[np.float64], own: NDArray[np.float64], with_condition: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Compute E and, if asked, cond(A). demo: (N, 4) px; own: (G, N, 4) px → (G,) px², (G,).

    cond(A) comes from the eigenvalues of AᵀA, which cost less than singular values.
    """
    l, r, L, R = demo[:, :2], demo[:, 2:], own[..., :2], own[..., 2:]
    A, B = np.zeros((len(own), 5, 4)), np.zeros((len(own), 5, 6))
    for k, (d, o) in enumerate(((l, L), (r, L), (l, R), (r, R))):
        f, f33 = _fundamentals(np.broadcast_to(d, o.shape), o)
        to_R, from_r = 2 * (k // 2), 3 * (k % 2)
        A[:, k, to_R : to_R + 2] = f[:, 2:]
        B[:, k, from_r : from_r + 2], B[:, k, from_r + 2] = f[:, :2], f33
    A[:, 4], B[:, 4, 5] = _fundamentals(L, R)
    A_transposed = np.swapaxes(A, 1, 2)
    normal = A_transposed @ A
    c = np.column_stack([l, np.ones(len(l)), r, np.ones(len(r))])
    recovered = c @ np.swapaxes(np.linalg.solve(normal, -A_transposed @ B), 1, 2)
    E = ((own - recovered) ** 2).sum((1, 2)) / (2 * len(demo))
    if not with_condition:
        return E, None
    values = np.linalg.eigvalsh(normal)
    return E, np.sqrt(values[:, -1] / values[:, 0])


def conflict(demo: NDArray[np.float64], own: NDArray[np.float64]) -> float:
    """Compute E of one posture. demo, own: (N, 4) px → px²."""
    l, r, L, R = demo[:, :2], demo[:, 2:], own[:, :2], own[:, 2:]
    A, B = np.zeros((5, 4)), np.zeros((5, 6))
    for k, (d, o) in enumerate(((l, L), (r, L), (l, R), (r, R))):
        f, f33 = _fundamental(d, o)
        to_R, from_r = 2 * (k // 2), 3 * (k % 2)
        A[k, to_R : to_R + 2] = f[2:]
        B[k, from_r : from_r + 2], B[k, from_r + 2] = f[:2], f33
    A[4], B[4, 5] = _fundamental(L, R)
    c = np.column_stack([l, np.ones(len(l)), r, np.ones(len(r))])
    recovered = np.linalg.lstsq(A, -B @ c.T, rcond=None)[0].T
    return ((own - recovered) ** 2).sum() / (2 * len(demo))


def _fundamental(p: NDArray, q: NDArray) -> tuple[NDArray, float]:
    """Eqs. (2), (3). p, q: (N, 2) px → f: (4,), f33."""
    u = np.hstack([p, q])
    centre = u.mean(0)
    _, vectors = np.linalg.eigh((u - centre).T @ (u - centre))
    return vectors[:, 0], -float(centre @ vectors[:, 0])


def _fundamentals(p: NDArray, q: NDArray) -> tuple[NDArray, NDArray]:
    """Eqs. (2), (3). p, q: (G, N, 2) px → f: (G, 4), f33: (G,)."""
    u = np.concatenate([p, q], -1)
    centre = u.mean(1)
    u = u - centre[:, None]
    _, vectors = np.linalg.eigh(np.swapaxes(u, 1, 2) @ u)
    f = vectors[:, :, 0]
    return f, -(centre * f).sum(1)


def own_image(world: World, posture: NDArray[np.float64]) -> NDArray[np.float64]:
    """Project the learner's points. posture: (m,) rad → (N, 4) px in [L, R]."""
    angles = np.radians(world.scene.posture_deg)
    angles[world.scene.moving] = posture
    T = world.T_world_own
    frames = [T]
    for joint, angle in zip(world.robot.joints, angles):
        T = T @ joint.T_parent_joint @ _turns(joint.axis, angle)
        frames.append(T)
    T_world_links = np.array(frames)[world.body.link]
    points = (T_world_links[:, :3, :3] @ world.body.local[:, :, None])[:, :, 0] + T_world_links[:, :3, 3]
    return np.hstack([_project(camera, points) for camera in world.own_cameras])


def _own_images(world: World, postures: NDArray) -> NDArray:
    """postures: (G, m) rad → (G, N, 4) px in [L, R]."""
    angles = np.tile(np.radians(world.scene.posture_deg), (len(postures), 1))
    angles[:, world.scene.moving] = postures
    T = np.broadcast_to(world.T_world_own, (len(postures), 4, 4))
    points = np.empty((len(postures), len(world.body), 3))
    for link in range(len(world.robot.joints) + 1):
        if link > 0:
            joint = world.robot.joints[link - 1]
            T = T @ (joint.T_parent_joint @ _turns(joint.axis, angles[:, link - 1]))
        on_link = world.body.link == link
        if on_link.any():
            points[:, on_link] = world.body.local[on_link] @ np.swapaxes(T[:, :3, :3], 1, 2) + T[:, None, :3, 3]
    return np.concatenate([_project(camera, points) for camera in world.own_cameras], -1)


def _turns(axis: NDArray, angle) -> NDArray:
    """Rodrigues' formula. axis: (3,); angle: (...) rad → (..., 4, 4)."""
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    T = np.zeros(np.shape(angle) + (4, 4))
    sin, cos = np.sin(angle)[..., None, None], np.cos(angle)[..., None, None]
    T[..., :3, :3] = np.eye(3) + sin * K + (1 - cos) * (K @ K)
    T[..., 3, 3] = 1
    return T


def _project(camera: Camera, points: NDArray) -> NDArray:
    """points: (..., 3) m in the world → (..., 2) px."""
    in_camera = (points - camera.T_world_camera[:3, 3]) @ camera.T_world_camera[:3, :3]
    on_plane = in_camera[..., :2] / in_camera[..., 2:]
    if camera.lens.is_distorted:
        on_plane = on_plane * camera.lens.stretch((on_plane**2).sum(-1, keepdims=True))
    return np.array(camera.lens.focal) * on_plane + np.array(camera.lens.centre)


def opencv_unavailable(points: int) -> str | None:
    """Return in a line why the OpenCV baseline cannot run with this number of points; None if it can."""
    if importlib.util.find_spec("cv2") is None:
        return "OpenCV is not installed: pip install 'viewimit[opencv]'"
    if points < MIN_OPENCV_POINTS:
        return f"OpenCV is left out: its eight-point algorithm needs at least {MIN_OPENCV_POINTS} points, got {points}"
    return None


def opencv_loop(world: World, demo: NDArray[np.float64], postures: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute E posture by posture. demo: (N, 4) px; postures: (G, m) rad → (G,) px²."""
    import cv2

    cv2.setNumThreads(1)  # as the other baselines
    return np.array([opencv_conflict(demo, own_image(world, posture)) for posture in postures])


def opencv_conflict(demo: NDArray[np.float64], own: NDArray[np.float64]) -> float:
    """Compute E of one posture. demo, own: (N, 4) px → px²; NaN where OpenCV finds no F."""
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
    recovered = np.hstack([_project_homogeneous(_resect(X, image), X) for image in (own[:, :2], own[:, 2:])])
    return float(((own - recovered) ** 2).sum() / (2 * len(demo)))


def _resect(X: NDArray, image: NDArray) -> NDArray:
    """Resect a camera by the direct linear transformation. X: (N, 4); image: (N, 2) px → (3, 4)."""
    centre = image.mean(0)
    scale = np.sqrt(2) / np.linalg.norm(image - centre, axis=1).mean()
    x, y = (scale * (image - centre)).T[..., None]
    nothing = np.zeros_like(X)
    rows = np.vstack([np.hstack([X, nothing, -x * X]), np.hstack([nothing, X, -y * X])])
    P = np.linalg.svd(rows)[2][-1].reshape(3, 4)
    return np.vstack([P[:2] / scale + np.outer(centre, P[2]), P[2]])


def _project_homogeneous(P: NDArray, X: NDArray) -> NDArray:
    """P: (3, 4); X: (N, 4) → (N, 2) px."""
    x = X @ P.T
    return x[:, :2] / x[:, 2:]


def main(words: list[str] | None = None) -> None:
    """Time E over the range and at one posture beside its baselines, and print the largest relative differences."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--scene", default="panda")
    parser.add_argument("--n-points", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--full-loop", action="store_true", help="time loops on every posture, not a tenth")
    asked = parser.parse_args(words)
    world = World(load_scene(asked.scene), asked.n_points)
    demo, postures = (
        scene_demonstrator(world),
        np.stack(np.meshgrid(*grid_axes(world), indexing="ij"), -1).reshape(-1, 2),
    )
    sample = np.random.default_rng(asked.seed).permutation(len(postures))
    sample = sample if asked.full_loop else sample[: len(postures) // LOOP_SHARE]
    own, all_s = own_image(world, postures[0]), len(postures) / len(sample)
    over = lambda function, at=postures: lambda: function(world, demo, at)
    once_s = lambda function, *given: call_s(lambda: function(*given))
    why_not = opencv_unavailable(asked.n_points)
    fast = over_range(world, "epipolar", with_condition=True)
    E, condition = batch(world, demo, postures, with_condition=True)
    assert fast.condition is not None and condition is not None
    ours_s, one_s = median_s(lambda: over_range(world, "epipolar")), once_s(E_of_images, "epipolar", demo, own)
    with_condition_s = median_s(lambda: over_range(world, "epipolar", with_condition=True))
    print(f"E over {len(postures)} postures of {asked.scene}, {asked.n_points} points; loops on {len(sample)}, scaled")
    print(row("epipolar", ours_s, ours_s))
    print(row("numpy batch: eigh and solve", median_s(over(batch), 5), ours_s))
    print(row("numpy loop: eigh and lstsq", all_s * median_s(over(loop, postures[sample]), 1), ours_s))
    if not why_not:
        print(row("OpenCV loop: another E", all_s * median_s(over(opencv_loop, postures[sample]), 1), ours_s))
    print(row("epipolar with cond(A)", with_condition_s, with_condition_s))
    print(row("numpy batch with cond(A)", median_s(lambda: batch(world, demo, postures, True), 5), with_condition_s))
    print("one posture, of given images")
    print(row("epipolar", one_s, one_s))
    print(row("numpy loop: eigh and lstsq", once_s(conflict, demo, own), one_s))
    print(why_not or row("OpenCV: another E", once_s(opencv_conflict, demo, own), one_s))
    print("largest relative difference")
    for what, found, expected in (
        ("E to the batch", fast.E.ravel(), E),
        ("E to the loop", fast.E.ravel()[sample], loop(world, demo, postures[sample])),
        ("cond(A) to the batch", fast.condition.ravel(), condition),
    ):
        print(f"  {what:<60} {np.abs(found / expected - 1).max():9.1e}")


if __name__ == "__main__":
    main()

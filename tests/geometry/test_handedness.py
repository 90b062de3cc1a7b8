"""One head sees no body as its own mirror image: a reflection pays what the best other map leaves, and nothing else
pays."""

import numpy as np
import pytest

from viewimit.geometry.handedness import Handedness, principal_axes
from viewimit.geometry.rectification import fit_rectification
from viewimit.simulation.scene import load_scene, scene_names
from viewimit.simulation.world import World

POINTS = 9


def axes_of(rng):
    """(4, 3), any three orthonormal directions of stereo images."""
    return np.linalg.qr(rng.normal(size=(4, 3)))[0]


def bodies(rng, determinant_sign, axes):
    """Images (N, 4) px of a body, and of another by a linear map whose determinant has that sign, but for a rest."""
    shape = rng.normal(size=(POINTS, 3)) * (60, 40, 15)
    A = rng.normal(size=(3, 3))
    A *= np.sign(np.linalg.det(A)) * determinant_sign  # of an odd dimension
    return shape @ axes.T + 200, (shape @ A.T + rng.normal(size=(POINTS, 3))) @ axes.T + 150


def squares_left(demo, own, kernels):
    """(n,) px²: what the least-squares maps that take one direction to 0, (n, 3), leave of centred points (N, 3)."""
    off = np.eye(3) - kernels[:, :, None] * kernels[:, None, :]
    coordinates = demo @ off  # (n, N, 3) of rank 2
    fitted = coordinates @ np.linalg.pinv(coordinates, rcond=1e-9) @ own
    return np.square(own - fitted).sum((1, 2))


def least_squares_of_singular_maps(demo, own, rng):
    """px², searched over the directions that such a map takes to 0: all of them, then ever nearer to the best."""
    kernels, best, near = rng.normal(size=(4000, 3)), None, 1.0
    while near > 1e-5:
        kernels /= np.linalg.norm(kernels, axis=1, keepdims=True)
        left = squares_left(demo, own, kernels)
        best = kernels[left.argmin()]
        near *= 0.5
        kernels = np.concatenate([best[None], best + near * rng.normal(size=(300, 3))])
    return float(left.min())


@pytest.mark.parametrize("seed", range(6))
def test_its_squares_are_those_that_the_best_orientation_preserving_map_adds(seed):
    """The least of a convex function over maps of determinant ≥ 0 is at determinant 0 if it is not within."""
    rng = np.random.default_rng(seed)
    axes = axes_of(rng)
    demo, own = bodies(rng, -1, axes)
    residual = Handedness.from_images(demo, axes).mirror_residual(own)
    found = np.square(residual).sum()
    x, y = ((images - images.mean(0)) @ axes for images in (demo, own))
    unbounded = np.square(y - x @ np.linalg.lstsq(x, y, rcond=None)[0]).sum()
    assert found == pytest.approx(least_squares_of_singular_maps(x, y, rng) - unbounded, rel=1e-6)
    best = np.linalg.lstsq(x, y, rcond=None)[0]
    others = best + np.abs(best).max() * rng.normal(size=(20_000, 3, 3))
    others = others[np.linalg.det(others) > 0]
    assert len(others) > 5000 and (np.square(y - x @ others).sum((1, 2)) >= (unbounded + found) * (1 - 1e-9)).all()


@pytest.mark.parametrize("sign", [-1, 1])
def test_neither_the_choice_of_axes_nor_the_order_of_points_matters(sign):
    rng = np.random.default_rng(1)
    axes = axes_of(rng)
    demo, own = bodies(rng, sign, axes)
    paid = lambda residual: 0.0 if residual is None else np.square(residual).sum()
    first = paid(Handedness.from_images(demo, axes).mirror_residual(own))
    assert (first > 0) == (sign < 0)
    for _ in range(8):
        turned = axes @ np.linalg.qr(rng.normal(size=(3, 3)))[0]  # or mirrored
        order = rng.permutation(POINTS)
        again = Handedness.from_images(demo[order], turned).mirror_residual(own[order])
        assert paid(again) == pytest.approx(first)


def test_principal_axes_span_the_variation():
    rng = np.random.default_rng(2)
    axes = axes_of(rng)
    images = rng.normal(size=(40, 3)) @ axes.T + 100
    found = principal_axes(images)
    np.testing.assert_allclose(found.T @ found, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(found @ found.T, axes @ axes.T, atol=1e-12)


def seen_of(world, rng, postures=20):
    """Images (T, N, 4) px of both bodies in the same postures, rectified if their matches ask for it."""
    thetas = rng.uniform(world.scene.lower, world.scene.upper, (postures, len(world.scene.lower)))
    demo, own = world.demo_images(thetas)[0], world.own_images(thetas)[0]
    by = fit_rectification(*np.split(np.concatenate([demo, own]).reshape(-1, 4), 2, axis=1))
    return (demo, own, None) if by is None else (by.apply(demo), by.apply(own), by)


@pytest.mark.parametrize("name", scene_names())
def test_no_shipped_scene_reflects_in_the_same_posture(name):
    scene = load_scene(name)
    for points in scene.points:
        demo, own, _ = seen_of(World(scene, int(points)), np.random.default_rng(3))
        axes = principal_axes(np.concatenate([demo, own]).reshape(-1, 4))
        for one, other in zip(demo, own):
            handedness = Handedness.from_images(one, axes)
            assert handedness is not None and handedness.mirror_residual(other) is None


def test_swapped_left_and_right_are_a_mirror_image():
    demo, own, _ = seen_of(World(load_scene("panda"), 16), np.random.default_rng(5))
    exchanged = own[..., [2, 3, 0, 1]]
    axes = principal_axes(np.concatenate([demo, exchanged]).reshape(-1, 4))
    assert all(Handedness.from_images(one, axes).is_mirrored(other) is True for one, other in zip(demo, exchanged))


@pytest.mark.parametrize("depth", [3.5, 6.0, 50.0])
def test_noise_hides_the_handedness_but_never_inverts_it(depth):
    """depth: of both bodies, in standard deviations of the noise."""
    rng = np.random.default_rng(7)
    axes, told = axes_of(rng), 0
    for _ in range(400):
        shape = rng.normal(size=(POINTS, 3)) * (90, 50, depth)
        mirrored = bool(rng.integers(2))
        other = shape @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
        if (np.linalg.det(np.linalg.lstsq(shape, other, rcond=None)[0]) < 0) != mirrored:
            other = -other
        demo, own = (one @ axes.T + rng.normal(size=(POINTS, 4)) for one in (shape, other))
        handedness = Handedness.from_images(demo, axes, 1.0)
        found = None if handedness is None else handedness.is_mirrored(own)
        assert found in (None, mirrored)
        told += found is not None
    assert told > 50

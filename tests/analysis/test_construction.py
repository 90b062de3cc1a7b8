"""How one point is recovered: the lines' angle, where it may be, and the steps that are carried over."""

import numpy as np
import pytest

from viewimit.analysis.construction import construct
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.views import FourViews
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

POINT = 3


def of(transfer):
    return Session(Settings.paper(transfer=transfer)).snapshot


def test_lines_cross_at_the_angle_between_their_directions():
    """Oracle: each line drawn by two of its points, as a 3 x 3 fundamental matrix tells them."""
    snapshot = of("epipolar")
    f, f33 = snapshot.fundamental
    demo, found = snapshot.views.demo[POINT], construct(snapshot, POINT)
    for own, pairs in enumerate(((0, 1), (2, 3))):  # (l, L), (r, L); (l, R), (r, R)
        directions = []
        for eye, pair in enumerate(pairs):
            F = np.array([[0, 0, f[pair, 2]], [0, 0, f[pair, 3]], [*f[pair, :2], f33[pair]]])  # qᵀ F p = 0
            a, b, c = F @ [*demo[2 * eye : 2 * eye + 2], 1]
            ends = [np.array([x, -(a * x + c) / b]) for x in (0.0, 100.0)]
            directions.append((ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0]))
        assert np.cos(found.angle[own]) == pytest.approx(abs(directions[0] @ directions[1]), rel=1e-9)


@pytest.mark.parametrize("name", TRANSFERS)
def test_in_95_percent_of_cases_a_point_seen_a_pixel_off_is_recovered_within_the_ellipse(name):
    snapshot, rng, count = of(name), np.random.default_rng(1), 20_000
    found = construct(snapshot, POINT)
    noise = 0.01  # px: linear in it, so that 1 px is a hundred times that
    seen = snapshot.views.demo[POINT] + noise * rng.standard_normal((count, 4))
    away = snapshot.transfer.recover(seen[:, :2], seen[:, 2:]).reshape(count, 2, 2) - found.recovered
    for own in range(2):
        c, s = np.cos(found.direction[own]), np.sin(found.direction[own])
        along = away[:, own] @ np.array([[c, -s], [s, c]])
        inside = (np.square(along / (noise * found.half_axes[own])).sum(1) <= 1).mean()
        assert abs(inside - 0.95) < 5 * np.sqrt(0.95 * 0.05 / count)


def test_three_steps_are_all_that_affine_cameras_need():
    rng = np.random.default_rng(2)
    shape, cameras = rng.standard_normal((10, 3)), rng.standard_normal((2, 3, 4))
    demo, own = (320 + 40 * shape @ camera for camera in cameras)
    snapshot = of("linear").with_fields(views=FourViews(demo, own, np.ones((10, 4), bool)))
    steps = construct(snapshot, POINT).steps
    assert np.allclose(steps[:, 3], steps[:, 4], atol=1e-8)
    assert np.allclose(steps[2:, 4].ravel(), own[POINT], atol=1e-6)


def test_a_point_that_is_not_seen_in_all_four_images_is_not_constructed():
    snapshot = of("epipolar")
    visible = snapshot.views.visible.copy()
    visible[POINT, 1] = False
    hidden = snapshot.with_fields(views=FourViews(snapshot.views.demo, snapshot.views.own, visible))
    assert construct(hidden, POINT) is None and construct(hidden, POINT + 1) is not None

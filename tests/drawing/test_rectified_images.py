"""Images as seen and as rectified: what becomes of rows and of epipolar lines, and what is said without it."""

import numpy as np
import pytest
from drawn import parsed, words

from viewimit.analysis.construction import construct
from viewimit.drawing.images.rectified import draw_rectified, row_distance
from viewimit.estimation.views import FourViews
from viewimit.geometry.affine import LINE_VIEWS, POINT_VIEWS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.appearance import Silhouettes


def seen(**settings):
    return Session(Settings.paper(**settings))


def drawn(session):
    now = session.snapshot
    return draw_rectified(now, Silhouettes({}, session.world).bodies(now.theta_demo, now.theta, now.transfer))


def test_rows_that_differ_as_seen_are_equal_when_rectified():
    session = seen(scene="panda-toed")
    demo = session.snapshot.views.demo
    assert row_distance(demo) == pytest.approx(np.sqrt(np.mean((demo[:, 1] - demo[:, 3]) ** 2)))
    assert row_distance(demo) > 5 > 1e-3 > row_distance(session.snapshot.rectification.apply(demo))
    said = words(drawn(session))
    assert f"rows differ by {row_distance(demo):.2f} px" in said and "rows differ by less than 0.01 px" in said


def test_few_and_no_points_are_drawn():
    for missing in (0.8, 1.0):
        assert parsed(drawn(seen(scene="panda-toed", missing=missing)))


@pytest.mark.parametrize("rectified", [False, True])
def test_the_lines_of_both_eyes_cross_where_the_point_is_recovered_also_in_images_that_are_rectified(rectified):
    """Affine images, and such as a homography makes of them, which rectification takes back: all lines fit exactly."""
    session, rng = seen(scene="panda-toed"), np.random.default_rng(2)
    by = session.snapshot.rectification if rectified else None
    shape, cameras = rng.standard_normal((10, 3)), rng.standard_normal((2, 3, 4))
    demo, own = (320 + 40 * shape @ camera for camera in cameras)
    if by is not None:
        demo, own = by.restore(demo), by.restore(own)
    views = FourViews(demo, own, np.ones((10, 4), bool))
    snapshot = session.snapshot.with_fields(views=views, rectification=by)
    for point in range(10):
        lines, found = snapshot.epipolar_lines(point), construct(snapshot, point)
        for side, view in enumerate((2, 3)):
            from_left, from_right = (lines[(LINE_VIEWS == view) & (POINT_VIEWS == eye)][0] for eye in (0, 1))
            meet = np.cross(from_left, from_right)
            np.testing.assert_allclose(meet[:2] / meet[2], found.recovered[side], atol=1e-6)
            normals = [line[:2] / np.linalg.norm(line[:2]) for line in (from_left, from_right)]
            assert np.cos(found.angle[side]) == pytest.approx(abs(normals[0] @ normals[1]), abs=1e-9)

"""What lies over the drawings of the page: links, and where they are."""

import re

import numpy as np
import pytest
from drawn import parsed
from viewimit.app.drawing.overlays import MIN_HIT, point_places, posture_field

from viewimit.drawing.images.planes import SIZES, image_windows
from viewimit.drawing.posture_plane import PosturePlane
from viewimit.simulation.scene import load_scene


@pytest.fixture(scope="module")
def places():
    """N points, and the places that the style gives them by view: (x, y, radius)."""
    rng = np.random.default_rng(1)
    demo, own = rng.uniform((200, 100) * 2, (280, 170) * 2, (2, 12, 4))
    own[5, :2] = own[4, :2] + 0.1  # nearly the same place in L
    visible = np.ones((12, 4), bool)
    visible[3] = False, True, False, True
    reach = {view: np.array([[195.0, 95.0], [285.0, 175.0]]) for view in "lrLR"}
    style = point_places(demo, own, visible, image_windows(reach, (640, 240)), False)
    hidden = set(re.findall(r"\.vi-at-(\w\d+)\{display:none\}", style))
    found = {}
    for view, i, x, y in re.findall(r"\.vi-at-(\w)(\d+)\{transform:translate\(([\d.]+)px,([\d.]+)px\)\}", style):
        radius = re.search(rf"\.vi-at-{view}{i} \.vi-nearest\{{r:([\d.]+)px", style)
        if view + i not in hidden:
            found[view, int(i)] = np.array([float(x), float(y)]), float(radius[1])
    return found, hidden


class TestPoints:
    def test_what_is_not_seen_cannot_be_touched(self, places):
        found, hidden = places
        assert hidden == {"l3", "L3"} and ("r", 3) in found and len(found) == 46

    def test_of_two_points_the_nearer_is_touched(self, places):
        found, _ = places
        for view in "lrLR":
            there = [place for (other, _), place in found.items() if other == view]
            for k, (one, r) in enumerate(there):
                for other, other_r in there[:k]:
                    assert np.hypot(*(one - other)) >= r + other_r - 0.2 or r == other_r == MIN_HIT
                assert (0 <= one).all() and (one <= SIZES[False][view]).all()


def values(rect) -> list[float]:
    return [float(value) for value in rect.get("data-values").split(",")]


@pytest.mark.parametrize("name", ["panda", "iiwa"])
def test_the_field_of_a_landscape_has_its_postures_where_they_are_drawn(name):
    scene = load_scene(name)
    (field,) = [one for one in parsed(posture_field(scene)).iter("rect") if one.get("data-field") == "posture"]
    left, right, bottom, top = values(field)
    x, y, w, h = (float(field.get(one)) for one in ("x", "y", "width", "height"))
    corners = PosturePlane(scene).place(np.array([[bottom, left], [top, right]]))
    np.testing.assert_allclose(corners, [[x, y + h], [x + w, y]], atol=0.1)
    assert posture_field(load_scene("panda", joints=(1, 2, 3))) == ""

"""What lies over the drawings of the page: links, and where they are."""

import re

import numpy as np
import pytest
from drawn import NEAREST, WAY_FROM_START, classes, marked, parsed, paths
from viewimit.app.drawing.landscapes import describe_basin, draw_basin
from viewimit.app.drawing.overlays import MIN_HIT, motion_field, point_links, point_places, posture_field

from viewimit.analysis.convergence import Basin, Ending
from viewimit.drawing.curves import draw_curves
from viewimit.drawing.images.planes import SIZES, image_windows
from viewimit.drawing.posture_plane import PosturePlane
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
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
    def test_every_point_is_a_link_in_every_image_and_has_a_name_where_tab_stops(self):
        root = parsed(point_links(10, False))
        links = [link for link in root.iter("a") if "point/" in link.get("data-do")]
        assert {link.get("data-do") for link in links} == {f"point/{i}" for i in range(10)}
        stops = [link for link in links if link.get("tabindex") is None]
        assert [link.get("aria-label") for link in stops] == [f"point {i}" for i in range(10)]
        assert all(link.get("href") == "#" for link in links) and len(marked(root, "circle", NEAREST)) == 40

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


def test_both_curves_have_a_field_from_the_first_motion_to_the_end_of_their_axis():
    session = Session(Settings.paper(start_deg=(25, -45)))
    session.run(6)
    assert "data-" not in draw_curves(session.history, 2, None, (2, 4)).split("</svg>")[0]
    fields = [one for one in parsed(motion_field(8)).iter("rect") if one.get("data-field") == "moment"]
    assert [values(one) for one in fields] == [[0, 8]] * 2


class TestBasin:
    STARTS = np.radians([[10, -170], [20, -100], [30, -50], [40, -10], [50, -10]])
    ENDINGS = tuple(
        Ending(start, np.radians([70.0, -20.0]), place, claimed)
        for start, place, claimed in zip(
            STARTS, ("demonstrator", "demonstrator", "smallest E", "elsewhere"), (True, False, True, True)
        )
    )

    def test_each_start_has_a_mark_that_says_where_its_run_ends_and_what_it_claims(self):
        html = draw_basin(load_scene("panda"), Basin(self.STARTS, self.ENDINGS))
        plane, root = PosturePlane(load_scene("panda")), parsed(html)
        kinds = "there", "lowest", "elsewhere", "hollow"
        marks = {kind: [one for one in root.iter() if f"vi-basin-{kind}" in classes(one)] for kind in kinds}
        assert [len(marks[kind]) for kind in kinds] == [2, 1, 1, 1]
        places = plane.place(np.degrees(self.STARTS))
        centres = [(float(mark.get("cx")), float(mark.get("cy"))) for mark in marks["there"]]
        assert np.allclose(centres, places[:2], atol=0.06)
        assert {mark.tag for mark in marks["there"]} == {"circle"} and marks["hollow"] == marks["there"][1:]
        (way,) = paths(html, WAY_FROM_START)
        end = [float(n) for n in re.findall(r"[\d.]+", way)][2:]
        assert np.allclose(end, plane.place(np.array([70, -20])), atol=0.06)
        assert "4 of 5 learners" in html

    def test_the_sentence_counts_them(self):
        text = "".join(parsed(describe_basin(Basin(self.STARTS[:4], self.ENDINGS))).itertext())
        assert (
            text.split()
            == (
                "2 of 4 end at the demonstrator, 1 at the smallest E, 1 elsewhere. "
                "3 claim to have converged (filled), 1 of them falsely."
            ).split()
        )

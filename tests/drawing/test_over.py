"""What lies over the drawings of the page: links, and where they are."""

import re
import zlib

import numpy as np
import pytest
from drawn import NEAREST, WAY_FROM_START, classes, marked, parsed, paths
from viewimit.app.drawing.landscapes import describe_basin, draw_basin
from viewimit.app.drawing.overlays import (
    MIN_HIT,
    hide_later_motions,
    motion_links,
    point_links,
    point_places,
    posture_links,
)

from viewimit.analysis.convergence import Basin, Ending
from viewimit.drawing.curves import axis_end, draw_curves
from viewimit.drawing.images.planes import SIZES, image_windows
from viewimit.drawing.posture_plane import PosturePlane
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene


def actions(html: str) -> list[str]:
    return re.findall(r'data-do="([^"]*)"', html)


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


class TestPostures:
    @pytest.mark.parametrize("name", ["panda", "iiwa"])
    def test_cells_tile_the_landscape_and_each_is_around_its_posture(self, name):
        scene = load_scene(name)
        plane = PosturePlane(scene)
        x, y, w, h = plane.box
        area = 0.0
        for link in parsed(posture_links(scene)).iter("a"):
            up, across = map(float, link.get("data-do").rsplit("/", 1)[1].split(","))
            left, top, right, bottom = map(float, re.findall(r"[\d.]+", link[0].get("d"))[:4])
            top, bottom = sorted((top, bottom))
            px = plane.place(np.array([up, across]))
            assert left - 0.1 <= px[0] <= right + 0.1 and top - 0.1 <= px[1] <= bottom + 0.1
            area += (right - left) * (bottom - top)
        assert area == pytest.approx(w * h, rel=0.01)

    def test_tab_stops_at_some_which_have_names_and_the_picture_is_small(self):
        html = posture_links(load_scene("panda"))
        stops = [link for link in parsed(html).iter("a") if link.get("tabindex") is None]
        assert len(stops) == 15 and "θ₂ 45°, θ₄ −90°" in [link.get("aria-label") for link in stops]
        assert len(zlib.compress(html.encode())) < 12_000

    def test_without_two_joints_there_is_nothing_to_touch(self):
        assert posture_links(load_scene("panda", joints=(1, 2, 3))) == ""


def test_curves_lead_to_every_moment_that_they_show_and_have_no_links_of_their_own():
    session = Session(Settings.paper(start_deg=(25, -45)))
    session.run(6)
    assert actions(draw_curves(session.history, 2, None, (2, 4))) == []
    for width in (424, 860):
        html = motion_links(6, width)
        assert actions(html) == 2 * [f"moment/{k}" for k in range(9)]  # as far as the axis goes
        assert hide_later_motions(6) == "<style>.vi-motions a:nth-child(n+8){display:none}</style>"


@pytest.mark.parametrize("last", [0, 7, 8, 9, 100, 3000])
def test_links_to_moments_stay_as_long_as_the_axis_and_hide_those_to_come(last):
    asked = [int(href.rpartition("/")[2]) for href in actions(motion_links(last))]
    asked = asked[: len(asked) // 2]  # of one plot
    first_hidden = int(re.search(r"n\+(\d+)", hide_later_motions(last))[1]) - 1
    assert max(asked[:first_hidden]) <= last and all(motion > last for motion in asked[first_hidden:])
    assert len(asked) <= 91 and asked[0] == 0
    ends = 4 * (asked[-1] // 4) if last else 8
    assert motion_links(max(last, ends - 1)) == motion_links(last)
    assert motion_links(axis_end(last)) == motion_links(last)


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

"""No label of a landscape covers another, the path, a mark or the inset, whatever robot, range and start."""

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from drawn import (
    INSET,
    JOINT_LABELS,
    LABELS,
    LEARNERS_PATH,
    LED,
    LEVEL_NUMBERS,
    marked,
    only,
    parsed,
    path,
)

from viewimit.analysis.landscape import grid_axes, landscape_over
from viewimit.drawing import posture_plane
from viewimit.drawing.labels import CHARACTER, LINE, Labels
from viewimit.drawing.landscape import LandscapePicture
from viewimit.drawing.posture_plane import PosturePlane
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

SITUATIONS = {
    "default": Settings.paper(),
    "paper": Settings.paper(servo="gradient-retuned", start_deg=(25, -45)),
    "corner": Settings.paper(demonstrator_deg=(85, -5), start_deg=(5, -175)),
    "beside": Settings.paper(demonstrator_deg=(30, -140), start_deg=(32, -138), transfer="linear"),
    "low": Settings.paper(demonstrator_deg=(70, -60), start_deg=(90, 0), transfer="projective", servo="trust-region"),
    "searching": Settings.paper(servo="trust-region", start_deg=(25, -25)),
    "few": Settings.paper(points=5, start_deg=(25, -45)),
    "facing": Settings.paper(scene="panda-facing", start_deg=(25, -45)),
    "iiwa": Settings.paper(scene="iiwa", start_deg=(25, -25)),
    "other joints": Settings.paper(joints=(1, 2)),
    "narrow": Settings.paper(joints=(4, 6)),
}


def drawn(settings):
    """The session after its motions, and all that its landscape shows."""
    session = Session(settings)
    session.run(120)
    views, fit = session.snapshot.views, TRANSFERS[settings.transfer]
    made = landscape_over(session.world, fit, views.demo, views.visible[:, :2], grid_axes(session.world, 3.0))
    picture = LandscapePicture(made, session.scene, session.snapshot)
    return session, parsed(picture.html + picture.draw_path(session.history, session.cursor))


def boxes(root):
    """(k, 4) px of all labels, as wide as they are at most drawn."""
    found = []
    for text in marked(root, "text", LABELS):
        if text.text.startswith("±"):
            continue  # inside the inset
        x, y, half = float(text.get("x")), float(text.get("y")) - 10, 0.45 * CHARACTER * len(text.text)
        found.append((x - half, y, x + half, y + LINE - 3))
    return np.array(found)


def inside(points, box):
    left, top, right, bottom = box
    x, y = points.T
    return (x > left) & (x < right) & (y > top) & (y < bottom)


def require_free(session, root):
    """Labels keep off each other, the path, the marks and the inset."""
    labels = boxes(root)
    assert len(labels) >= 3
    for k, (left, top, right, bottom) in enumerate(labels):
        others = np.delete(labels, k, 0)
        assert ((others[:, 2] < left) | (right < others[:, 0]) | (others[:, 3] < top) | (bottom < others[:, 1])).all()
    corners = np.array(re.findall(r"-?[\d.]+", path(root, LEARNERS_PATH)), float).reshape(-1, 2)
    steps = np.linspace(0, 1, 50)[:, None, None]
    line = (corners[:-1] + steps * np.diff(corners, axis=0)).reshape(-1, 2)
    plane = PosturePlane(session.scene)
    marks = plane.place(np.degrees([session.snapshot.theta_demo, session.snapshot.theta]))
    assert not any(inside(np.concatenate([line, marks]), box).any() for box in labels)
    for frame in marked(root, "rect", INSET):
        x, y, w, h = (float(frame.get(side)) for side in ("x", "y", "width", "height"))
        apart = (labels[:, 2] < x) | (x + w < labels[:, 0]) | (labels[:, 3] < y) | (y + h < labels[:, 1])
        assert apart.all()


@pytest.mark.parametrize("name", SITUATIONS)
def test_labels_keep_off_each_other_the_path_the_marks_and_the_inset(name):
    require_free(*drawn(SITUATIONS[name]))


@pytest.mark.parametrize("name, least", (("paper", 45), ("searching", 1)))
def test_while_the_path_grows_labels_give_way_to_it_and_else_stay_where_they_are(name, least):
    session = Session(SITUATIONS[name])
    views, fit = session.snapshot.views, TRANSFERS[session.settings.transfer]
    made = landscape_over(session.world, fit, views.demo, views.visible[:, :2], grid_axes(session.world, 3.0))
    picture = LandscapePicture(made, session.scene, session.snapshot)
    before, stayed = None, 0
    for _ in range(60):
        root = parsed(picture.draw_path(session.history, session.cursor))
        require_free(session, root)
        levels = [(mark.get("x"), mark.get("y"), mark.text) for mark in marked(root, "text", LEVEL_NUMBERS)]
        stayed += levels == before
        before = levels
        session.step()
    assert stayed >= least


@pytest.mark.parametrize("name", ("paper", "searching", "corner"))
def test_a_label_moves_only_where_the_path_or_the_learners_own_label_needs_its_place(name):
    """Margins: what is kept free of a path, and by how much a label's place is larger than its letters."""
    session = Session(SITUATIONS[name])
    views, fit = session.snapshot.views, TRANSFERS[session.settings.transfer]
    made = landscape_over(session.world, fit, views.demo, views.visible[:, :2], grid_axes(session.world, 3.0))
    picture, plane = LandscapePicture(made, session.scene, session.snapshot), PosturePlane(session.scene)
    before, moved = set(), 0
    for _ in range(60):
        root = parsed(picture.draw_path(session.history, session.cursor))
        numbers = {(float(one.get("x")), float(one.get("y")), one.text) for one in marked(root, "text", LEVEL_NUMBERS)}
        last = plane.place(np.degrees([moment.theta for moment in session.history[max(session.cursor - 1, 0) :]]))
        line = last[0] + np.linspace(0, 1, 200)[:, None] * (last[-1] - last[0])
        own = marked(root, "text", JOINT_LABELS)
        for x, y, words in before - numbers:
            half = CHARACTER * len(words) / 2 + 4 + 10
            met = inside(line, (x - half, y - 12 - 10, x + half, y + 4 + 10)).any()
            assert met or any(
                abs(float(one.get("x")) - x) < half + CHARACTER * len(one.text) / 2
                and abs(float(one.get("y")) - y) < LINE + 3
                for one in own
            )
            moved += 1
        before = numbers
        session.step()
    assert moved


def test_a_label_without_room_is_left_out():
    labels = Labels(0, 0, 100, 20)
    assert "E" in labels.beside(50, 10, "E", "", 4)
    labels.take((0, 0, 100, 20))
    assert labels.beside(50, 10, "E", "", 4) == "" == labels.led(50, 10, "E", LED, True)


def test_a_line_is_kept_free_between_its_corners():
    labels = Labels(0, 0, 200, 200)
    labels.take_line(np.array([[0.0, 100.0], [200.0, 100.0]]), 2)
    assert labels.first_free(np.array([[90.0, 95, 110, 105]])) is None
    assert labels.first_free(np.array([[90.0, 103, 110, 115]])) is not None


def test_a_label_is_told_of_all_that_it_meets_and_of_nothing_else():
    """Oracle: every pair of rectangles, compared."""
    rng, labels = np.random.default_rng(0), Labels(10, 5, 300, 200)
    corner, size = rng.uniform(-20, 320, (300, 2)), rng.uniform(0, 40, (300, 2))
    rectangles = np.concatenate([corner, corner + size], 1)
    labels.take(*rectangles[:60].tolist())
    a, b, c, d = rectangles[:60].T
    inside = [place for place in rectangles[60:] if (place[:2] >= (10, 5)).all() and (place[2:] <= (300, 200)).all()]
    met = [bool(((place[0] < c) & (a < place[2]) & (place[1] < d) & (b < place[3])).any()) for place in inside]
    assert [labels.covers(place) for place in inside] == met
    assert 20 < sum(met) < len(met) - 20


def test_a_plot_without_room_for_the_inset_has_none():
    settings = Settings.paper(transfer="projective")
    session = Session(settings)
    views = session.snapshot.views
    made = landscape_over(
        session.world, TRANSFERS["projective"], views.demo, views.visible[:, :2], grid_axes(session.world)
    )
    assert INSET in LandscapePicture(made, session.scene, session.snapshot).draw_path(session.history, 0)
    narrow = msgspec.structs.replace(session.scene, range_deg=((30.0, 60.0), (-180.0, 0.0)))
    rows = slice(30, 61)
    cut = replace(made, axes=(made.axes[0][rows], made.axes[1]), E=made.E[rows])
    picture = LandscapePicture(cut, narrow, session.snapshot)
    path = picture.draw_path(session.history, 0)
    assert INSET not in path and only(parsed(path), "text", LEVEL_NUMBERS)


def test_the_path_does_not_cross_the_inset():
    """What is drawn later covers it."""
    session = Session(Settings.paper(start_deg=(10, -170)))
    made = landscape_over(
        session.world, session.snapshot.fit, session.snapshot.views.demo, session.snapshot.views.visible[:, :2],
        grid_axes(session.world),
    )  # fmt: skip
    path = LandscapePicture(made, session.scene, session.snapshot).draw_path(session.history, 0)
    assert 0 <= path.index(LEARNERS_PATH) < path.index(INSET)


def test_labels_are_not_placed_anew_when_the_path_crosses_the_lines_that_lead_to_them(monkeypatch):
    placed, start = [], posture_plane.beside  # the start's label, which is made with all others
    monkeypatch.setattr(posture_plane, "beside", lambda *args: placed.append(0) or start(*args))
    session = Session(SITUATIONS["paper"])
    views, fit = session.snapshot.views, TRANSFERS[session.settings.transfer]
    made = landscape_over(session.world, fit, views.demo, views.visible[:, :2], grid_axes(session.world, 3.0))
    picture = LandscapePicture(made, session.scene, session.snapshot)
    session.run(600)  # it wanders about the marks, where these lines begin
    for _ in range(100):
        session.run(2 + session.cursor)
        picture.draw_path(session.history, session.cursor)
    assert len(placed) <= 45

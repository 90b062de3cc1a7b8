"""No label of a landscape covers another, the path, a mark or the inset, whatever robot, range and start."""

import re

import numpy as np
import pytest
from drawn import INSET, LABELS, LEARNERS_PATH, marked, parsed, path

from viewimit.analysis.landscape import grid_axes, landscape_over
from viewimit.drawing.labels import CHARACTER, LINE
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
    "low": Settings.paper(demonstrator_deg=(70, -60), start_deg=(90, 0), transfer="projective", servo="likelihood"),
    "looking": Settings.paper(servo="likelihood", start_deg=(25, -25), noise_px=0.5),
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


def test_the_path_does_not_cross_the_inset():
    """What is drawn later covers it."""
    session = Session(Settings.paper(start_deg=(10, -170)))
    made = landscape_over(
        session.world, session.snapshot.fit, session.snapshot.views.demo, session.snapshot.views.visible[:, :2],
        grid_axes(session.world),
    )  # fmt: skip
    path = LandscapePicture(made, session.scene, session.snapshot).draw_path(session.history, 0)
    assert 0 <= path.index(LEARNERS_PATH) < path.index(INSET)

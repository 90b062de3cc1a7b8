"""Pictures stand where their pixels belong: behind the drawings in the panel, and on the plates in 3-D."""

import re

import numpy as np
import pytest
from drawn import DEMONSTRATORS_POINTS, OWN_POINTS, VIEW_NAME, view_name, written_path

from viewimit.drawing.images.panel import draw_images
from viewimit.drawing.images.planes import image_windows
from viewimit.estimation.views import VIEWS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.appearance import Silhouettes, points_in_images
from viewimit.simulation.robot import link_meshes

PICTURES = {view: f"picture of {view}".encode() for view in VIEWS}


@pytest.fixture(scope="module")
def session():
    return Session(Settings.paper(points=16))


def planes(session, whole, pictures):
    """Of each view: what is drawn in its box."""
    world = session.world
    vertices = {link: mesh.vertices for link, mesh in link_meshes(world.scene.robot).items()}
    now = session.snapshot
    bodies = Silhouettes(vertices, world).bodies(now.theta_demo, now.theta, now.transfer)
    windows = image_windows(points_in_images(bodies), world.scene.head.image)
    drawn = draw_images(session.snapshot, bodies, windows, whole_frames=whole, pictures=pictures)
    parts = re.findall(r"<svg .*?</svg>", drawn, re.DOTALL)
    return {view_name(part): part for part in parts if VIEW_NAME in part}


def number(attribute, text):
    return float(re.search(rf' {attribute}="(-?[\d.]+)"', text)[1])


@pytest.mark.parametrize("whole", [False, True], ids=["windows", "whole frames"])
def test_a_pixel_of_a_picture_is_where_a_point_seen_there_is_drawn(session, whole):
    views, (width, height) = session.snapshot.views, session.scene.head.image
    drawn = planes(session, whole, PICTURES)
    for k, view in enumerate(VIEWS):
        (picture,) = re.findall(r"<image[^>]*>", drawn[view])
        assert 'preserveAspectRatio="none"' in picture
        image = np.concatenate([views.demo, views.own], -1)[:, 2 * k : 2 * k + 2]
        share = image / (width, height)  # of the picture, whose pixel (i, j) covers j … j + 1, i … i + 1
        corner, size = ([number(name, picture) for name in names] for names in (("x", "y"), ("width", "height")))
        if view in "LR":
            path = written_path(drawn[view], OWN_POINTS)
            marks = np.array(re.findall(r"M(-?[\d.]+) (-?[\d.]+)h0", path), float)
        else:
            path = written_path(drawn[view], DEMONSTRATORS_POINTS)
            marks = np.array(re.findall(r"M(-?[\d.]+) (-?[\d.]+)m0-", path), float)
        assert marks == pytest.approx(corner + share * size, abs=0.07)  # drawings have one digit

"""Pictures stand where their pixels belong: behind the drawings in the panel, and on the plates in 3-D."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from drawn import DEMONSTRATORS_POINTS, HULL, OWN_POINTS, SKELETON, VIEW_NAME, view_name, written_path
from viewimit.app import viser_private
from viewimit.app.scene.fixtures import BEHIND, Fixtures
from viewimit.app.scene.nodes import Nodes

from viewimit.drawing.images.panel import draw_images
from viewimit.drawing.images.planes import image_windows
from viewimit.estimation.views import VIEWS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.appearance import Silhouettes, points_in_images
from viewimit.simulation.robot import link_meshes
from viewimit.simulation.scene_geometry import on_plate

PICTURES = {view: f"picture of {view}".encode() for view in VIEWS}


@pytest.fixture(scope="module")
def session():
    return Session(Settings.paper(points=16))


def planes(session, whole, pictures):
    """Of each view: what is drawn in its box."""
    world = session.world
    vertices = {link: mesh.vertices for link, mesh in link_meshes(world.scene.robot).items()}
    bodies = Silhouettes(vertices, world).bodies(session.snapshot)
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


def test_a_picture_is_behind_its_drawing_and_there_is_none_without_one(session):
    drawn = planes(session, False, PICTURES)
    for view in VIEWS:
        assert drawn[view].index("<image") < drawn[view].index(HULL) < drawn[view].index(SKELETON)
    assert all("<image" not in part for part in planes(session, False, {}).values())


class Recording:
    """Stands for viser's scene: keeps what is added, by name."""

    def __init__(self):
        self.nodes = {}

    def __getattr__(self, kind):
        def add(name, *args, **kwargs):
            self.nodes[name] = SimpleNamespace(**{"name": name, "args": args, "visible": True, **kwargs})
            return self.nodes[name]

        return add


def test_pictures_in_3d_are_as_their_cameras_see_them_and_are_sent_once(session, monkeypatch):
    sent = []
    monkeypatch.setattr(viser_private, "push_jpeg", lambda node, picture: sent.append(picture))
    client, world = SimpleNamespace(scene=Recording()), session.world
    stage = Fixtures(client, Nodes(), world, False)
    nodes = client.scene.nodes
    stage.show_pictures(PICTURES)
    stage.show_pictures(PICTURES)
    assert sent == list(PICTURES.values())
    for view, camera in zip(VIEWS, (*world.demo_cameras, *world.own_cameras)):
        node = nodes[f"/stage/picture_{view}"]
        width, height = node.args[1:3]
        w, x, y, z = node.wxyz
        turn = lambda v: np.array(v) + 2 * np.cross((x, y, z), np.cross((x, y, z), v) + w * np.array(v))  # noqa: B023
        for u, v in ((0, 0), (camera.width, 0), (200.5, 31.5)):
            there = node.position + turn(((u / camera.width - 0.5) * width, (v / camera.height - 0.5) * height, 0.0))
            plate = on_plate(camera, np.array([[u, v]]))[0]
            assert there == pytest.approx(plate + BEHIND * camera.T_world_camera[:3, 2])
            eye = camera.T_world_camera[:3, 3]
            along = camera.ray((u, v)) / np.linalg.norm(camera.ray((u, v)))
            assert (plate - eye) @ along == pytest.approx(np.linalg.norm(plate - eye))
        assert not nodes[f"/stage/plate_{view}"].visible
    stage.show_pictures({"l": PICTURES["l"]})
    assert [view for view in VIEWS if nodes[f"/stage/picture_{view}"].visible] == ["l"]
    assert nodes["/stage/plate_L"].visible and not nodes["/stage/plate_l"].visible
